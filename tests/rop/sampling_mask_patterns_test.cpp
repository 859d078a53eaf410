// Masks and dither patterns against their definitions, by enumeration.
#include "rop/sampling/mask_patterns.h"

#include <array>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

TEST(RunMask, IsACyclicRun) {
    for (int samples = 1; samples <= 64; ++samples)
        for (int start = 0; start < samples; ++start)
            for (int count = 0; count <= samples; ++count) {
                std::uint64_t expected = 0;
                for (int i = 0; i < count; ++i) expected |= std::uint64_t{1} << ((start + i) % samples);
                ASSERT_EQ(
                    run_mask(samples, static_cast<std::uint32_t>(start), static_cast<std::uint32_t>(count)),
                    expected)
                    << samples << " samples, " << count << " from " << start;
            }
}

TEST(RunMask, StartIsTakenModuloTheSamples) {
    EXPECT_EQ(run_mask(8, 0xFFFFFFFFu, 3), 0b10000011u);
    EXPECT_EQ(run_mask(12, 26, 1), 0b100u);
    EXPECT_EQ(run_mask(64, 127, 2), 0x8000000000000001u);
}

TEST(AlphaToCoverage, CountIsTheNearest) {
    for (const int samples : {1, 2, 3, 4, 8, 12, 16, 64}) {
        EXPECT_EQ(alpha_to_coverage_mask(samples, 0.0f), 0u);
        EXPECT_EQ(alpha_to_coverage_mask(samples, 1.0f), low_bits(static_cast<std::uint32_t>(samples)));
        for (int i = 0; i <= 1000; ++i) {
            const float alpha = static_cast<float>(i) / 1000.0f;
            const int count = std::popcount(alpha_to_coverage_mask(samples, alpha));
            ASSERT_LE(std::abs(count - static_cast<double>(alpha) * samples), 0.5);
        }
    }
    EXPECT_EQ(std::popcount(alpha_to_coverage_mask(8, 0.0625f)), 1) << "half up";
    EXPECT_EQ(alpha_to_coverage_mask(8, std::nextafter(0.0625f, 0.0f)), 0u);
}

// Stored samples in the order in which they are switched on.
std::vector<int> coverage_order(int samples) {
    std::vector<int> order;
    std::uint64_t before = 0;
    for (int count = 1; count <= samples; ++count) {
        const std::uint64_t mask =
            alpha_to_coverage_mask(samples, static_cast<float>(count) / static_cast<float>(samples));
        EXPECT_EQ(mask & before, before) << "samples stay on as alpha rises";
        order.push_back(std::countr_zero(mask & ~before));
        before = mask;
    }
    return order;
}

TEST(AlphaToCoverage, OneOrderForAllAlphas) {
    EXPECT_EQ(coverage_order(4), (std::vector<int>{0, 3, 2, 1}));
    EXPECT_EQ(coverage_order(8), (std::vector<int>{0, 5, 2, 7, 4, 1, 6, 3}));
    for (int samples = 1; samples <= 64; ++samples) {
        const std::vector<int> order = coverage_order(samples);
        EXPECT_EQ(std::set<int>(order.begin(), order.end()).size(), order.size());
    }
}

// With M spatial samples, stored sample s at s mod M: any M switched on in a row lie at all M.
TEST(AlphaToCoverage, IsSpreadOverTheSpatialSamples) {
    for (const int samples : {4, 8, 16, 32, 64}) {
        const std::vector<int> order = coverage_order(samples);
        for (int spatial = 2; spatial <= std::min(16, samples); spatial *= 2)
            for (int first = 0; first + spatial <= samples; ++first) {
                std::set<int> places;
                for (int i = 0; i < spatial; ++i)
                    places.insert(order[static_cast<std::size_t>(first + i)] % spatial);
                ASSERT_EQ(places.size(), static_cast<std::size_t>(spatial));
            }
    }
}

int dither_rank(int x, int y) {
    return static_cast<int>(dither_threshold(x, y) * 64.0f - 0.5f);
}

TEST(Dither, IsBayersMatrix) {
    const std::array<int, 8> first = {0, 32, 8, 40, 2, 34, 10, 42};
    const std::array<int, 8> second = {48, 16, 56, 24, 50, 18, 58, 26};
    for (int x = 0; x < 8; ++x) {
        EXPECT_EQ(dither_rank(x, 0), first[static_cast<std::size_t>(x)]);
        EXPECT_EQ(dither_rank(x, 1), second[static_cast<std::size_t>(x)]);
    }
}

// Each of (i + 1/2) / 64 once in any aligned tile, one of each quarter in any 2 x 2 pixels of it and one of
// each sixteenth in any 4 x 4.
TEST(Dither, EachThresholdOnceATile) {
    for (const auto& [side, ranks] : {std::pair(8, 1), std::pair(4, 4), std::pair(2, 16)})
        for (int top = -16; top < 16; top += side)
            for (int left = -16; left < 16; left += side) {
                std::set<int> seen;
                for (int y = 0; y < side; ++y)
                    for (int x = 0; x < side; ++x) {
                        const float threshold = dither_threshold(left + x, top + y);
                        const int rank = dither_rank(left + x, top + y);
                        ASSERT_EQ(threshold, (static_cast<float>(rank) + 0.5f) / 64.0f);
                        seen.insert(rank / ranks);
                    }
                ASSERT_EQ(seen.size(), static_cast<std::size_t>(side * side));
                ASSERT_EQ(*seen.begin(), 0);
                ASSERT_EQ(*seen.rbegin(), side * side - 1);
            }
}

// In place of the random xi: over a tile, the sum of R = floor(alpha S + threshold) is round(64 alpha S), so
// that its mean is within 1/128 of alpha S in every tile.
TEST(Dither, TileHoldsTheRightNumberOfSamples) {
    for (const int samples : {1, 4, 8, 64})
        for (int i = 0; i <= 997; ++i) {
            const double wanted = static_cast<double>(i) / 997 * samples;
            long sum = 0;
            for (int y = 8; y < 16; ++y)
                for (int x = 24; x < 32; ++x)
                    sum +=
                        static_cast<long>(std::floor(wanted + static_cast<double>(dither_threshold(x, y))));
            ASSERT_EQ(sum, std::lround(64 * wanted)) << samples << " samples, " << i;
        }
}

// r < threshold is r / 2^32 < alpha, which doubles hold exactly.
TEST(AlphaThreshold, ComparesExactly) {
    EXPECT_EQ(alpha_threshold(0.0f), 0u);
    EXPECT_EQ(alpha_threshold(1.0f), std::uint64_t{1} << 32);
    EXPECT_EQ(alpha_threshold(0x1p-40f), 1u);
    float alpha = 1.0f;
    for (int i = 0; i < 750; ++i, alpha = std::nextafter(alpha * 0.97f, 0.0f)) {
        const std::uint64_t threshold = alpha_threshold(alpha);
        for (const std::uint64_t r : {threshold - 1, threshold})
            ASSERT_EQ(r < threshold, static_cast<double>(r) * 0x1p-32 < static_cast<double>(alpha));
    }
}

}  // namespace
}  // namespace ropsim
