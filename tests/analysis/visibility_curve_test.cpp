// Visibility functions at a pixel: the exact one by hand, techniques against it, and what is written.
#include "analysis/visibility_curve.h"

#include "base/atomic_file.h"
#include "base/error.h"
#include "tests/traces/scratch.h"
#include "traces/generators.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

Fragment fragment(float z, float a, std::uint32_t primitive = 0, std::uint16_t coverage = 1, int x = 5,
                  int y = 2) {
    return {z,         a,        a, a, a, static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y),
            primitive, coverage, 0};
}

double behind(const ExactVisibility& exact, float z) {
    return exact(static_cast<double>(std::nextafter(z, kInfinity)));
}

TEST(ExactVisibility, IsTheProductOfWhatIsStrictlyInFront) {
    const PixelFragments pixel{
        5,
        2,
        {fragment(0.75f, 0.5f), fragment(0.25f, 0.25f), fragment(0.75f, 0.5f), fragment(0.5f, 0)},
        std::vector<DepthSlope>(4),
        0};
    const ExactVisibility exact(pixel, 1);
    EXPECT_EQ(exact(0.1), 1);
    EXPECT_EQ(exact(0.25), 1);
    EXPECT_EQ(behind(exact, 0.25f), 0.75);
    EXPECT_EQ(exact(0.6), 0.75);
    EXPECT_EQ(exact(0.75), 0.75);  // of two at one depth neither hides the other
    EXPECT_EQ(behind(exact, 0.75f), 0.1875);
    EXPECT_EQ(exact(1), 0.1875);
    EXPECT_THAT(exact.depths(), ElementsAre(0.25f, 0.5f, 0.75f));
    EXPECT_EQ(exact.fragment_depths().size(), 4u);
}

TEST(ExactVisibility, IsTheMeanOverSamplesAtTheirOwnDepths) {
    // Two samples, at (1/4, 1/4) and (-1/4, -1/4) of a pixel from its centre. The first fragment covers both
    // and tilts: depths 0.75 and 0.25. The second covers the first sample alone.
    const PixelFragments pixel{
        5, 2, {fragment(0.5f, 0.5f, 0, 3), fragment(0.6f, 1, 1, 1)}, {{0.5f, 0.5f}, {0, 0}}, 0};
    const ExactVisibility exact(pixel, 2);
    EXPECT_THAT(exact.depths(), ElementsAre(0.25f, 0.6f, 0.75f));
    EXPECT_EQ(exact(0.25), 1);
    EXPECT_EQ(exact(0.3), 0.75);           // sample 1: 1/2
    EXPECT_EQ(behind(exact, 0.6f), 0.25);  // sample 0: nothing
    EXPECT_EQ(exact(1), 0.25);
    EXPECT_EQ(exact.fragment_depths().size(), 3u);
}

TEST(ShownDepths, HoldEveryStepFromBothSides) {
    const std::vector<float> steps{0.25f, 0.5f, 0.500001f};
    const std::vector<float> depths = shown_depths(steps, kInfinity);
    EXPECT_TRUE(std::is_sorted(depths.begin(), depths.end()));
    for (const float z : steps)
        for (const float at : {std::nextafter(z, -kInfinity), z, std::nextafter(z, kInfinity)})
            EXPECT_TRUE(std::binary_search(depths.begin(), depths.end(), at)) << at;
    EXPECT_NEAR(depths.front(), 0.25 - 0.25 / 20, 1e-5);
    EXPECT_NEAR(depths.back(), 0.5 + 0.25 / 20, 1e-5);
    EXPECT_GE(depths.size(), static_cast<std::size_t>(kUniformDepths));
    // Not behind what is opaque, nor outside the range of depths.
    EXPECT_NEAR(shown_depths(steps, 0.505f).back(), 0.505, 1e-6);
    EXPECT_EQ(shown_depths({0.0f, 1.0f}, kInfinity).front(), 0.0f);
    EXPECT_EQ(shown_depths({0.0f, 1.0f}, kInfinity).back(), 1.0f);
    // A single depth still has a range; of very many an even choice is left.
    EXPECT_LT(shown_depths({0.5f}, kInfinity).front(), 0.5f);
    std::vector<float> many;
    for (int i = 0; i < 40000; ++i) many.push_back(0.25f + static_cast<float>(i) * 1e-5f);
    EXPECT_LE(shown_depths(many, kInfinity).size(), kUniformDepths + 3 * kMostSteps);
}

