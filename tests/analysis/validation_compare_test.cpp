// Units, bounds and excuses of the comparison with the software path, by closed form.
#include "analysis/validation_compare.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST(UnitsApart, HalvesAreCountedThroughZeroAndPowersOfTwo) {
    const auto apart = [](float a, float b) { return units_apart(Format::kFloat16, a, b); };
    EXPECT_EQ(apart(1.0f, 1.0f + 0x1p-10f), 1);
    EXPECT_EQ(apart(1.0f, 1.0f - 0x1p-11f), 1);
    EXPECT_EQ(apart(1.0f, 2.0f), 1024);
    EXPECT_EQ(apart(0x1p-14f, 0x1p-14f - 0x1p-24f), 1);  // the largest subnormal
    EXPECT_EQ(apart(0x1p-24f, -0x1p-24f), 2);
    EXPECT_EQ(apart(0.0f, -0.0f), 0);
    EXPECT_EQ(apart(65504.0f, 65472.0f), 1);
    EXPECT_EQ(apart(65504.0f, kInfinity), static_cast<double>(kInfinity));
    EXPECT_EQ(apart(kInfinity, kInfinity), 0);
}

TEST(UnitsApart, CodesAndRelativeDifferences) {
    EXPECT_NEAR(units_apart(Format::kUnorm8, 3 / 255.0f, 5 / 255.0f), 2, 1e-6);
    EXPECT_NEAR(units_apart(Format::kFloat32, 1000.0f, 1000.001f), 1e-6, 1e-7);
    // Below a millionth the difference is absolute: 1e-12 is a millionth of it.
    EXPECT_NEAR(units_apart(Format::kFloat32, 1e-12f, 2e-12f), 1e-6, 1e-12);
    EXPECT_EQ(units_apart(Format::kFloat32, NAN, 1.0f), static_cast<double>(kInfinity));
}

Image row_of(const std::vector<float>& red) {
    Image image(static_cast<int>(red.size()), 1, {"R", "G", "B"});
    for (std::size_t i = 0; i < red.size(); ++i) image.values[3 * i] = red[i];
    return image;
}

Agreement compared(Format stored, const std::vector<float>& model, const std::vector<float>& drawn,
                   PixelKind kind = PixelKind::kSameFragments, double function_bound = 0) {
    return compare_images(row_of(model), row_of(drawn), std::vector<PixelKind>(model.size(), kind), stored,
                          function_bound);
}

TEST(Agreement, EveryFormatHasItsBound) {
    EXPECT_TRUE(compared(Format::kFloat32, {1.0f}, {1.0f + 0x1p-20f}).holds());
    EXPECT_FALSE(compared(Format::kFloat32, {1.0f}, {1.0f + 0x1p-19f}).holds());
    EXPECT_TRUE(
        compared(Format::kFloat32, {1.0f}, {1.0f + 0x1p-19f}, PixelKind::kSameFragments, 2e-6).holds());
    // 10,000 pixels may have one of two units, not two.
    std::vector<float> model(10000, 1.0f);
    std::vector<float> drawn = model;
    for (std::size_t i = 0; i < 500; ++i) drawn[i] += 0x1p-10f;
    EXPECT_TRUE(compared(Format::kFloat16, model, drawn).holds());
    drawn[7] += 0x1p-10f;
    const Agreement one = compared(Format::kFloat16, model, drawn);
    EXPECT_TRUE(one.holds());
    ASSERT_TRUE(one.first);
    EXPECT_EQ(one.first->x, 7);
    EXPECT_EQ(one.exceptions.size(), 1u);
    drawn[9999] += 0x1p-9f;
    EXPECT_FALSE(compared(Format::kFloat16, model, drawn).holds());
    drawn[7] = drawn[9999] = model[0];
    drawn[500] += 0x1p-10f;
    drawn[501] += 0x1p-10f;  // one unit in 501 of 10,000 is a rounding left out, unless functions allow it
    EXPECT_FALSE(compared(Format::kFloat16, model, drawn).holds());
    EXPECT_TRUE(compared(Format::kFloat16, model, drawn, PixelKind::kSameFragments, 1e-9).holds());
    // Of UNORM8 one in 1,000 may be off by a code, none by two.
    std::vector<float> codes(1000, 100 / 255.0f);
    std::vector<float> off = codes;
    off[0] = 101 / 255.0f;
    EXPECT_TRUE(compared(Format::kUnorm8, codes, off).holds());
    off[1] = 101 / 255.0f;
    EXPECT_FALSE(compared(Format::kUnorm8, codes, off).holds());
    off[1] = codes[1];
    off[0] = 102 / 255.0f;
    EXPECT_FALSE(compared(Format::kUnorm8, codes, off).holds());
}

TEST(Agreement, OtherFragmentsExcuseFewPixelsOnly) {
    const std::vector<float> model(2000, 0.5f);
    std::vector<float> drawn = model;
    drawn[3] = 0.6f;
    EXPECT_FALSE(compared(Format::kFloat32, model, drawn).holds());
    const Agreement excused = compared(Format::kFloat32, model, drawn, PixelKind::kOtherFragments);
    EXPECT_TRUE(excused.holds());
    EXPECT_EQ(excused.outside_excused, 1u);
    drawn[4] = drawn[5] = 0.6f;  // 3 of 2,000 are more than a thousandth
    EXPECT_FALSE(compared(Format::kFloat32, model, drawn, PixelKind::kOtherFragments).holds());
}

TEST(Agreement, PixelsLeftOutDoNotCount) {
    const Agreement none = compared(Format::kFloat32, {1, 2}, {3, 4}, PixelKind::kLeftOut);
    EXPECT_EQ(none.pixels, 0u);
    EXPECT_TRUE(none.holds());
    EXPECT_FALSE(none.first);
}

}  // namespace
}  // namespace ropsim
