// The filter over the ambient buffer: what it keeps, what it smooths and by how much.
#include "analysis/ambient_blur.h"

#include "base/random.h"
#include "tests/analysis/ambient_view_of.h"

#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr int kWidth = 120;
constexpr int kHeight = 100;

// Two levels with a step of `step` metres in the middle.
DepthBuffer levels(double step) {
    return heights(kWidth, kHeight, 4, 3, [&](double x, double) { return x < 0 ? 0 : step; });
}
AmbientView straight() {
    return AmbientView(header_of(kWidth, kHeight, from_above(4, 3)), "levels");
}
std::vector<float> noise() {
    std::vector<float> values;
    for (std::uint32_t i = 0; i < kWidth * kHeight; ++i) values.push_back(random_unit(mix64(i), 0));
    return values;
}

TEST(AmbientBlurTest, AStepInDepthKeepsItsSidesApart) {
    const DepthBuffer depth = levels(0.16);
    std::vector<float> ambient;
    for (int i = 0; i < kWidth * kHeight; ++i) ambient.push_back(i % kWidth < kWidth / 2 ? 0.25f : 0.75f);
    const std::vector<float> before = ambient;
    blur_ambient(ambient, depth, straight(), 4, Format::kFloat32, 1);
    for (std::size_t i = 0; i < ambient.size(); ++i) EXPECT_NEAR(ambient[i], before[i], 1e-6);
    // A lower step lets some across, at half the distance half as much.
    ambient = before;
    blur_ambient(ambient, levels(0.075), straight(), 4, Format::kFloat32, 1);
    const double w[] = {1, std::exp(-1.0 / 18), std::exp(-4.0 / 18), std::exp(-9.0 / 18),
                        std::exp(-16.0 / 18)};
    const double beside = w[1] + w[2] + w[3] + w[4];
    const double expected = (0.25 * (1 + beside) + 0.75 * 0.5 * beside) / (1 + 1.5 * beside);
    EXPECT_NEAR(ambient[depth.index(kWidth / 2 - 1, 50)], expected, 1e-6);
}

// A far plane at infinity: what lies on it has no distance, not even to itself.
TEST(AmbientBlurTest, WhatLiesInfinitelyFarKeepsItsValue) {
    glm::mat4 projection(0.0f);
    projection[0][0] = projection[1][1] = 1;
    projection[2][2] = projection[2][3] = -1;
    projection[3][2] = -0.2f;
    const AmbientView view(header_of(16, 16, projection), "infinite");
    DepthBuffer depth{16, 16, std::vector<float>(256, 0.5f)};
    std::fill_n(depth.depth.begin(), 128, 1.0f);
    ASSERT_FALSE(std::isfinite(view.at_pixel(3, 3, 1.0f).z));
    std::vector<float> ambient(256, 0.25f);
    std::fill_n(ambient.begin(), 128, 0.75f);
    blur_ambient(ambient, depth, view, 4, Format::kFloat32, 1);
    for (std::size_t i = 0; i < ambient.size(); ++i) EXPECT_NEAR(ambient[i], i < 128 ? 0.75f : 0.25f, 1e-6);
}

TEST(AmbientBlurTest, NoiseShrinksAsTheWeightsSay) {
    const DepthBuffer depth = levels(0);
    std::vector<float> ambient = noise();
    const std::uint64_t taps = blur_ambient(ambient, depth, straight(), 4, Format::kFloat32, 1);
    // Taps inside the image: 9 but for the 8 pixels at each end, which miss 4, 4, 3, 3, ...
    EXPECT_EQ(taps, static_cast<std::uint64_t>((9 * kWidth - 40) * kHeight + (9 * kHeight - 40) * kWidth));
    double sum = 0, squares = 0, weights = 0, weight_squares = 0;
    int count = 0;
    for (int y = 10; y < kHeight - 10; ++y) {
        for (int x = 10; x < kWidth - 10; ++x) {
            const double a = static_cast<double>(ambient[depth.index(x, y)]) - 0.5;
            sum += a;
            squares += a * a;
            ++count;
        }
    }
    for (int k = -4; k <= 4; ++k) {
        const double weight = std::exp(-k * k / 18.0);
        weights += weight;
        weight_squares += weight * weight;
    }
    const double share = weight_squares / (weights * weights);
    // Of 8000 values about 8000 / 4 / 9^2 are independent: 25, of each of the 4 interleaved lattices.
    const double expected = share * share / 12;
    EXPECT_NEAR(squares / count, expected, 4 * expected * std::sqrt(2.0 / 100));
    EXPECT_NEAR(sum / count, 0, 4 * std::sqrt(1.0 / 12 / count));
}

TEST(AmbientBlurTest, NothingIsReadWhereNothingWasDrawn) {
    DepthBuffer depth = levels(0);
    std::vector<float> ambient(depth.depth.size(), 0.5f);
    for (int y = 0; y < kHeight; ++y) {
        depth.depth[depth.index(60, y)] = std::numeric_limits<float>::infinity();
        ambient[depth.index(60, y)] = 1.0f;
    }
    blur_ambient(ambient, depth, straight(), 4, Format::kUnorm8, 1);
    const float half = stored_value(Format::kUnorm8, 0.5f);
    for (int x = 0; x < kWidth; ++x) EXPECT_EQ(ambient[depth.index(x, 50)], x == 60 ? 1.0f : half) << x;
}

TEST(AmbientBlurTest, RadiusZeroAndThreadsChangeNothing) {
    const DepthBuffer depth = levels(0.1);
    std::vector<float> none = noise();
    EXPECT_EQ(blur_ambient(none, depth, straight(), 0, Format::kUnorm8, 1), 0u);
    EXPECT_EQ(none, noise());
    std::vector<float> one = noise();
    std::vector<float> three = noise();
    blur_ambient(one, depth, straight(), 3, Format::kUnorm16, 1);
    blur_ambient(three, depth, straight(), 3, Format::kUnorm16, 3);
    EXPECT_EQ(one, three);
}

}  // namespace
}  // namespace ropsim