TEST(CurveErrors, AreThoseOfAConstantOffset) {
    const PixelFragments pixel{
        5, 2, {fragment(0.25f, 0.5f), fragment(0.75f, 0.5f)}, std::vector<DepthSlope>(2), 0};
    const ExactVisibility exact(pixel, 1);
    const std::vector<float> depths = shown_depths(exact.depths(), kInfinity);
    std::vector<float> values;
    for (const float z : depths) values.push_back(static_cast<float>(exact(static_cast<double>(z))) + 0.125f);
    // At the fragments the exact values are 1 and 1/2.
    const CurveError e = curve_error(exact, depths, values, std::vector<float>{1.25f, 0.25f});
    EXPECT_NEAR(e.max, 0.125, 1e-6);
    EXPECT_NEAR(e.mean, 0.125, 1e-6);
    EXPECT_NEAR(e.area, 0.125 * (0.5 + 0.05), 1e-6);
    EXPECT_NEAR(e.fragments_mean, 0.25, 1e-12);
    EXPECT_NEAR(e.fragments_rms, 0.25, 1e-12);
    EXPECT_NEAR(e.fragments_max, 0.25, 1e-12);
}

// A step drawn a little early: the area is its height times the way.
TEST(CurveErrors, AreaIsExactForSteps) {
    const PixelFragments pixel{
        5, 2, {fragment(0.25f, 0.5f), fragment(0.75f, 1)}, std::vector<DepthSlope>(2), 0};
    const ExactVisibility exact(pixel, 1);
    std::vector<float> steps = exact.depths();
    steps.insert(steps.begin() + 1, 0.5f);
    const std::vector<float> depths = shown_depths(steps, kInfinity);
    std::vector<float> values;
    for (const float z : depths) values.push_back(z <= 0.25f ? 1.0f : z <= 0.5f ? 0.5f : 0.0f);
    const CurveError e = curve_error(exact, depths, values, std::vector<float>{1, 0.5f});
    EXPECT_NEAR(e.area, 0.5 * 0.25, 1e-6);
    EXPECT_NEAR(e.max, 0.5, 1e-12);
    EXPECT_EQ(e.fragments_max, 0);
}

class VisibilityCurves : public ScratchTest {
 protected:
    void write(const std::vector<Fragment>& fragments, const std::optional<OpaqueLayer>& opaque = {}) {
        TraceHeader header;
        header.width = 20;
        header.height = 12;
        header.draws.resize(1);
        header.opaque = opaque;
        write_trace(path("t"), header, fragments);
        options_.trace = path("t");
    }
    std::string refusal() {
        try {
            visibility_curve(options_);
        } catch (const UserError& error) {
            return error.where() + ": " + error.what();
        }
        return "";
    }
    CurveOptions options_;
};

TEST_F(VisibilityCurves, AdaptiveIsExactWhileItHasNodes) {
    std::vector<Fragment> fragments;
    for (std::uint32_t i = 0; i < 8; ++i)
        fragments.push_back(
            fragment(0.1f + 0.1f * static_cast<float>(i * 5 % 8), 0.125f * static_cast<float>(i % 3 + 1), i));
    fragments.push_back(fragment(0.5f, 0.5f, 9, 1, 6, 2));  // another pixel's
    write(fragments);
    options_.techniques = {"adaptive:nodes=8,format=float32", "adaptive:nodes=4,format=float32"};
    const VisibilityCurve curve = visibility_curve(options_);
    EXPECT_EQ(curve.pixel.x, 5);
    EXPECT_EQ(curve.pixel.y, 2);
    EXPECT_EQ(curve.pixel.fragments.size(), 8u);
    EXPECT_LT(curve.techniques[0].error.max, 1e-6);
    EXPECT_LT(curve.techniques[0].error.fragments_max, 1e-6);
    EXPECT_GT(curve.techniques[1].error.max, 0.01);
    // Removing nodes by its rule takes visibility away and adds none (section 3.2).
    for (std::size_t i = 0; i < curve.depths.size(); ++i)
        EXPECT_LE(curve.techniques[1].visibility[i], curve.truth[i] + 1e-6) << curve.depths[i];
}

// One fragment of alpha 1/4 takes exactly 2 of 8 samples.
TEST_F(VisibilityCurves, StoredSamplesAreAShare) {
    write({fragment(0.5f, 0.25f)});
    options_.techniques = {"stochastic:samples=8", "stochastic:samples=8,method=depth_based",
                           "laine_karras:samples=8"};
    const VisibilityCurve curve = visibility_curve(options_);
    for (const CurveOfTechnique& technique : curve.techniques)
        EXPECT_EQ(technique.error.max, 0) << technique.technique;
    EXPECT_THAT(curve.truth_depths, ElementsAre(0.5f));
    EXPECT_THAT(curve.truth_behind, ElementsAre(0.75));
}

