// What Enderton et al. 2011 say about samples and their masks: thin media as balls in bins (3.1), how well
// two random masks overlap (6), how many masks there are (5).
#include "tests/rop/mask_outcomes.h"
#include "tests/rop/sampling_statistics.h"

namespace ropsim {
namespace {

using test::MaskKind;
using test::TestFrame;

// Distribution of the number of occupied bins once `balls` have been dropped into `bins`.
std::vector<double> occupied_bins(int balls, int bins) {
    std::vector<double> p(static_cast<std::size_t>(bins) + 1, 0.0);
    p[0] = 1;
    for (int b = 0; b < balls; ++b)
        for (std::size_t k = p.size() - 1; k < p.size(); --k) {
            const double stay = static_cast<double>(k) / bins;
            p[k] = p[k] * stay + (k == 0 ? 0 : p[k - 1] * (1 - static_cast<double>(k - 1) / bins));
        }
    return p;
}

// 3.1: S layers of alpha 1/S are S balls in S bins. Variance / S tends to 1/e - 2/e^2, so that the RMS error
// falls as 1 / sqrt(S) and not as 1 / S.
TEST(ThinMedia, ErrorFallsAsTheRootOfTheSamples) {
    std::vector<double> rms;
    for (const int samples : {8, 16, 32, 64}) {
        std::vector<std::pair<double, double>> outcomes;
        const auto occupied = occupied_bins(samples, samples);
        for (std::size_t k = 0; k < occupied.size(); ++k)
            outcomes.emplace_back(static_cast<double>(k) / samples, occupied[k]);
        const test::Moments m = test::moments_of(outcomes);
        // Of the number of empty bins, in closed form.
        const double s = samples;
        const double empty = s * std::pow(1 - 1 / s, s);
        const double variance = empty + s * (s - 1) * std::pow(1 - 2 / s, s) - empty * empty;
        EXPECT_NEAR(m.variance * s * s, variance, 1e-9);
        EXPECT_NEAR(m.mean, 1 - std::pow(1 - 1 / s, s), 1e-12);
        rms.push_back(m.deviation());

        const float alpha = 1.0f / static_cast<float>(samples);
        std::vector<Fragment> layers;
        for (int i = 0; i < samples; ++i)
            layers.push_back(test::fragment_at(0, 0, 0.2f + 0.01f * static_cast<float>(i), alpha, {1, 1, 1},
                                               static_cast<std::uint32_t>(i)));
        test::expect_moments(
            test::image_of_layers("stochastic:format=float32,samples=" + std::to_string(samples), layers,
                                  glm::vec3(0.0f), 96),
            0, m);
    }
    EXPECT_NEAR(rms[0] * std::sqrt(8.0), 0.3160, 5e-5);
    EXPECT_NEAR(rms[3] * std::sqrt(64.0), std::sqrt(std::exp(-1.0) - 2 * std::exp(-2.0)), 1e-3);
    for (std::size_t i = 1; i < rms.size(); ++i)
        EXPECT_NEAR(std::log2(rms[i] / rms[i - 1]), -0.5, 0.011) << "slope";
}

// Section 6: two fragments of alpha 1/2, S = 8: 6 samples covered, within one "97 percent of the time".
TEST(MaskOverlap, TwoHalfTransparentFragmentsCoverSixOfEight) {
    double close = 0;
    test::for_masks(MaskKind::kChoose, std::vector<test::Layer>(2, {0.5, {1, 1, 1}}), 8,
                    [&](const std::vector<std::uint32_t>& masks, double p) {
                        if (std::abs(std::popcount(masks[0] | masks[1]) - 6) <= 1) close += p;
                    });
    EXPECT_NEAR(close, 34.0 / 35.0, 1e-12);
    EXPECT_NEAR(close, 0.97143, 5e-6);
    const auto image = test::image_of_layers("stochastic:samples=8",
                                             {test::fragment_at(0, 0, 0.5f, 0.5f, {1, 1, 1}, 0),
                                              test::fragment_at(0, 0, 0.4f, 0.5f, {1, 1, 1}, 1)},
                                             glm::vec3(0.0f));
    double counted = 0;
    for (std::size_t i = 0; i < image.size(); i += 3)
        counted += std::abs(8 * image[i] - 6) < 1.5f ? 3.0 / static_cast<double>(image.size()) : 0;
    EXPECT_NEAR(counted, close, 4 * std::sqrt(close * (1 - close) * 3 / static_cast<double>(image.size())));
}

// Section 5 counts the masks of S choose R: alpha 1/2 has 70 of 8 samples and 12,870 of 16. All occur, all as
// often; runs are 8 and 16.
TEST(MaskCounts, AllSubsetsOfHalfTheSamplesOccurAlike) {
    struct Case {
        const char* technique;
        int masks;
        int frames;
    };
    for (const Case& c :
         {Case{"stochastic:samples=8", 70, 1}, Case{"stochastic:samples=16", 12870, 4},
          Case{"stochastic:samples=8,masks=run", 8, 1}, Case{"stochastic:samples=16,masks=run", 16, 1}}) {
        std::map<std::uint64_t, int> counts;
        for (int seed = 0; seed < c.frames; ++seed) {
            TestFrame frame(c.technique, test::header_of(256, 256), static_cast<std::uint64_t>(seed));
            frame.draw(test::everywhere(frame.header(), {test::fragment_at(0, 0, 0.5f, 0.5f, {1, 1, 1})}));
            for (std::size_t i = 0; i < frame.log().records(); ++i)
                ++counts[frame.log().record_access(i)[0].write];
        }
        EXPECT_EQ(counts.size(), static_cast<std::size_t>(c.masks)) << c.technique;
        EXPECT_LT(test::chi_square(counts, c.masks), test::chi_square_limit(c.masks - 1)) << c.technique;
    }
}

}  // namespace
}  // namespace ropsim
