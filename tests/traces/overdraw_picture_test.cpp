// The heat map of fragments a pixel: place, enlargement, an even rise of lightness, a legible scale.
#include "traces/overdraw_picture.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

// CIE 1976 lightness of a linear sRGB colour: the eye's scale, and not the one that the colours are made on.
float lightness(const float* rgb) {
    const float y = 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
    return y > 0.008856f ? 116 * std::cbrt(y) - 16 : 903.3f * y;
}

TEST(Overdraw, SmallMapsAreEnlargedAndEmptyPixelsAreBlack) {
    const Image image = overdraw_picture({0, 1, 2, 4, 8, 16}, 3, 2);
    EXPECT_EQ(image.width, 258);  // 3 times 86
    EXPECT_GT(image.height, 172);
    EXPECT_EQ(lightness(image.pixel(85, 85)), 0);
    float before = 0;
    for (const auto& [x, y] : {std::pair(86, 0), {257, 85}, {0, 86}, {86, 171}, {257, 171}}) {
        const float now = lightness(image.pixel(x, y));
        EXPECT_GT(now, before + 5) << x << " " << y;
        before = now;
    }
    EXPECT_GT(before, 85);
}

TEST(Overdraw, DoublingIsTheSameStepOfLightness) {
    std::vector<std::uint32_t> layers(300, 1);
    for (std::size_t k = 0; k <= 8; ++k) layers[k] = 1u << k;
    const Image image = overdraw_picture(layers, 300, 1);
    for (int k = 1; k <= 8; ++k)
        EXPECT_NEAR(lightness(image.pixel(k, 0)) - lightness(image.pixel(k - 1, 0)), 9, 4) << k;
}

TEST(Overdraw, TheScaleRunsFromOneToTheLargestWithItsTicks) {
    std::vector<std::uint32_t> layers(400 * 10, 1);
    layers[0] = 37;
    const Image image = overdraw_picture(layers, 400, 10);
    // In the rows below the map the first that is no background is the bar.
    int bar = 10;
    while (lightness(image.pixel(200, bar)) == 0) ++bar;
    for (int x = 9; x < 380; ++x)
        EXPECT_GE(lightness(image.pixel(x, bar)), lightness(image.pixel(x - 1, bar)) - 0.5f) << x;
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(image.pixel(8, bar)[c], image.pixel(1, 0)[c], 1e-5f);
    int ticks_at = bar;
    while (lightness(image.pixel(200, ticks_at)) > 0) ++ticks_at;
    int ticks = 0;
    for (int x = 0; x < image.width; ++x) ticks += image.pixel(x, ticks_at)[0] > 0.5f ? 1 : 0;
    EXPECT_EQ(ticks, 7);  // 1, 2, 4, 8, 16, 32 and 37
}

TEST(Overdraw, NothingDrawnHasNoScale) {
    const Image image = overdraw_picture(std::vector<std::uint32_t>(256 * 2), 256, 2);
    EXPECT_EQ(image.height, 2);
    for (const float value : image.values) EXPECT_EQ(value, 0);
}

}  // namespace
}  // namespace ropsim