TEST_F(VisibilityCurves, FragmentsThatAreHiddenTakeNoPart) {
    OpaqueLayer opaque;
    opaque.rgb.assign(std::size_t{20} * 12 * 3, 0.5f);
    opaque.depth.assign(std::size_t{20} * 12, 0.6f);
    write({fragment(0.5f, 0.25f), fragment(0.7f, 0.5f, 1), fragment(0.65f, 0.5f, 2, 1, 9, 9)}, opaque);
    options_.techniques = {"stochastic:samples=8"};
    const VisibilityCurve curve = visibility_curve(options_);
    EXPECT_EQ(curve.pixel.hidden, 1u);
    EXPECT_EQ(curve.pixel.fragments.size(), 1u);
    EXPECT_LE(curve.depths.back(), 0.6f);
    options_.pixel = "9,9";
    EXPECT_EQ(refusal(), "--pixel: 9,9 has no transparent fragment to be seen; 5,2 has the most, 1");
}

TEST_F(VisibilityCurves, BadInputIsRefused) {
    write({fragment(0.5f, 0.25f)});
    options_.pixel = "5;2";
    EXPECT_EQ(refusal(), "--pixel: '5;2' is neither X,Y nor deepest");
    options_.pixel = "20,2";
    EXPECT_EQ(refusal(), "--pixel: 20,2 lies outside the image of 20x12 pixels; the deepest is 5,2");
    options_.pixel = "0,0";
    EXPECT_THAT(refusal(), HasSubstr("5,2 has the most, 1"));
    options_.pixel = "5,2";
    options_.techniques = {"alpha_blend"};
    EXPECT_THAT(refusal(), HasSubstr("'alpha_blend' represents no visibility; those that do: "));
    EXPECT_THAT(refusal(), HasSubstr("stochastic, "));
    options_.techniques = {"stochastic", "stochastic"};
    EXPECT_THAT(refusal(), HasSubstr("given twice"));
    options_.techniques = {"stochastic:samples=0"};
    EXPECT_THAT(refusal(), HasSubstr("samples"));
    options_.techniques = {};
    write({});
    options_.pixel = "deepest";
    EXPECT_THAT(refusal(), HasSubstr("has no transparent fragment"));
}

TEST_F(VisibilityCurves, OutputsHoldTheFunctions) {
    write({fragment(0.5f, 0.25f), fragment(0.625f, 0.5f, 1)});
    const VisibilityCurve curve = visibility_curve(options_);
    ASSERT_GE(curve.techniques.size(), 2u);  // the headline ones that represent visibility
    const nlohmann::json json = nlohmann::json::parse(curve_json(curve));
    EXPECT_EQ(json["steps"], nlohmann::json({{0.5, 0.75}, {0.625, 0.375}}));
    EXPECT_EQ(json["depths"].size(), curve.depths.size());
    EXPECT_EQ(json["exact"].size(), curve.depths.size());
    EXPECT_EQ(json["techniques"][0]["visibility"].size(), curve.depths.size());
    EXPECT_EQ(json["techniques"][0]["error"]["max"], curve.techniques[0].error.max);
    for (const auto& [key, value] : json["techniques"][0]["error"].items())
        EXPECT_TRUE(json["units"].contains("error." + key)) << key;
    EXPECT_EQ(json["pixel"], nlohmann::json({{"x", 5}, {"y", 2}, {"fragments", 2}, {"hidden", 0}}));
    EXPECT_THAT(curve_table(curve),
                HasSubstr("pixel 5,2: 2 fragments, exact visibility behind all 0.375000"));
    write_curve_plot(curve, path(""));
    EXPECT_THAT(read_file(path("curve.png")), testing::StartsWith("\x89PNG\r\n"));
    const std::string svg = read_file(path("curve.svg"));
    for (const char* text : {"pixel 5,2: 2 fragments", "exact", "stochastic:samples=8:  mean error",
                             "window depth z (ticks: fragments)", "</svg>"})
        EXPECT_TRUE(svg.find(text) != std::string::npos) << text;
}

// Behind an opaque fragment in front nothing is seen any more: the picture ends soon after, the numbers do
// not.
TEST_F(VisibilityCurves, ThePictureEndsWhereNothingIsSeen) {
    write({fragment(0.1f, 1), fragment(0.5f, 0.5f, 1), fragment(0.9f, 0.5f, 2)});
    options_.techniques = {"stochastic:samples=8"};
    const VisibilityCurve curve = visibility_curve(options_);
    EXPECT_GT(curve.depths.back(), 0.9f);
    EXPECT_THAT(curve_plot_script(curve, "a.svg", "a.png"),
                HasSubstr("2 more behind, where nothing changes"));
}

}  // namespace
}  // namespace ropsim
