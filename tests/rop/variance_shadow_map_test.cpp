// Variance shadow maps: conversion against a brute-force filter in double precision, noise against the sum
// of squared weights, and Chebyshev's bound where it is exact and where it leaks.
#include "rop/shadow/variance_shadow_map.h"

#include "tests/rop/random_fragments.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::fragment_at;
using test::TestFrame;

MomentImage random_moments(int width, int height, std::uint64_t seed) {
    test::Random random(seed);
    MomentImage image{width, height, {}};
    for (int i = 0; i < width * height; ++i) {
        const float z = random.real(0, 1);
        image.texels.push_back({z, z * z});
    }
    return image;
}

// By the words of section 4.3.3: a tent of K x K about every texel, then each D x D texels become one.
DepthMoments brute_force(const MomentImage& in, const VarianceOptions& options, int i, int j) {
    const int half = options.tent / 2;
    const auto tent = [&](int x, int y) {
        double mean = 0;
        double square = 0;
        double weights = 0;
        for (int dy = -half; dy <= half; ++dy)
            for (int dx = -half; dx <= half; ++dx) {
                const double weight = (half + 1.0 - std::abs(dx)) * (half + 1.0 - std::abs(dy));
                const bool inside = x + dx >= 0 && x + dx < in.width && y + dy >= 0 && y + dy < in.height;
                const DepthMoments m = inside ? in.texels[in.texel(x + dx, y + dy)] : DepthMoments{};
                mean += weight * static_cast<double>(m.mean);
                square += weight * static_cast<double>(m.square);
                weights += weight;
            }
        return std::pair(mean / weights, square / weights);
    };
    const int d = options.downsample;
    if (options.reduction == Reduction::kKept) {
        const auto [mean, square] = tent(d * i + d / 2, d * j + d / 2);
        return {static_cast<float>(mean), static_cast<float>(square)};
    }
    double mean = 0;
    double square = 0;
    for (int y = 0; y < d; ++y)
        for (int x = 0; x < d; ++x) {
            const auto [m, s] = tent(d * i + x, d * j + y);
            mean += m / (d * d);
            square += s / (d * d);
        }
    return {static_cast<float>(mean), static_cast<float>(square)};
}

TEST(VarianceShadowMapTest, ConversionIsTheTentAndTheReduction) {
    const MomentImage in = random_moments(37, 22, 5);
    for (const Reduction reduction : {Reduction::kKept, Reduction::kMean})
        for (const auto& [tent, downsample] : {std::pair(15, 4), std::pair(1, 1), std::pair(5, 3)}) {
            VarianceOptions options;
            options.tent = tent;
            options.downsample = downsample;
            options.reduction = reduction;
            const MomentImage out = converted(in, options, 2);
            ASSERT_EQ(out.width, (37 + downsample - 1) / downsample);
            ASSERT_EQ(out.height, (22 + downsample - 1) / downsample);
            for (int y = 0; y < out.height; ++y)
                for (int x = 0; x < out.width; ++x) {
                    const DepthMoments expected = brute_force(in, options, x, y);
                    EXPECT_NEAR(out.texels[out.texel(x, y)].mean, expected.mean, 3e-7f);
                    EXPECT_NEAR(out.texels[out.texel(x, y)].square, expected.square, 3e-7f);
                }
        }
}

