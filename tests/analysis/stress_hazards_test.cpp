// The hazards that stored formats are known for, each reproduced by its format and cured by another.
#include "analysis/stress/stress_hazards.h"

#include "analysis/stress/light_bound.h"
#include "analysis/stress/stress_inputs.h"
#include "rop/double_reading/double_pixel.h"
#include "rop/single_pixel.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

// Black layers of one alpha before white: what comes out is the transmittance.
PixelScene black_layers(int layers, float alpha, float color = 0) {
    PixelScene scene;
    scene.background = glm::vec3(1.0f);
    for (int i = 0; i < layers; ++i)
        scene.fragments.push_back({static_cast<float>(i + 1) / static_cast<float>(layers + 1), color * alpha,
                                   color * alpha, color * alpha, alpha, 0, 0, static_cast<std::uint32_t>(i),
                                   1, 0});
    return scene;
}
TraceHeader header() {
    return layer_input("even", 1, 0).header;
}
struct Shown {
    double value = 0;
    int bits = 0;
};
Shown run(const std::string& technique, const PixelScene& scene) {
    const auto pixel = make_single_pixel(technique, header(), 0);
    return {pixel->run(scene)[0], pixel->technique().bits};
}

// 8 bits lose a factor 1 - a as soon as it takes less than half a code: at 0.5 / a codes the product stalls.
TEST(FormatHazards, EightBitRevealageStalls) {
    for (const float a : {0.01f, 0.005f}) {
        const PixelScene scene = black_layers(4096, a);
        const Shown stalled = run("weighted_blended:format=float32,revealage_format=unorm8", scene);
        EXPECT_NEAR(stalled.value, 0.5 / static_cast<double>(a) / 255, 1.0 / 255);
        EXPECT_NEAR(stalled.value, std::floor(0.5 / static_cast<double>(a)) / 255, 1e-3);
        // Eight bits more do.
        const Shown cured = run("weighted_blended:format=float32,revealage_format=float16", scene);
        EXPECT_NEAR(cured.value, std::pow(1.0 - static_cast<double>(a), 4096), 1.0 / 255);
        EXPECT_EQ(cured.bits - stalled.bits, 8);
    }
    // Below half a code of 1 it never moves.
    EXPECT_EQ(
        run("weighted_blended:format=float32,revealage_format=unorm8", black_layers(4096, 0.00195f)).value,
        1.0);
}

TEST(FormatHazards, EightBitCoverageOfPhenomenologicalTransparencyStalls) {
    const PixelScene scene = black_layers(4096, 0.01f);
    const Shown stalled = run("phenomenological:form=alpha", scene);
    EXPECT_NEAR(stalled.value, 50.0 / 255, 1.0 / 255);
    const Shown cured = run("phenomenological:form=alpha,format=float32", scene);
    EXPECT_LT(cured.value, 1.0 / 255);
    EXPECT_GT(cured.bits, stalled.bits);
}

// Intel's one-pass technique cuts bits off at each store.
TEST(FormatHazards, TruncationDarkensThinMedia) {
    const PixelScene scene = black_layers(200, 0.0018f);
    const double exact = std::pow(1.0 - 0.0018, 200);
    const Shown cut = run("aoit", scene);
    EXPECT_NEAR(exact, 0.70, 0.005);
    EXPECT_NEAR(cut.value, 0.22, 0.02);
    const Shown cured = run("aoit:transmittance_format=float16,transmittance_rounding=nearest", scene);
    EXPECT_NEAR(cured.value, exact, 1.0 / 255);
    EXPECT_GT(cured.bits, cut.bits);
}

// Half of 8 bits: alphas below 1/510 are no layer at all.
TEST(FormatHazards, EightBitLayersLoseThinFragments) {
    const PixelScene scene = black_layers(300, 0.0019f);
    const double exact = std::pow(1.0 - static_cast<double>(0.0019f), 300);
    EXPECT_EQ(run("mlab:layers=4,format=float32,transmittance_format=unorm8", scene).value, 1.0);
    const Shown cured = run("mlab:layers=4,format=float32,transmittance_format=unorm16", scene);
    EXPECT_NEAR(cured.value, exact, 1.0 / 255);
    EXPECT_EQ(cured.bits - run("mlab:layers=4,format=float32,transmittance_format=unorm8", scene).bits,
              4 * 8);
}

