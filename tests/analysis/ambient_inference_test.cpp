// Listing 2 of McGuire and Mara 2017 against a plain second implementation, and what is odd about it.
#include "analysis/ambient_inference.h"

#include "base/random.h"
#include "tests/analysis/ambient_view_of.h"

#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr int kWidth = 90;
constexpr int kHeight = 70;
constexpr double kNear = 0.25;
constexpr double kFar = 64;

// Distance before the eye of a window depth under glm::perspective.
double distance_of(double z) {
    return kNear * kFar / (kFar - z * (kFar - kNear));
}
float depth_of(double distance) {
    return static_cast<float>((kFar - kNear * kFar / distance) / (kFar - kNear));
}

// A perspective view with depths and ambient occlusion to fill in.
struct Buffers {
    DepthBuffer depth{kWidth, kHeight, std::vector<float>(std::size_t{kWidth} * kHeight, depth_of(10))};
    std::vector<float> ambient = std::vector<float>(std::size_t{kWidth} * kHeight, 1.0f);
    AmbientView view{
        header_of(kWidth, kHeight,
                  glm::perspective(1.0f, 9.0f / 7, static_cast<float>(kNear), static_cast<float>(kFar))),
        "test"};
    InferenceSettings settings;

    Inferred at(int x, int y, float z, glm::dvec2 gradient, std::vector<std::size_t>* read = nullptr) const {
        return AmbientInference(depth, ambient, view, settings).at(x, y, z, gradient, [&](std::size_t texel) {
            if (read != nullptr) read->push_back(texel);
        });
    }
    void randomise(std::uint64_t seed) {
        for (std::size_t i = 0; i < ambient.size(); ++i) {
            const std::uint64_t key = mix64(seed + i);
            ambient[i] = random_unit(key, 0);
            depth.depth[i] = depth_of(5 + 0.2 * static_cast<double>(random_unit(key, 1)));
            if (random_unit(key, 2) < 0.2f) depth.depth[i] = depth_of(30);
            if (random_unit(key, 2) > 0.9f) depth.depth[i] = std::numeric_limits<float>::infinity();
        }
    }
};

// The listing, read literally.
double listing(const Buffers& b, int x, int y, float z, double gx, double gy) {
    double top = 0, bottom = 0;
    const auto sample = [&](double ox, double oy) {
        const int column = std::min(std::max(static_cast<int>(std::trunc(x + 0.5 + ox)), 0), kWidth - 1);
        const int row = std::min(std::max(static_cast<int>(std::trunc(y + 0.5 + oy)), 0), kHeight - 1);
        const auto texel = static_cast<std::size_t>(row * kWidth + column);
        const double there = distance_of(std::min(1.0, static_cast<double>(b.depth.depth[texel])));
        const double weight = 0.01 / (0.01 + std::abs(distance_of(static_cast<double>(z)) - there));
        top += weight * static_cast<double>(b.ambient[texel]);
        bottom += weight;
    };
    const double length = std::hypot(gx, gy);
    if (length < 1e-4) {
        for (int dy = -3; dy <= 3; ++dy)
            for (int dx = -3; dx <= 3; ++dx) sample((dx + (dy % 2 != 0 ? 0.5 : -0.5)) * 2, dy * 2);
    } else {
        for (int t = 0; t < 12; ++t) sample(gx / length * 3 * t, gy / length * 3 * t);
    }
    return std::min(1.0, std::max(0.0, top / std::max(0.01, bottom)));
}

TEST(AmbientInferenceTest, AgreesWithTheListingOnRandomData) {
    Buffers b;
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
        b.randomise(1000 * seed);
        for (std::uint32_t i = 0; i < 300; ++i) {
            const std::uint64_t key = mix64(77 + seed);
            const auto unit = [&](std::uint32_t n) {
                return static_cast<double>(random_unit(key, 8 * i + n));
            };
            const int x = static_cast<int>(unit(0) * kWidth);
            const int y = static_cast<int>(unit(1) * kHeight);
            const float z = depth_of(4.9 + 0.4 * unit(2));
            const double steepness = i % 3 == 0 ? 1e-5 : 1.0;
            const glm::dvec2 gradient(steepness * (unit(3) - 0.5), steepness * (unit(4) - 0.5));
            const Inferred inferred = b.at(x, y, z, gradient);
            EXPECT_EQ(inferred.line, i % 3 != 0);
            EXPECT_EQ(inferred.taps, inferred.line ? 12 : 49);
            // The view's matrix has floats, off by 6e-8.
            EXPECT_NEAR(inferred.ambient, listing(b, x, y, z, gradient.x, gradient.y), 1e-7);
        }
    }
}

TEST(AmbientInferenceTest, TheLineRunsUpAlphaFromTheFragmentItself) {
    const Buffers b;
    std::vector<std::size_t> read;
    b.at(10, 20, depth_of(10), {0.3, 0}, &read);
    ASSERT_EQ(read.size(), 12u);
    for (int t = 0; t < 12; ++t) EXPECT_EQ(read[static_cast<std::size_t>(t)], b.depth.index(10 + 3 * t, 20));
    read.clear();
    b.at(10, 40, depth_of(10), {0, -0.3}, &read);
    for (int t = 0; t < 12; ++t) EXPECT_EQ(read[static_cast<std::size_t>(t)], b.depth.index(10, 40 - 3 * t));
    // Outside the image the border is read again.
    read.clear();
    b.at(80, 20, depth_of(10), {1, 0}, &read);
    EXPECT_EQ(read.back(), b.depth.index(kWidth - 1, 20));
}

