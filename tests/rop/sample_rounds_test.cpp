// More samples than are stored at a time (Enderton et al. 2011, section 3.5 and notes 3 and 4): passes,
// strata across rounds, and sums that are divided at the end.
#include "tests/rop/mask_outcomes.h"

namespace ropsim {
namespace {

using test::Estimate;
using test::Layer;
using test::MaskKind;
using test::TestFrame;

struct PassCount {
    int geometry = 0;
    int image = 0;
};
PassCount passes_of(const std::string& technique) {
    const auto operation = TestFrame::make(technique, test::header_of(1, 1));
    PassCount count;
    for (PassSequence sequence(operation->declaration()); !sequence.done(); sequence.advance(0))
        ++(sequence.current().kind == PassKind::kGeometry ? count.geometry : count.image);
    return count;
}

// 3.5: "only two extra passes are needed for each additional eight samples, for a total of 1 + 2(S/8)".
TEST(Passes, OfTheDepthBasedMethodAreOneAndTwoForEachEightSamples) {
    for (const auto& [samples, passes] : {std::pair(8, 3), {16, 5}, {32, 9}, {64, 17}})
        for (const char* technique : {"stochastic", "laine_karras"}) {
            const std::string text = technique +
                                     std::string(":method=depth_based,hardware_samples=8,samples=") +
                                     std::to_string(samples);
            EXPECT_EQ(passes_of(text).geometry, passes);
            EXPECT_EQ(passes_of(text).image, 0) << "U and U1 add up where they are";
            // F(B1) is of samples that the next round overwrites.
            EXPECT_EQ(passes_of(text + ",correction=coverage").image, samples == 8 ? 0 : samples / 8);
        }
}

// Section 3.5 ends with total alpha beside colour in one pass; without correction there is none.
TEST(Passes, MergedOrUncorrectedAreOneLess) {
    EXPECT_EQ(passes_of("stochastic:method=depth_based,passes=merged").geometry, 2);
    EXPECT_EQ(passes_of("stochastic:method=depth_based,correction=none").geometry, 2);
    EXPECT_EQ(passes_of("stochastic:correction=coverage").geometry, 2);
    EXPECT_EQ(passes_of("stochastic:correction=coverage,passes=merged").geometry, 1);
    EXPECT_EQ(passes_of("stochastic").geometry, 1);
    EXPECT_EQ(passes_of("stochastic:samples=64,hardware_samples=8").geometry, 8);
    EXPECT_EQ(passes_of("stochastic:samples=64,hardware_samples=8,correction=coverage").geometry, 9);
}

// Samples that one fragment a pixel takes in each round, rounds one after the other.
std::vector<std::uint64_t> masks_of_rounds(const std::string& technique, float alpha, int hardware_samples) {
    TestFrame frame(technique + ",method=depth_based,correction=none", test::header_of(64, 64), 3);
    const auto fragments =
        test::everywhere(frame.header(), {test::fragment_at(0, 0, 0.5f, alpha, {1, 1, 1})});
    std::vector<std::uint64_t> masks(fragments.size(), 0);
    for (PassSequence sequence(frame.declaration()); !sequence.done(); sequence.advance(0)) {
        if (sequence.current().name != "stochastic_depth") continue;
        if (sequence.round() > 0) frame.store().restore(sequence.current().restores);
        frame.log().clear_records();
        frame.draw_pass(sequence.pass(), fragments, sequence.round());
        for (std::size_t i = 0; i < masks.size(); ++i)
            masks[i] |= frame.log().record_access(i)[0].write << (sequence.round() * hardware_samples);
    }
    return masks;
}

// Note 3's extra care: rounds of 8 take the parts of one stratified mask of 16 or 64, bit for bit.
class Strata : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Masks, Strata,
                         testing::Values("choose", "coin", "run", "table", "blue_noise", "alpha_to_coverage"),
                         [](const auto& setup) { return std::string(setup.param); });
TEST_P(Strata, AcrossRoundsAreThoseOfOneRound) {
    for (const int samples : {16, 64}) {
        const std::string text =
            "stochastic:masks=" + std::string(GetParam()) + ",samples=" + std::to_string(samples);
        const auto one = masks_of_rounds(text, 0.45f, samples);
        EXPECT_EQ(masks_of_rounds(text + ",hardware_samples=8", 0.45f, 8), one);
        EXPECT_EQ(masks_of_rounds(text + ",hardware_samples=8,strata=all", 0.45f, 8), one);
        // Alone, a round's mask is of its own size: the same in number of samples, other samples.
        if (std::string(GetParam()) == "alpha_to_coverage") continue;
        EXPECT_NE(masks_of_rounds(text + ",hardware_samples=8,strata=pass", 0.45f, 8), one);
    }
}

// A pixel's references go on where the round before ended: 5/16 takes 5 of 16 samples, in rounds of 8 by
// themselves 2 or 3 each.
TEST(LaineKarrasRounds, GoOnInThePixelsSpan) {
    for (const std::uint64_t mask :
         masks_of_rounds("laine_karras:samples=16,hardware_samples=8", 5.0f / 16, 8))
        ASSERT_EQ(std::popcount(mask), 5);
    std::map<int, int> counts;
    for (const std::uint64_t mask :
         masks_of_rounds("laine_karras:samples=16,hardware_samples=8,strata=pass", 5.0f / 16, 8)) {
        for (const int round : {0, 8}) {
            const int taken = std::popcount(mask >> round & 0xFF);
            ASSERT_TRUE(taken == 2 || taken == 3) << taken;
        }
        ++counts[std::popcount(mask)];
    }
    EXPECT_EQ(counts.size(), 3u);
}

// Of one layer of .45 the number taken is floor(S alpha) or one more: variance f (1 - f) of the fraction f.
// Sixteen samples: .2 x .8 / 16^2. Two independent eights: 2 x .6 x .4 / 16^2, three times as much.
TEST(Notes, TwoImagesOfEightAreNoisierThanOneOfSixteen) {
    const auto moments = [](double fraction, int rounds) {
        std::vector<std::pair<double, double>> outcomes;
        const double low = std::floor(0.45 * 16 / rounds);
        for (int more = 0; more <= rounds; ++more)
            outcomes.emplace_back((low * rounds + more) / 16, test::binomial(rounds, more) *
                                                                  std::pow(fraction, more) *
                                                                  std::pow(1 - fraction, rounds - more));
        return test::moments_of(outcomes);
    };
    const test::Moments all = moments(0.2, 1);
    const test::Moments pass = moments(0.6, 2);
    EXPECT_NEAR(all.variance, 0.000625, 1e-9);
    EXPECT_NEAR(pass.variance, 0.001875, 1e-9);
    const std::vector<Fragment> layer = {test::fragment_at(0, 0, 0.5f, 0.45f, {1, 1, 1})};
    const std::string rounds = "stochastic:format=float32,samples=16,hardware_samples=8";
    test::expect_moments(rounds, layer, glm::vec3(0.0f), 0, all);
    test::expect_moments(rounds + ",strata=pass", layer, glm::vec3(0.0f), 0, pass);
    // The method's image is the sixteen-sample one, not only as noisy.
    EXPECT_EQ(test::image_of_layers(rounds, layer, glm::vec3(0.0f)),
              test::image_of_layers("stochastic:format=float32,samples=16", layer, glm::vec3(0.0f)));
}

// Every estimate over rounds is the one of all samples at once: sums are divided at the end.
TEST(Notes, RoundsAddUpToTheImageOfAllSamples) {
    test::Random random(61);
    const TraceHeader header = test::opaque_header(24, 24, 1, random);
    test::FragmentOptions options;
    options.count = std::size_t{24} * 24 * 6;
    options.distinct_depths = true;
    const auto fragments = test::random_fragments(header, options, random);
    for (const Estimate e : {Estimate::kBasic, Estimate::kBasicCorrected, Estimate::kDepth,
                             Estimate::kDepthCoverage, Estimate::kDepthAccumulated})
        for (const MaskKind kind : {MaskKind::kChoose, MaskKind::kCoin}) {
            const std::string technique = test::technique_of(e, kind, 16);
            const auto one = test::image_of(technique, header, fragments);
            for (const char* hardware : {",hardware_samples=8", ",hardware_samples=2"}) {
                const auto rounds = test::image_of(technique + hardware, header, fragments);
                for (std::size_t i = 0; i < one.size(); ++i)
                    ASSERT_NEAR(rounds[i], one[i], 1e-5) << technique << hardware;
            }
        }
}

// D over two independent rounds: of sums, and as the average of the rounds' own D.
struct OverTwoRounds {
    test::Moments ratio_of_averages;
    test::Moments average_of_ratios;
};
OverTwoRounds over_two_rounds(const std::vector<Layer>& layers, int samples) {
    struct Sum {
        double u = 0, u1 = 0, p = 0;
    };
    std::vector<Sum> rounds;
    test::for_masks(
        MaskKind::kChoose, layers, samples, [&](const std::vector<std::uint32_t>& masks, double p) {
            const auto u = test::estimated(Estimate::kDepth, layers, masks, samples, {0, 0, 0}, 1);
            rounds.push_back({u[0], u[0] + u[1], p});
        });
    std::vector<std::pair<double, double>> of_averages;
    std::vector<std::pair<double, double>> of_ratios;
    const double total = test::total_alpha(layers);
    for (const Sum& a : rounds)
        for (const Sum& b : rounds) {
            of_averages.emplace_back(total * (a.u + b.u) / (a.u1 + b.u1), a.p * b.p);
            of_ratios.emplace_back(total * (a.u / a.u1 + b.u / b.u1) / 2, a.p * b.p);
        }
    return {test::moments_of(of_averages), test::moments_of(of_ratios)};
}

// Note 4: "it is best to average U and U_1 separately and divide at the end". One sample a round of red, .2,
// over green, .8: the bias in red falls from .102 to .031, the RMS error from .216 to .138.
TEST(Notes, AveragesAreDividedAtTheEnd) {
    const std::vector<Layer> layers = {{0.2, {1, 0, 0}}, {0.8, {0, 1, 0}}};
    const OverTwoRounds d = over_two_rounds(layers, 1);
    EXPECT_NEAR(d.ratio_of_averages.mean - 0.2, 0.03072, 5e-6);
    EXPECT_NEAR(d.average_of_ratios.mean - 0.2, 0.10240, 5e-6);
    EXPECT_NEAR(std::hypot(d.ratio_of_averages.mean - 0.2, d.ratio_of_averages.deviation()), 0.13816, 5e-6);
    EXPECT_NEAR(std::hypot(d.average_of_ratios.mean - 0.2, d.average_of_ratios.deviation()), 0.21590, 5e-6);
    test::expect_moments(test::technique_of(Estimate::kDepthAccumulated, MaskKind::kChoose, 2) +
                             ",hardware_samples=1,strata=pass",
                         test::fragments_of(layers), glm::vec3(0.0f), 0, d.ratio_of_averages);
}

// It is best for the bias, which an average of ratios keeps for any number of rounds, and not always for the
// error: Example 1's layers in two rounds of two samples have .0276 in red, against .0249.
TEST(Notes, DividingAtTheEndCanCostVariance) {
    const OverTwoRounds d = over_two_rounds({{0.45, {1, 0, 0}}, {0.45, {0, 1, 0}}}, 2);
    EXPECT_NEAR(d.ratio_of_averages.mean - 0.45, 0.00188, 5e-6);
    EXPECT_NEAR(d.average_of_ratios.mean - 0.45, 0.003375, 5e-6);
    EXPECT_NEAR(std::hypot(d.ratio_of_averages.mean - 0.45, d.ratio_of_averages.deviation()), 0.02758, 5e-6);
    EXPECT_NEAR(std::hypot(d.average_of_ratios.mean - 0.45, d.average_of_ratios.deviation()), 0.02489, 5e-6);
}

}  // namespace
}  // namespace ropsim
