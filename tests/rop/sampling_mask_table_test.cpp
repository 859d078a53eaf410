// The mask table of stochastic transparency against the distribution it stands for: uniform S-choose-R masks
// and R of mean alpha S (Enderton et al. 2011, sections 3.1 and 5).
#include "rop/sampling/mask_patterns.h"
#include "rop/sampling/mask_table.h"
#include "tests/rop/sampling_statistics.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr std::uint32_t kEntries = MaskTable::kEntries;
constexpr std::uint32_t kLevels = MaskTable::kLevels;
constexpr int kSampleCounts[] = {1, 2, 3, 8, 12, 64};

TEST(MaskTable, LevelIsTheNearestStep) {
    EXPECT_EQ(MaskTable::level(0.0f), 0u);
    EXPECT_EQ(MaskTable::level(1.0f), 1023u);
    for (std::uint32_t i = 0; i <= 20000; ++i) {
        const float alpha = static_cast<float>(i) / 20000.0f;
        EXPECT_LE(std::abs(static_cast<double>(MaskTable::level(alpha)) - 1023.0 * alpha), 0.5);
    }
    EXPECT_EQ(MaskTable::level(0.9999f / 2046), 0u);
    EXPECT_EQ(MaskTable::level(1.0001f / 2046), 1u);
    EXPECT_EQ(MaskTable::level(std::nextafter(1.0f, 0.0f)), 1023u);
}

TEST(MaskTable, SizeInHardware) {
    EXPECT_EQ(MaskTable(8).bits(), 16769024u);  // 2 MB
    EXPECT_EQ(MaskTable(64).bits(), 134152192u);
}

// In every entry: level 0 none, level 1023 all, a higher level the same samples and more, and R the floor or
// ceiling of alpha S.
TEST(MaskTable, EachEntryGrowsFromNoneToAll) {
    for (const int samples : kSampleCounts) {
        const MaskTable table(samples);
        for (std::uint32_t entry = 0; entry < kEntries; ++entry) {
            ASSERT_EQ(table.mask(entry, 0), 0u);
            ASSERT_EQ(table.mask(entry, kLevels - 1), low_bits(static_cast<std::uint32_t>(samples)));
            std::uint64_t before = 0;
            for (std::uint32_t level = 1; level < kLevels; ++level) {
                const std::uint64_t mask = table.mask(entry, level);
                ASSERT_EQ(mask & before, before) << "entry " << entry << " level " << level;
                const auto floor = static_cast<int>(level) * samples / 1023;
                const auto remainder = static_cast<int>(level) * samples % 1023;
                ASSERT_GE(std::popcount(mask), floor);
                ASSERT_LE(std::popcount(mask), floor + (remainder != 0 ? 1 : 0));
                before = mask;
            }
        }
    }
}

// |mean R / S - level / 1023| <= 1 / (2 * 2047 S), in whole numbers.
TEST(MaskTable, MeanCountIsRightAtEveryLevel) {
    for (const int samples : kSampleCounts) {
        const MaskTable table(samples);
        for (std::uint32_t level = 0; level < kLevels; ++level) {
            std::int64_t sum = 0;
            for (std::uint32_t entry = 0; entry < kEntries; ++entry)
                sum += std::popcount(table.mask(entry, level));
            const std::int64_t error =
                sum * 1023 - static_cast<std::int64_t>(level) * samples * std::int64_t{kEntries};
            ASSERT_LE(2 * std::abs(error), 1023) << samples << " samples, level " << level;
        }
    }
}

// The first R samples of all entries are uniform among the S-choose-R subsets.
TEST(MaskTable, SubsetsAreUniform) {
    const MaskTable table(8);
    const double subsets[] = {1, 8, 28, 56, 70, 56, 28, 8, 1};
    std::map<int, std::map<std::uint64_t, int>> counts;
    for (std::uint32_t entry = 0; entry < kEntries; ++entry) {
        int reached = 0;
        for (std::uint32_t level = 1; level < kLevels; ++level) {
            const std::uint64_t mask = table.mask(entry, level);
            if (std::popcount(mask) == reached) continue;
            reached = std::popcount(mask);
            ++counts[reached][mask];
        }
        ASSERT_EQ(reached, 8);
    }
    for (int count = 1; count < 8; ++count) {
        const double expected = subsets[count];
        EXPECT_LT(test::chi_square(counts[count], expected), test::chi_square_limit(expected - 1))
            << count << " of 8";
    }
}

