// The enumerations behind the claims against others that are done differently.
#include "analysis/claims/declared_cost.h"
#include "analysis/claims/mask_enumeration.h"
#include "analysis/claims/opacity_statistics.h"
#include "tests/rop/mask_outcomes.h"

#include <cmath>

namespace ropsim {
namespace {

struct Pair {
    MaskEstimate ours;
    test::Estimate theirs;
};

// Against the enumeration that the techniques' own tests use.
TEST(MaskErrors, AreThoseOfTheTestsEnumeration) {
    const std::vector<test::Layer> layers{{0.45, {1, 0, 0}}, {0.3, {0.5, 1, 0}}, {0.7, {0.25, 0.5, 1}}};
    const std::array<double, 3> background{0.25, 0.5, 1};
    MaskPixel pixel{{}, background, 4};
    for (const test::Layer& layer : layers) pixel.layers.push_back({layer.alpha, layer.color});
    const auto correct = test::blended(layers, background);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(blended(pixel)[c], correct[c], 1e-15);
    for (const Pair& pair : {Pair{MaskEstimate::kBasic, test::Estimate::kBasic},
                             Pair{MaskEstimate::kCorrected, test::Estimate::kBasicCorrected},
                             Pair{MaskEstimate::kDepth, test::Estimate::kDepth},
                             Pair{MaskEstimate::kDepthByCoverage, test::Estimate::kDepthCoverage},
                             Pair{MaskEstimate::kDepthByAlpha, test::Estimate::kDepthAccumulated}}) {
        for (int draw = 0; draw < 3; ++draw) {
            const MaskErrors errors = mask_errors(pixel, static_cast<MaskDraw>(draw), pair.ours);
            const auto moments =
                test::exact_moments(pair.theirs, static_cast<test::MaskKind>(draw), layers, 4, background);
            for (std::size_t c = 0; c < 3; ++c) {
                EXPECT_NEAR(errors.mean[c], moments[c].mean, 1e-12) << draw;
                EXPECT_NEAR(errors.rms[c], std::hypot(moments[c].deviation(), moments[c].mean - correct[c]),
                            1e-9)
                    << draw;
            }
        }
    }
}

// Balls one after another: the number of empty bins as a chain.
TEST(EmptyBins, VarianceIsThatOfTheChain) {
    for (const auto& [balls, bins] : {std::pair{1, 1}, {3, 5}, {8, 8}, {20, 7}}) {
        std::vector<double> empty(static_cast<std::size_t>(bins) + 1, 0.0);
        empty.back() = 1;
        for (int ball = 0; ball < balls; ++ball) {
            std::vector<double> next(empty.size(), 0.0);
            for (std::size_t e = 0; e < empty.size(); ++e) {
                const double hit = static_cast<double>(e) / bins;
                if (e > 0) next[e - 1] += empty[e] * hit;
                next[e] += empty[e] * (1 - hit);
            }
            empty = next;
        }
        double mean = 0;
        double square = 0;
        for (std::size_t e = 0; e < empty.size(); ++e) {
            mean += empty[e] * static_cast<double>(e);
            square += empty[e] * static_cast<double>(e * e);
        }
        EXPECT_NEAR(empty_bins_variance(balls, bins), square - mean * mean, 1e-9) << balls << " " << bins;
    }
}

TEST(TwoMasks, CoverAsCounted) {
    double within = 0;
    double all = 0;
    for (std::uint32_t a = 0; a < 256; ++a)
        for (std::uint32_t b = 0; b < 256; ++b) {
            if (std::popcount(a) != 4 || std::popcount(b) != 4) continue;
            all += 1;
            within += std::abs(std::popcount(a | b) - 6) <= 1 ? 1 : 0;
        }
    EXPECT_NEAR(two_masks_cover(8, 4, 5, 7), within / all, 1e-12);
}

TEST(OpacityStatistics, TellSequencesApart) {
    EXPECT_TRUE(spans_stratified({.75, .25, 0, .5, .375, .875, .125, .625}));
    EXPECT_FALSE(spans_stratified({.75, .6, 0, .5, .375, .875, .125, .25}));  // .75, .6 are in one half
    EXPECT_FALSE(spans_stratified({.75, .25, .8, .3}));                       // halves right, quarters not
    EXPECT_TRUE(aligned_spans_stratified(OpacityHash::kPaper, 2));
    EXPECT_EQ(farthest_from_share(8, 2000), 0);
    const double exact = 1 - std::pow(0.9, 8);
    const Coverage biased = mean_coverage(OpacityHash::kRadicalInverse, 0.1, 8, 8, 1024);
    EXPECT_NEAR(biased.mean, 0.1, 1e-3);
    const Coverage hashed = mean_coverage(OpacityHash::kImproved, 0.1, 8, 8, 4096);
    EXPECT_NEAR(hashed.mean, exact, 4.5 * hashed.standard_error);
    EXPECT_GT(largest_correlation(OpacityHash::kRadicalInverse, 1 << 12), 0.9);
    EXPECT_LT(largest_correlation(OpacityHash::kPaper, 1 << 16), 0.01);
}

// By hand: 4 samples of 64 bits; three passes for 8 samples at a time, two more for the next 8.
TEST(DeclaredCost, IsTheTechniques) {
    EXPECT_EQ(declared_cost("stochastic:samples=4").storage_bits, 256);
    EXPECT_EQ(declared_cost("stochastic:samples=4").bytes(), 48);
    EXPECT_EQ(declared_cost("stochastic:samples=4").geometry_passes, 1);
    const char* rounds = "stochastic:method=depth_based,samples=16,hardware_samples=8";
    EXPECT_EQ(declared_cost(rounds).geometry_passes, 5);
    EXPECT_EQ(declared_cost("adaptive:nodes=8").geometry_passes, 2);
}

}  // namespace
}  // namespace ropsim
