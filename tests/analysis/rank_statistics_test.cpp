// Intervals by ranks against enumeration, and how often they hold the truth.
#include "analysis/bench/rank_statistics.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

// Each of n values lies below the median or above it: the share of the 2^n ways in which the k-th from below
// and the k-th from above enclose it.
double enclosing_share(unsigned n, unsigned k) {
    unsigned held = 0;
    for (unsigned way = 0; way < 1u << n; ++way) {
        const auto below = static_cast<unsigned>(std::popcount(way));
        held += below >= k && n - below >= k ? 1 : 0;
    }
    return static_cast<double>(held) / static_cast<double>(1u << n);
}

TEST(MedianInterval, IsTheNarrowestOfItsConfidence) {
    for (unsigned n = 1; n <= 18; ++n) {
        std::vector<double> values(n);
        std::iota(values.begin(), values.end(), 1.0);  // the k-th is k
        std::reverse(values.begin(), values.end());
        const RankInterval i = median_interval(values);
        const auto k = static_cast<unsigned>(i.low);
        EXPECT_EQ(i.high, n + 1 - k) << n;
        EXPECT_EQ(i.estimate, (n + 1) / 2.0) << n;
        EXPECT_NEAR(i.confidence, enclosing_share(n, k), 1e-12) << n;
        EXPECT_TRUE(n < 6 || i.confidence >= 0.95) << n;
        EXPECT_TRUE(n >= 6 || k == 1) << n;
        EXPECT_TRUE(2 * (k + 1) > n || enclosing_share(n, k + 1) < 0.95) << n;
    }
    // Of tables.
    EXPECT_NEAR(median_interval(std::vector<double>(10, 1.0)).confidence, 0.978515625, 1e-12);
    EXPECT_NEAR(median_interval(std::vector<double>(20, 1.0)).confidence, 0.958610534667969, 1e-12);
}

TEST(MedianInterval, HoldsTheMedianOfSkewedNoiseAsOftenAsItSays) {
    for (const std::size_t n : {5u, 7u, 12u}) {
        std::mt19937_64 random(n);
        std::exponential_distribution<double> noise(1);
        constexpr int kRounds = 20000;
        int held = 0;
        double confidence = 0;
        for (int round = 0; round < kRounds; ++round) {
            std::vector<double> values(n);
            for (double& v : values) v = noise(random);
            const RankInterval i = median_interval(values);
            confidence = i.confidence;
            held += i.low <= std::log(2.0) && std::log(2.0) <= i.high ? 1 : 0;
        }
        const double sigma = std::sqrt(confidence * (1 - confidence) / kRounds);
        EXPECT_NEAR(static_cast<double>(held) / kRounds, confidence, 4 * sigma) << n;
    }
}

TEST(RankSum, CountsAreThoseOfEnumeration) {
    for (unsigned n = 1; n <= 6; ++n)
        for (unsigned m = 1; m <= 6; ++m) {
            // Bit i: whether the i-th value in ascending order is of the first kind.
            std::vector<double> counts(n * m + 1, 0.0);
            for (unsigned order = 0; order < 1u << (n + m); ++order) {
                if (static_cast<unsigned>(std::popcount(order)) != n) continue;
                unsigned pairs = 0;
                unsigned second = 0;
                for (unsigned i = 0; i < n + m; ++i) {
                    if ((order >> i & 1) != 0)
                        pairs += second;
                    else
                        ++second;
                }
                ++counts[pairs];
            }
            EXPECT_EQ(rank_sum_counts(n, m), counts) << n << " " << m;
        }
}

TEST(ShiftInterval, OfFiveAndFiveGoesFromEndToEnd) {
    const std::optional<RankInterval> i = shift_interval({3, 1, 2, 5, 4}, {14, 11, 15, 12, 13}, 0.99);
    ASSERT_TRUE(i.has_value());
    EXPECT_EQ(i->estimate, 10);
    EXPECT_EQ(i->low, 11 - 5);
    EXPECT_EQ(i->high, 15 - 1);
    EXPECT_NEAR(i->confidence, 1 - 2.0 / 252, 1e-12);
    EXPECT_FALSE(shift_interval({1, 2, 3, 4}, {1, 2, 3, 4}, 0.99).has_value());  // 1 - 2/70
    EXPECT_FALSE(shift_interval({}, {1, 2}, 0.5).has_value());
}

TEST(ShiftInterval, HoldsTheShiftAsOftenAsItSays) {
    for (const auto& [n, m] : {std::pair{5u, 5u}, {7u, 6u}, {4u, 12u}}) {
        std::mt19937_64 random(n);
        std::cauchy_distribution<double> noise(0, 1);  // without a mean
        constexpr int kRounds = 20000;
        int held = 0;
        double confidence = 0;
        for (int round = 0; round < kRounds; ++round) {
            std::vector<double> earlier(n);
            std::vector<double> later(m);
            for (double& v : earlier) v = noise(random);
            for (double& v : later) v = noise(random) + 3;
            const std::optional<RankInterval> i = shift_interval(earlier, later, 0.95);
            ASSERT_TRUE(i.has_value());
            confidence = i->confidence;
            held += i->low <= 3 && 3 <= i->high ? 1 : 0;
        }
        EXPECT_GE(confidence, 0.95);
        const double sigma = std::sqrt(confidence * (1 - confidence) / kRounds);
        EXPECT_NEAR(static_cast<double>(held) / kRounds, confidence, 4 * sigma) << n << " " << m;
    }
}

}  // namespace
}  // namespace ropsim