// A tent of 15 x 15 averages as much as 141.8 equal texels would: (344 / 4096)^2 of a texel's variance.
TEST(VarianceShadowMapTest, TheTentLeavesTheSquareOfItsWeightsOfTheNoise) {
    const AxisKernel kernel = conversion_kernel({});
    double sum = 0;
    double squares = 0;
    for (const double w : kernel.weights) {
        sum += w;
        squares += w * w;
    }
    EXPECT_NEAR(sum, 1.0, 1e-14);
    EXPECT_NEAR(squares, 344.0 / 4096, 1e-14);
    EXPECT_NEAR(1 / (squares * squares), 141.8, 0.05);

    constexpr int kSide = 192;
    constexpr int kBorder = 8;  // texels that see the map's border
    constexpr double kRho = 0.4;
    TraceHeader header = test::header_of(kSide, kSide);
    TestFrame frame("colored_shadow_map:wavelengths=1", header, 11);
    std::vector<Fragment> fragments;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
            fragments.push_back(fragment_at(x, y, 0.25f, static_cast<float>(kRho), {1, 1, 1}));
    frame.draw(fragments);
    VarianceOptions options;
    options.downsample = 1;
    const MomentImage filtered = converted(
        stored_moments(stored_depths_of(frame.declaration(), frame.stores(), header, "depth")), options, 2);
    const double mean = kRho * 0.25 + (1 - kRho);
    double measured = 0;
    constexpr double kCount = (kSide - 2.0 * kBorder) * (kSide - 2.0 * kBorder);
    for (int y = kBorder; y < kSide - kBorder; ++y)
        for (int x = kBorder; x < kSide - kBorder; ++x) {
            const double error = static_cast<double>(filtered.texels[filtered.texel(x, y)].mean) - mean;
            measured += error * error / kCount;
        }
    const double expected = kRho * (1 - kRho) * 0.75 * 0.75 * squares * squares;
    // The mean square of a field with autocorrelation r along each axis: variance 2 expected^2 (sum r^2)^2 /
    // n.
    double correlation = 0;
    for (int lag = -14; lag <= 14; ++lag) {
        double r = 0;
        for (int i = 0; i < 15; ++i)
            if (i + lag >= 0 && i + lag < 15)
                r += kernel.weights[static_cast<std::size_t>(i)] *
                     kernel.weights[static_cast<std::size_t>(i + lag)] / squares;
        correlation += r * r;
    }
    EXPECT_NEAR(measured, expected, 5 * expected * correlation * std::sqrt(2 / kCount));
}

DepthMoments of_depths(const std::vector<std::pair<double, double>>& probabilities_and_depths) {
    double mean = 0;
    double square = 0;
    for (const auto& [p, z] : probabilities_and_depths) {
        mean += p * z;
        square += p * z * z;
    }
    return {static_cast<float>(mean), static_cast<float>(square)};
}

VarianceOptions exactly() {
    VarianceOptions options;
    options.min_variance = 0;
    return options;
}

TEST(Chebyshev, IsExactForOneOccluderBeforeTheReceiverInTheMap) {
    for (const double rho : {0.1, 0.5, 0.9})
        EXPECT_NEAR(chebyshev_visibility(of_depths({{rho, 0.25}, {1 - rho, 0.75}}), 0.75, exactly()), 1 - rho,
                    2e-6);
    EXPECT_EQ(chebyshev_visibility({0.5f, 0.25f}, 0.5, exactly()), 1.0);
    EXPECT_EQ(chebyshev_visibility({0.5f, 0.25f}, 0.25, exactly()), 1.0);
    EXPECT_EQ(chebyshev_visibility({0.5f, 0.25f}, 0.75, exactly()), 0.0);
}

// Where what kept nothing holds the far plane, the receiver is not in the map: it is compared with a mean
// beyond its own depth, and half of the light's shadow, or all of it, is lost.
TEST(Chebyshev, LosesTheShadowWhereEmptyTexelsHoldTheFarPlane) {
    const auto far = [](double rho, double receiver) {
        return chebyshev_visibility(of_depths({{rho, 0.25}, {1 - rho, 1.0}}), receiver, exactly());
    };
    EXPECT_EQ(far(0.3, 0.75), 1.0) << "mean 0.775 lies behind the receiver: lit, not 0.7";
    // rho = 0.6: mean 0.55, variance 0.135; 0.135 / (0.135 + 0.04) where 0.4 is right.
    EXPECT_NEAR(far(0.6, 0.75), 0.135 / 0.175, 2e-6);
    EXPECT_NEAR(far(0.6, 1.0), 0.4, 2e-6) << "right at the far plane itself";
}