// At one level R is drawn apart from the order: masks of R samples are uniform among those of R, too.
TEST(MaskTable, CountIsIndependentOfTheOrder) {
    const MaskTable table(8);
    for (const std::uint32_t level : {200u, 450u, 600u, 830u}) {
        std::map<int, std::map<std::uint64_t, int>> counts;
        for (std::uint32_t entry = 0; entry < kEntries; ++entry)
            ++counts[std::popcount(table.mask(entry, level))][table.mask(entry, level)];
        ASSERT_EQ(counts.size(), 2u);
        for (const auto& [count, masks] : counts) {
            double subsets = 1;
            for (int i = 0; i < count; ++i) subsets = subsets * (8 - i) / (i + 1);
            EXPECT_LT(test::chi_square(masks, subsets), test::chi_square_limit(subsets - 1))
                << "level " << level << ", " << count << " of 8";
        }
    }
}

// Where half of the entries round up, the next entry does as often after one that does as after one that does
// not.
TEST(MaskTable, NeighbouringEntriesAreUnrelated) {
    const MaskTable table(8);
    int alike = 0;
    for (std::uint32_t entry = 1; entry < kEntries; ++entry)
        if (std::popcount(table.mask(entry, 64)) == std::popcount(table.mask(entry - 1, 64))) ++alike;
    EXPECT_NEAR(alike, kEntries / 2.0, 5 * std::sqrt(kEntries) / 2);
}

// Of 64 samples each is selected as often as any other at alpha 1/2; with R fixed within one, the sum over
// samples of (n - mean)^2 / (entries / 4) is a chi-square of 63 degrees of freedom times 64 / 63.
TEST(MaskTable, SamplesAreSelectedEquallyOften) {
    const MaskTable table(64);
    std::array<int, 64> counts{};
    for (std::uint32_t entry = 0; entry < kEntries; ++entry)
        for (std::size_t s = 0; s < 64; ++s) counts[s] += static_cast<int>(table.mask(entry, 512) >> s & 1);
    double total = 0;
    for (const int count : counts) total += count;
    double sum = 0;
    for (const int count : counts) sum += std::pow(count - total / 64, 2) / (kEntries / 4.0);
    EXPECT_LT(sum * 63 / 64, test::chi_square_limit(63));
    EXPECT_GT(sum * 63 / 64, 20) << "more even than random orders are";
}

// "Quantizes alpha to approximately 10 bits": the largest error of the mean of R / S is half a step, 1/2046,
// and the mean error a quarter of one.
TEST(MaskTable, QuantisationOfAlpha) {
    const int samples = 8;
    const MaskTable table(samples);
    std::array<double, kLevels> mean{};
    for (std::uint32_t level = 0; level < kLevels; ++level) {
        for (std::uint32_t entry = 0; entry < kEntries; ++entry)
            mean[level] += std::popcount(table.mask(entry, level));
        mean[level] /= static_cast<double>(kEntries) * samples;
    }
    double largest = 0;
    double sum = 0;
    constexpr int kSteps = 1 << 18;
    for (int i = 0; i <= kSteps; ++i) {
        const float alpha = static_cast<float>(i) / kSteps;
        const double error = std::abs(mean[MaskTable::level(alpha)] - alpha);
        largest = std::max(largest, error);
        sum += error;
    }
    EXPECT_LE(largest, 1.0 / 2046 + 1.0 / (2 * kEntries * samples));
    EXPECT_GT(largest, 0.95 / 2046);
    EXPECT_NEAR(sum / kSteps, 1.0 / 4092, 0.02 / 4092);
}

// The table is data that images depend on.
TEST(MaskTable, IsTheSameEverywhere) {
    std::uint64_t checksum = 0xCBF29CE484222325ull;  // FNV-1a over words
    const MaskTable table(8);
    for (std::uint32_t entry = 0; entry < kEntries; ++entry)
        for (std::uint32_t level = 0; level < kLevels; ++level)
            checksum = (checksum ^ table.mask(entry, level)) * 0x100000001B3ull;
    EXPECT_EQ(checksum, 7010780909123653655u);
}

}  // namespace
}  // namespace ropsim
