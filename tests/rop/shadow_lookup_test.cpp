// Look-ups of stored shadow maps: one texel, and filters over several.
#include "rop/shadow/shadow_filter.h"
#include "rop/shadow/shadow_map.h"

#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr float kNone = std::numeric_limits<float>::infinity();

TEST(ShadowLookup, SharesOfSamplesThatAreNotNearer) {
    const StoredShadowMap map{1, 1, 4, {0.25f, 0.5f, 0.5f, kNone}, {}, {}};
    EXPECT_EQ(stochastic_visibility(map, 0, 0, 0.25), 1.0);
    EXPECT_EQ(stochastic_visibility(map, 0, 0, 0.3), 0.75);
    EXPECT_EQ(stochastic_visibility(map, 0, 0, 0.5), 0.75);
    EXPECT_EQ(stochastic_visibility(map, 0, 0, 1.0), 0.25);
}

TEST(ShadowLookup, CorrectionScalesTheDropToTotalAlpha) {
    // Two of four samples taken, one of them in front of 0.4; total alpha 0.6; opaque at 0.9.
    const StoredShadowMap map{1, 1, 4, {0.25f, 1.0f, 0.5f, 1.0f}, {0.6f}, {0.9f}};
    const auto alpha = static_cast<double>(0.6f);
    EXPECT_EQ(corrected_visibility(map, 0, 0, 0.2), 1.0);
    EXPECT_DOUBLE_EQ(corrected_visibility(map, 0, 0, 0.4), 1 - alpha / 2);
    EXPECT_DOUBLE_EQ(corrected_visibility(map, 0, 0, 0.8), 1 - alpha);
    EXPECT_EQ(corrected_visibility(map, 0, 0, 0.95), 0.0);  // behind the opaque layer
    EXPECT_DOUBLE_EQ(opaque_surface_visibility(map, 0, 0, 0.89, 0.91).value(), 1 - alpha);
    EXPECT_EQ(opaque_surface_visibility(map, 0, 0, 0.95, 0.97).value(), 0.0);
    EXPECT_FALSE(opaque_surface_visibility(map, 0, 0, 0.3, 0.32)) << "the texel shows another surface";
}

TEST(ShadowLookup, WithNothingToScaleACorrectedTexelIsLit) {
    const StoredShadowMap map{1, 1, 2, {1.0f, 1.0f}, {0.3f}, {kNone}};
    EXPECT_EQ(corrected_visibility(map, 0, 0, 0.5), 1.0);
}

TEST(ShadowFilterTest, TheSquareIsAboutThePointsTexelAndLitBeyondTheMap) {
    ShadowFilter filter;
    filter.side = 3;
    std::set<std::pair<int, int>> read;
    const auto dark = [&](int x, int y, double) {
        read.insert({x, y});
        return 0.0;
    };
    EXPECT_EQ(filtered(filter, 8, 8, {3.9, 5.1, 0.5}, 1, dark), 0.0);
    EXPECT_EQ(read.size(), 9u);
    EXPECT_EQ(*read.begin(), std::make_pair(2, 4));
    EXPECT_EQ(*read.rbegin(), std::make_pair(4, 6));
    read.clear();
    EXPECT_DOUBLE_EQ(filtered(filter, 8, 8, {0.5, 7.5, 0.5}, 1, dark), 5.0 / 9);
    EXPECT_EQ(read.size(), 4u);
    EXPECT_TRUE(inside_view({0, 7.9, 1}, 8, 8));
    for (const ViewPoint outside : {ViewPoint{-0.1, 1, 0.5}, ViewPoint{8, 1, 0.5}, ViewPoint{1, 8, 0.5},
                                    ViewPoint{1, 1, 1.1}, ViewPoint{1, 1, std::nan("")}})
        EXPECT_FALSE(inside_view(outside, 8, 8));
}

TEST(ShadowFilterTest, TheBiasGrowsWithTheDistanceFromThePoint) {
    ShadowFilter filter;
    filter.side = 3;
    filter.bias = 0.01;
    filter.slope_bias = 0.125;
    std::map<std::pair<int, int>, double> depth;
    filtered(filter, 8, 8, {3.75, 5.5, 0.5}, 1, [&](int x, int y, double z) {
        depth[{x, y}] = z;
        return 1.0;
    });
    EXPECT_NEAR((depth[{3, 5}]), 0.49 - 0.125 * 0.25, 1e-12);
    EXPECT_NEAR((depth[{4, 5}]), 0.49 - 0.125 * 0.75, 1e-12);
    EXPECT_NEAR((depth[{2, 4}]), 0.49 - 0.125 * 1.25, 1e-12);
}

TEST(ShadowFilterTest, TentsAndDiscsWeighTheSquare) {
    ShadowFilter filter;
    filter.side = 5;
    filter.shape = FilterShape::kTent;
    const auto at = [](int x, int y) {
        return [x, y](int tx, int ty, double) { return tx == x && ty == y ? 1.0 : 0.0; };
    };
    // Weights 1 2 3 2 1 along each axis.
    EXPECT_DOUBLE_EQ(filtered(filter, 16, 16, {8.5, 8.5, 0.5}, 1, at(8, 8)), 9.0 / 81);
    EXPECT_DOUBLE_EQ(filtered(filter, 16, 16, {8.5, 8.5, 0.5}, 1, at(6, 9)), 2.0 / 81);
    EXPECT_DOUBLE_EQ(filtered(filter, 16, 16, {8.5, 8.5, 0.5}, 1, at(5, 8)), 0.0);
    filter.shape = FilterShape::kDisc;
    std::set<std::pair<int, int>> read;
    filtered(filter, 16, 16, {8.5, 8.5, 0.5}, 1, [&](int x, int y, double) {
        read.insert({x - 8, y - 8});
        return 0.0;
    });
    EXPECT_EQ(read.size(), 21u) << "a square of five without its corners";
    EXPECT_FALSE(read.contains({2, 2}));
    EXPECT_TRUE(read.contains({2, 1}));
}

TEST(ShadowFilterTest, TapsAreUniformOverTheSquareAndAFunctionOfTheKey) {
    ShadowFilter filter;
    filter.side = 5;
    filter.taps = 4;
    constexpr int kKeys = 20000;
    std::map<std::pair<int, int>, int> hits;
    for (int key = 0; key < kKeys; ++key)
        filtered(filter, 64, 64, {32.5, 32.5, 0.5}, mix64(static_cast<std::uint64_t>(key)),
                 [&](int x, int y, double) {
                     ++hits[{x, y}];
                     return 0.0;
                 });
    ASSERT_EQ(hits.size(), 25u);
    const double expected = kKeys * 4 / 25.0;
    double chi_squared = 0;
    for (const auto& [texel, count] : hits) {
        EXPECT_LE(std::abs(texel.first - 32), 2);
        EXPECT_LE(std::abs(texel.second - 32), 2);
        chi_squared += (count - expected) * (count - expected) / expected;
    }
    EXPECT_LT(chi_squared, 24 + 5 * std::sqrt(2 * 24.0));  // 24 degrees of freedom, five deviations
    const auto checker = [](int x, int y, double) { return (x + y) % 2 == 0 ? 1.0 : 0.0; };
    EXPECT_EQ(filtered(filter, 64, 64, {32.5, 32.5, 0.5}, 7, checker),
              filtered(filter, 64, 64, {32.5, 32.5, 0.5}, 7, checker));
    EXPECT_DOUBLE_EQ(whole_filter(filter, 64, 64, {32.5, 32.5, 0.5}, checker), 13.0 / 25);
}

}  // namespace
}  // namespace ropsim