// binary16: sums above 2048 times a term stand still, and beyond 65504 they are infinite.
TEST(FormatHazards, HalfSumsStagnate) {
    const PixelScene scene = black_layers(100'000, 0.01f, 0.5f);
    const auto in_double =
        ropsim_double::make_single_pixel("weighted_blended:weight=none,format=float32", header(), 0);
    const double exact = in_double->run(scene)[0];
    EXPECT_NEAR(exact, 0.5, 1e-6);
    // Colour and weight stagnate at different sums: their quotient is off.
    const PixelScene dim = black_layers(100'000, 0.01f, 0.3f);
    const Shown half = run("weighted_blended:weight=none,format=float32,color_format=float16", dim);
    EXPECT_GT(std::abs(half.value - 0.3), 1.0 / 255);
    EXPECT_NEAR(run("weighted_blended:weight=none,format=float32", dim).value, 0.3, 1.0 / 255);
}

TEST(FormatHazards, HalfSumsOfBrightLayersOverflow) {
    // Equation 10 weighs near layers by 3000: with colours of 10 two overflow.
    PixelScene scene = black_layers(64, 0.9f, 10.0f);
    for (Fragment& f : scene.fragments) f.z *= 0.01f;
    const Shown half = run("weighted_blended", scene);
    const Shown cured = run("weighted_blended:format=float32", scene);
    EXPECT_NEAR(cured.value, 10.0, 0.01);
    EXPECT_LT(half.value, 2.0) << "an infinite sum of colours is shown as white";
    EXPECT_EQ(cured.bits - half.bits, 88);
}

// A single fragment makes the Hankel matrix singular: published arithmetic in float32 loses it, in double
// precision it does not, nor does the mended arithmetic in float32.
TEST(FormatHazards, PublishedMomentsLoseSingleFragmentsToSinglePrecision) {
    const std::string published = "moment_based:moments=4,guard=published,format=float32";
    const auto single = make_single_pixel(published, header(), 0);
    const auto mended = make_single_pixel("moment_based:moments=4,format=float32", header(), 0);
    const auto in_double = ropsim_double::make_single_pixel(published, header(), 0);
    int lost = 0;
    constexpr int kPixels = 2000;
    for (int i = 0; i < kPixels; ++i) {
        const PixelScene scene = layer_input("bright", 1, static_cast<std::uint64_t>(i)).pixels[0];
        const double exact = exact_color(scene)[0];
        lost += std::abs(single->run(scene)[0] - exact) > 0.01 ? 1 : 0;
        EXPECT_NEAR(in_double->run(scene)[0], exact, 1e-9 * light_of(scene).scale);
        EXPECT_NEAR(mended->run(scene)[0], exact, 1e-4 * light_of(scene).scale);
    }
    EXPECT_GT(lost, kPixels / 20);
}

const StressHazardCase& hazard_of(const std::string& id) {
    const auto found = std::ranges::find(stress_hazard_cases(), id, &StressHazardCase::id);
    EXPECT_NE(found, stress_hazard_cases().end()) << id;
    return *found;
}

// Four samples of alpha .1: one of them, with probability .4, or none. So many different draws that the share
// of pixels with one, and with it the root mean square of .15 and .1, are what they are expected to be; five
// standard deviations of a binomial of 64.
TEST(HazardScenes, FewSamplesAreDrawnAnewInEachPixel) {
    const StressHazardCase& hazard = hazard_of("few_samples_are_empty");
    const auto pixel = make_single_pixel(hazard.with, header(), 0);
    int drawn = 0;
    for (const PixelScene& scene : hazard.scenes) {
        const double color = pixel->run(scene)[0];
        EXPECT_TRUE(color == 1 || color == 0.75) << color;
        drawn += color < 1 ? 1 : 0;
    }
    const auto pixels = static_cast<double>(hazard.scenes.size());
    ASSERT_EQ(pixels, 64);
    const double share = drawn / pixels;
    EXPECT_NEAR(share, 0.4, 5 * std::sqrt(0.4 * 0.6 / pixels));
    EXPECT_GT(drawn, 0);
    const double expected = std::sqrt(share * 0.15 * 0.15 + (1 - share) * 0.1 * 0.1);
    EXPECT_NEAR(run_hazard(hazard).lost, expected, 1e-6);
}

// Of a list's cure it is the nodes that grow; of depth-based samples the passes, while the state gets
// smaller.
TEST(HazardCosts, CountNodesAndPasses) {
    const StressHazardOutcome list = run_hazard(hazard_of("thin_list_vanishes"));
    EXPECT_EQ(list.bits, 32);
    EXPECT_EQ(list.node_bits, 96);  // colour and alpha, depth, next
    EXPECT_EQ(list.more, 0);
    EXPECT_EQ(list.node_more, 32);
    EXPECT_EQ(list.more_passes, 0);
    const StressHazardOutcome samples = run_hazard(hazard_of("few_samples_are_empty"));
    EXPECT_EQ(samples.bits, 4 * (32 + 128));
    EXPECT_EQ(samples.more, 4 * 32 + 128 + 32 - samples.bits);
    EXPECT_EQ(samples.more_passes, 2);
    EXPECT_EQ(samples.node_bits + samples.node_more, 0);
}

// The list that `ropsim stress` prints: each is lost with the hazard and not with its cure.
class HazardCases : public testing::TestWithParam<StressHazardCase> {};

TEST_P(HazardCases, AreReproducedAndCured) {
    const StressHazardCase& hazard = GetParam();
    const StressHazardOutcome outcome = run_hazard(hazard);
    EXPECT_GE(outcome.lost, hazard.least_lost) << hazard.with;
    EXPECT_LE(outcome.left, hazard.most_left) << hazard.cured;
    // What is lost is plainly more than what may remain.
    EXPECT_GE(hazard.least_lost, 4 * hazard.most_left);
}
INSTANTIATE_TEST_SUITE_P(Named, HazardCases, testing::ValuesIn(stress_hazard_cases()),
                         [](const auto& hazard) { return hazard.param.id; });

}  // namespace
}  // namespace ropsim