TEST(AmbientInferenceTest, ALeafsEdgeReceivesWhatTheLeafHas) {
    Buffers b;
    // A leaf at 5 m, AO 0.4, from column 30 on; behind it at 10 m AO is 1.
    for (int y = 0; y < kHeight; ++y) {
        for (int x = 30; x < kWidth; ++x) {
            b.depth.depth[b.depth.index(x, y)] = depth_of(5);
            b.ambient[b.depth.index(x, y)] = 0.4f;
        }
    }
    // Column 29: of 12 taps only the first, its own pixel, is behind.
    const double behind = 0.01 / (0.01 + 5);
    EXPECT_NEAR(b.at(29, 35, depth_of(5), {0.5, 0}).ambient, (11 * 0.4 + behind) / (11 + behind), 1e-5);
    // The other way round there is no leaf, and AO is that of what lies behind.
    EXPECT_NEAR(b.at(29, 35, depth_of(5), {-0.5, 0}).ambient, 1, 1e-9);
    // A leaf two pixels wide falls between the taps.
    for (int y = 0; y < kHeight; ++y)
        for (int x = 32; x < kWidth; ++x) b.depth.depth[b.depth.index(x, y)] = depth_of(10);
    EXPECT_GT(b.at(29, 35, depth_of(5), {0.5, 0}).best, 0.001);
    const Inferred missed = b.at(28, 35, depth_of(5), {0.5, 0});  // reads 28, 31, 34
    const Inferred narrow = b.at(29, 35, depth_of(5), {0.5, 0});  // reads 29, 32, 35
    EXPECT_GT(missed.best, 0.99);
    EXPECT_LT(narrow.best, 0.01);
}

TEST(AmbientInferenceTest, ThePrintedSquareIsNoCheckerboard) {
    Buffers b;
    const auto columns_of = [&](bool even_rows) {
        std::vector<std::size_t> read;
        b.at(40, 30, depth_of(10), {0, 0}, &read);
        std::vector<int> columns;
        for (const std::size_t texel : read) {
            const int row = static_cast<int>(texel) / kWidth - 30;
            EXPECT_EQ(row % 2, 0);
            if ((row / 2 % 2 == 0) == even_rows) columns.push_back(static_cast<int>(texel) % kWidth - 40);
        }
        return columns;
    };
    const std::vector<int> even = columns_of(true);
    const std::vector<int> odd = columns_of(false);
    ASSERT_EQ(even.size(), 3u * 7u);
    ASSERT_EQ(odd.size(), 4u * 7u);
    int sum = 0;
    for (std::size_t i = 0; i < even.size(); ++i) EXPECT_EQ(even[i], -7 + 2 * static_cast<int>(i % 7));
    for (std::size_t i = 0; i < odd.size(); ++i) EXPECT_EQ(odd[i], -5 + 2 * static_cast<int>(i % 7));
    for (const int column : even) sum += column;
    for (const int column : odd) sum += column;
    EXPECT_EQ(sum, 7) << "49 taps, a seventh of a pixel each";
    b.settings.checkerboard = true;
    for (const int column : columns_of(true)) EXPECT_EQ(column % 2, 0);
    for (const int column : columns_of(false)) EXPECT_NE(column % 2, 0);
}

TEST(AmbientInferenceTest, TheFloorDarkensEdgesThatFindNothing) {
    Buffers b;
    std::fill(b.depth.depth.begin(), b.depth.depth.end(), std::numeric_limits<float>::infinity());
    const float z = depth_of(10);
    const double weight = 0.01 / (0.01 + kFar - 10);
    // Twelve taps of an unoccluded sky.
    EXPECT_NEAR(b.at(20, 35, z, {0.5, 0}).weight, 12 * weight, 1e-7);
    EXPECT_NEAR(b.at(20, 35, z, {0.5, 0}).ambient, 1200 * weight, 1e-5);
    EXPECT_LT(b.at(20, 35, z, {0.5, 0}).ambient, 0.23);
    EXPECT_NEAR(b.at(20, 35, z, {0, 0}).ambient, 4900 * weight, 1e-4);
    b.settings.floor = 0;
    EXPECT_EQ(b.at(20, 35, z, {0.5, 0}).ambient, 1.0);
    // From where it matters: all taps 12 m away.
    b.settings.floor = 0.01;
    for (const auto& [distance, full] : {std::pair(21.9, true), {22.2, false}}) {
        std::fill(b.depth.depth.begin(), b.depth.depth.end(), depth_of(distance));
        EXPECT_EQ(b.at(20, 35, z, {0.5, 0}).ambient > 0.9999, full) << distance;
    }
}

TEST(AmbientInferenceTest, ATapWeighsHalfAtHalfWeightMetres) {
    Buffers b;
    std::fill(b.depth.depth.begin(), b.depth.depth.end(), depth_of(10));
    for (const double half : {0.01, 0.5}) {
        b.settings.half_weight = half;
        EXPECT_NEAR(b.at(20, 35, depth_of(10 - half), {0.5, 0}).best, 0.5, 1e-3) << half;
    }
}

}  // namespace
}  // namespace ropsim