// "And accept the light leaking": behind two layers of half alpha at 0.2 and 0.6 a receiver at 0.8 sees a
// quarter of the light; the bound, from mean 0.45 and variance 0.0675, lets 0.3553 through.
TEST(Chebyshev, LeaksBehindTwoOccluders) {
    const auto behind_two = [](double first, double second) {
        return chebyshev_visibility(of_depths({{0.5, first}, {0.25, second}, {0.25, 0.8}}), 0.8, exactly());
    };
    EXPECT_NEAR(behind_two(0.2, 0.6), 0.0675 / (0.0675 + 0.35 * 0.35), 2e-6);
    EXPECT_NEAR(behind_two(0.2, 0.6), 0.3553, 5e-5);
    EXPECT_NEAR(behind_two(0.2, 0.2), 0.25, 2e-6) << "no leak from two layers at one depth";
    EXPECT_GT(behind_two(0.2, 0.79), 0.49) << "the nearer the second is to the receiver the less it casts";
    VarianceOptions reduced = exactly();
    reduced.light_bleeding = 0.25;
    EXPECT_NEAR(chebyshev_visibility(of_depths({{0.5, 0.2}, {0.25, 0.6}, {0.25, 0.8}}), 0.8, reduced),
                (0.0675 / 0.19 - 0.25) / 0.75, 2e-6);
}

TEST(Chebyshev, SmallVariancesAreRaised) {
    VarianceOptions options;
    options.min_variance = 0.01;
    EXPECT_NEAR(chebyshev_visibility({0.5f, 0.25f}, 0.6, options), 0.5, 1e-6);
    // Squares that rounding puts below the mean's are no variance.
    EXPECT_EQ(chebyshev_visibility({0.5f, 0.2499999f}, 0.6, exactly()), 0.0);
}

// The mean depth that a look-up sees, from its visibility under a variance of one: 1 / (1 + (z - mean)^2).
double mean_seen(const VarianceShadowMap& map, double x, double y) {
    const double visibility = map.visibility(x, y, 2.0);
    return 2.0 - std::sqrt(1 / visibility - 1);
}

TEST(VarianceShadowMapTest, LookUpsKnowWhereReducedTexelsLie) {
    MomentImage ramp{64, 64, {}};
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) {
            const float z = static_cast<float>(x + 0.5) / 128 + static_cast<float>(y + 0.5) / 256;
            ramp.texels.push_back({z, z * z});
        }
    for (const Reduction reduction : {Reduction::kKept, Reduction::kMean})
        for (const int downsample : {1, 3, 4}) {
            VarianceOptions options;
            options.tent = 5;
            options.downsample = downsample;
            options.reduction = reduction;
            options.min_variance = 1;
            const VarianceShadowMap map(converted(ramp, options, 1), options);
            // A filter leaves a ramp, and bilinear fetches walk it.
            for (const double x : {20.0, 31.3, 40.5})
                EXPECT_NEAR(mean_seen(map, x, 30.25), x / 128 + 30.25 / 256, 1e-6) << downsample;
            options.bilinear = false;
            const VarianceShadowMap nearest(map.image(), options);
            const double off = std::abs(mean_seen(nearest, 31.3, 30.25) - (31.3 / 128 + 30.25 / 256));
            EXPECT_LE(off, 0.5 * downsample * (1.0 / 128 + 1.0 / 256) + 1e-6);
        }
}

TEST(VarianceShadowMapTest, StoredMomentsAreMeansOverSamples) {
    const StoredShadowMap map{2, 1, 2, {0.25f, 0.75f, 1.0f, std::numeric_limits<float>::infinity()}, {}, {}};
    const MomentImage moments = stored_moments(map);
    EXPECT_EQ(moments.texels[0].mean, 0.5f);
    EXPECT_EQ(moments.texels[0].square, 0.3125f);
    EXPECT_EQ(moments.texels[1].mean, 1.0f) << "nothing opaque is the far plane";
    EXPECT_EQ(moments.texels[1].square, 1.0f);
}

}  // namespace
}  // namespace ropsim
