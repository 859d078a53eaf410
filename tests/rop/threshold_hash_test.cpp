// The thresholds of hashed alpha testing: uniform at every scale, one to a cube, neighbours independent.
#include "rop/threshold_hash.h"

#include "tests/rop/random_fragments.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;

// Largest distance between the sample's distribution and the uniform one on (0, 1] (Kolmogorov and Smirnov).
double distance_to_uniform(std::vector<double> values) {
    std::ranges::sort(values);
    const auto n = static_cast<double>(values.size());
    double worst = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const auto before = static_cast<double>(i);
        worst = std::max({worst, values[i] - before / n, (before + 1) / n - values[i]});
    }
    return worst;
}
// What n independent draws exceed once in 10^6 times: 2 exp(-2 n d^2) = 10^-6.
double rare_distance(std::size_t n) {
    return std::sqrt(std::log(2e6) / (2 * static_cast<double>(n)));
}

// The blend's distribution function at quantiles of the blend itself, drawn from another generator, is
// uniform; and it is what integration over the unit square gives.
TEST(BlendDistribution, MakesTheBlendUniform) {
    constexpr std::size_t kDraws = 200000;
    for (const float t : {0.0f, 1e-4f, 0.1f, 0.25f, 0.5f, 0.7f, 0.99f, 1.0f}) {
        Random random(41);
        std::vector<double> mapped;
        std::vector<double> blends;
        for (std::size_t i = 0; i < kDraws; ++i) {
            const float u = random.real(0, 1);
            const float x = u + t * (random.real(0, 1) - u);
            blends.push_back(x);
            const float y = blend_distribution<PlainDatapath>(x, t);
            ASSERT_GT(y, 0.0f);
            ASSERT_LE(y, 1.0f);
            mapped.push_back(y);
        }
        EXPECT_LT(distance_to_uniform(mapped), rare_distance(kDraws)) << t;
        // Without the map the middle is too frequent, as the test would notice.
        if (t > 0.05f && t < 0.95f) {
            EXPECT_GT(distance_to_uniform(blends), 5 * rare_distance(kDraws)) << t;
        }
    }
    for (const double t : {0.2, 0.5, 0.9}) {
        for (const double x : {0.05, 0.15, 0.4, 0.6, 0.85, 0.97}) {
            constexpr int kSteps = 20000;
            double area = 0;  // of (1 - t) u + t v < x
            for (int i = 0; i < kSteps; ++i)
                area += std::clamp((x - (1 - t) * (i + 0.5) / kSteps) / t, 0.0, 1.0) / kSteps;
            EXPECT_NEAR(blend_distribution<PlainDatapath>(static_cast<float>(x), static_cast<float>(t)), area,
                        1e-5);
        }
    }
}

// Over cubes far apart, thresholds are uniform at every scale between two powers of two.
TEST(CubeThreshold, IsUniformAtEveryScale) {
    constexpr std::size_t kDraws = 50000;
    for (const float scale : {0.02f, 1.0f, 1.1f, 1.5f, 1.9f, 300.0f}) {
        Random random(42);
        std::vector<double> values;
        for (std::size_t i = 0; i < kDraws; ++i) {
            CubePlace place;
            for (float& p : place.position) p = random.real(-500, 500) / scale;
            place.scale = scale;
            values.push_back(cube_threshold<PlainDatapath>(place, 7));
        }
        EXPECT_LT(distance_to_uniform(values), rare_distance(kDraws)) << scale;
    }
}

// Neighbouring cubes, and the same cube under two seeds, have nothing to do with each other.
TEST(CubeThreshold, NeighboursAndSeedsAreUncorrelated) {
    constexpr int kCubes = 20000;
    for (int axis = 0; axis < 4; ++axis) {
        double sum = 0;
        for (int i = 0; i < kCubes; ++i) {
            // Scale 1: only the coarse cubes count.
            CubePlace a{{static_cast<float>(i % 20) - 9.5f, static_cast<float>((i / 20) % 20) - 9.5f,
                         std::floor(static_cast<float>(i) / 400) - 24.5f},
                        1.0f};
            CubePlace b = a;
            if (axis < 3) b.position[static_cast<std::size_t>(axis)] += 1;
            const double u = cube_threshold<PlainDatapath>(a, 1) - 0.5;
            const double v = cube_threshold<PlainDatapath>(b, axis == 3 ? 2 : 1) - 0.5;
            sum += 12 * u * v;
        }
        EXPECT_LT(std::abs(sum / kCubes), 5 / std::sqrt(kCubes)) << axis;
    }
}

// All of a cube has one threshold, where the scale is a power of two; it changes at the cube's face.
TEST(CubeThreshold, IsConstantWithinACube) {
    const auto at = [](float x) { return cube_threshold<PlainDatapath>({{x, -0.3f, 7.7f}, 4.0f}, 0); };
    EXPECT_EQ(at(-0.25f), at(-0.001f));
    EXPECT_NE(at(-0.001f), at(0.001f));
    EXPECT_EQ(at(0.001f), at(0.249f));
    EXPECT_NE(at(0.249f), at(0.251f));
}

}  // namespace
}  // namespace ropsim
