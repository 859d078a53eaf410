// Bias and consistency of stochastic transparency's estimates: Enderton et al. 2011, section 4, by
// enumeration and from the technique's pixels.
#include "tests/rop/mask_outcomes.h"

namespace ropsim {
namespace {

using test::Estimate;
using test::Layer;
using test::MaskKind;
using test::Random;

constexpr glm::vec3 kBlack(0.0f);

std::array<test::Moments, 3> expect_exact(Estimate estimate, const std::vector<Layer>& layers, int samples) {
    const auto m = test::exact_moments(estimate, MaskKind::kChoose, layers, samples, {0, 0, 0});
    const std::string technique = test::technique_of(estimate, MaskKind::kChoose, samples);
    for (std::size_t c = 0; c < 3; ++c)
        test::expect_moments(technique, test::fragments_of(layers), kBlack, c, m[c]);
    return m;
}

// 4.1: red over green, alphas 1/S, S = 4. A has (.2734, .1641) where C = (.25, .1875); D has no bias here.
TEST(Bias, OfTwoFragmentsOfOneSampleEach) {
    const std::vector<Layer> layers = {{0.25, {1, 0, 0}}, {0.25, {0, 1, 0}}};
    const auto a = expect_exact(Estimate::kBasicCorrected, layers, 4);
    EXPECT_NEAR(a[0].mean, 0.2734375, 1e-12);
    EXPECT_NEAR(a[1].mean, 0.1640625, 1e-12);
    for (const Estimate unbiased : {Estimate::kBasic, Estimate::kDepth, Estimate::kDepthAccumulated}) {
        const auto d = expect_exact(unbiased, layers, 4);
        EXPECT_NEAR(d[0].mean, 0.25, 1e-12);
        EXPECT_NEAR(d[1].mean, 0.1875, 1e-12);
    }
}

// 4.1: one layer of alpha 1/(2S) leaves half the pixels empty, and the others twice as bright as they should
// be divided by their one sample: on average half of alpha, for every S. U1 is never 0 (4.2): D is exact.
TEST(Bias, EmptyPixelsHalveAThinLayer) {
    for (const int samples : {4, 8, 32}) {
        const float alpha = 0.5f / static_cast<float>(samples);
        const std::vector<Fragment> layer = {test::fragment_at(0, 0, 0.5f, alpha, {1, 1, 1})};
        const auto a = test::image_of_layers(
            test::technique_of(Estimate::kBasicCorrected, MaskKind::kChoose, samples), layer, kBlack);
        std::size_t empty = 0;
        for (std::size_t i = 0; i < a.size(); i += 3) {
            ASSERT_TRUE(a[i] == 0.0f || std::abs(a[i] - alpha) < 1e-6f) << a[i];
            empty += a[i] == 0.0f ? 1 : 0;
        }
        const double pixels = static_cast<double>(a.size()) / 3;
        EXPECT_NEAR(static_cast<double>(empty) / pixels, 0.5, 4 * 0.5 / std::sqrt(pixels)) << samples;
        for (const Estimate exact : {Estimate::kDepth, Estimate::kDepthAccumulated})
            for (const float d :
                 test::image_of_layers(test::technique_of(exact, MaskKind::kChoose, samples), layer, kBlack))
                ASSERT_NEAR(d, alpha, 1e-6);
    }
}

// 4.2: one sample of six fragments. Where fragment w wins, D is the mean of the colours up to w weighted by
// alpha alone, times total alpha; w = 7 where the sample is empty.
TEST(Bias, OneSampleOfSixFragments) {
    Random random(51);
    std::vector<Layer> layers;
    for (int i = 0; i < 6; ++i)
        layers.push_back({static_cast<double>(random.real(0.1, 0.5)), {random.unit(), random.unit(), 1}});
    const double total = test::total_alpha(layers);
    std::vector<std::array<double, 2>> expected;  // of w from 1
    std::vector<double> probability;
    std::array<double, 3> u{};
    double clear = 1;
    for (const Layer& l : layers) {
        for (std::size_t c = 0; c < 3; ++c) u[c] += l.alpha * l.color[c];
        expected.push_back({total * u[0] / u[2], total * u[1] / u[2]});
        probability.push_back(clear * l.alpha);
        clear *= 1 - l.alpha;
    }
    probability.back() += clear;  // all six are summed where none wins, too
    std::vector<double> count(6, 0);
    const auto image =
        test::image_of_layers(test::technique_of(Estimate::kDepthAccumulated, MaskKind::kCoin, 1),
                              test::fragments_of(layers), kBlack);
    for (std::size_t i = 0; i < image.size(); i += 3) {
        const auto winner = std::ranges::find_if(expected, [&](const std::array<double, 2>& d) {
            return std::abs(d[0] - image[i]) < 1e-5 && std::abs(d[1] - image[i + 1]) < 1e-5;
        });
        ASSERT_NE(winner, expected.end()) << image[i];
        ++count[static_cast<std::size_t>(winner - expected.begin())];
    }
    const double pixels = static_cast<double>(image.size()) / 3;
    for (std::size_t w = 0; w < 6; ++w)
        EXPECT_NEAR(count[w] / pixels, probability[w],
                    4 * std::sqrt(probability[w] * (1 - probability[w]) / pixels));
}

std::vector<Layer> random_layers(int count, Random& random) {
    std::vector<Layer> layers;
    for (int i = 0; i < count; ++i)
        layers.push_back({static_cast<double>(random.real(0.02, 0.98)),
                          {static_cast<double>(random.real(0, 1)), static_cast<double>(random.real(0, 1)),
                           static_cast<double>(random.real(0, 1))}});
    return layers;
}

// 4: E(B) = C, and 4.2: E(U) = C, for any alphas: by enumeration for every kind of mask.
TEST(Bias, BasicAndUncorrectedDepthBasedHaveNone) {
    Random random(52);
    for (int i = 0; i < 20; ++i) {
        const auto layers = random_layers(3, random);
        const std::array<double, 3> background = {random.unit(), random.unit(), random.unit()};
        const auto c = test::blended(layers, background);
        for (const MaskKind kind : {MaskKind::kCoin, MaskKind::kChoose, MaskKind::kRun})
            for (const Estimate e : {Estimate::kBasic, Estimate::kDepth}) {
                const auto m = test::exact_moments(e, kind, layers, 4, background);
                for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(m[k].mean, c[k], 1e-12);
            }
    }
}

// The same of the techniques' pixels, drawn in random order of depth.
class Expectation : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Techniques, Expectation,
                         testing::Values("stochastic:", "stochastic:masks=coin,", "stochastic:masks=run,",
                                         "stochastic:masks=table,", "stochastic:depth_test=first,",
                                         "stochastic:masks=blue_noise,", "laine_karras:"),
                         [](const auto& setup) {
                             std::string name = setup.param;
                             std::erase_if(name, [](char c) { return std::isalnum(c) == 0; });
                             return name;
                         });
TEST_P(Expectation, OfBasicAndUncorrectedDepthBasedIsTheBlendedColor) {
    Random random(53);
    constexpr int kSide = 128;
    for (int i = 0; i < 4; ++i) {
        const auto layers = random_layers(5, random);
        auto fragments = test::fragments_of(layers);
        random.shuffle(fragments);
        const auto c = test::blended(layers, {1, 0.5, 0});
        for (const char* method : {"", ",method=depth_based,correction=none"}) {
            const std::string technique = GetParam() + std::string("samples=8,format=float32") + method;
            const auto image = test::image_of_layers(technique, fragments, {1, 0.5f, 0}, kSide);
            for (std::size_t k = 0; k < 3; ++k) {
                const test::Moments m = test::moments_of(image, k);
                EXPECT_NEAR(m.mean, c[k], 4 * m.deviation() / kSide + 2e-4) << technique << " " << k;
            }
        }
    }
}

// 4.2: D is consistent, A is where no pixel can be empty. The error falls as 1/sqrt(S) or better, from 4 to
// 64 samples to a quarter at most.
TEST(Bias, CorrectedErrorsFallWithTheSamples) {
    Random random(54);
    for (int i = 0; i < 3; ++i) {
        auto layers = random_layers(4, random);
        layers[0].alpha = 0.4;  // never without a sample
        const auto c = test::blended(layers, {0, 0, 0});
        for (const Estimate e : {Estimate::kBasicCorrected, Estimate::kDepthAccumulated}) {
            std::vector<double> rms;
            for (const int samples : {4, 16, 64}) {
                const auto image = test::image_of_layers(test::technique_of(e, MaskKind::kChoose, samples),
                                                         test::fragments_of(layers), kBlack, 64);
                double sum = 0;
                for (std::size_t p = 0; p < image.size(); ++p) sum += std::pow(image[p] - c[p % 3], 2);
                rms.push_back(std::sqrt(sum / static_cast<double>(image.size())));
            }
            EXPECT_LT(rms[1], 0.58 * rms[0]);
            EXPECT_LT(rms[2], 0.28 * rms[0]);
        }
    }
}

}  // namespace
}  // namespace ropsim
