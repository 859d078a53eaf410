// Every way to find the first candidate against its definition, bank by bank.
#include "memory/dram_scan.h"

#include "base/random.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr std::uint32_t kGroups = 8;

std::uint64_t bank_by_bank(const DramScanKeys& keys, const DramScanRange& range, const DramCycle* limit,
                           DramCycle floor) {
    std::uint64_t best = DramScanKeys::kAbsent;
    for (std::uint32_t bank = range.bank; bank < range.bank + range.groups * range.in_group; ++bank) {
        if (!keys.has(bank)) continue;
        DramCycle time = std::max(keys.time_of(bank), floor);
        if (keys.bound(bank)) time = std::max(time, limit[(bank - range.bank) / range.in_group]);
        best = std::min(best, ((time - floor) << DramScanKeys::kTimeShift) + DramScanKeys::kKeyBias +
                                  keys.order_of(bank));
    }
    return best;
}

// Banks in a group, whether rules between banks hold for all of them.
class DramScanOf : public testing::TestWithParam<std::tuple<std::uint32_t, bool>> {};

TEST_P(DramScanOf, AgreesWithItsDefinition) {
    const auto [in_group, all_bound] = GetParam();
    const std::uint32_t banks = kGroups * in_group;
    for (std::uint64_t round = 0; round < 3000; ++round) {
        const DramCycle now = mix64(round) >> 20;  // far beyond 32 bits
        DramScanKeys keys;
        std::array<DramCycle, kGroups> limit{};
        for (std::uint32_t g = 0; g < kGroups; ++g)
            limit[g] = now + mix64(round * 131 + g) % 200 - std::min<DramCycle>(now, 100);
        for (std::uint32_t bank = 0; bank < banks; ++bank) {
            const std::uint64_t r = mix64(round * 977 + bank);
            // times long past, near, and as far ahead as they may be
            const std::uint64_t far = (r >> 8) % 3 == 0   ? 0
                                      : (r >> 8) % 3 == 1 ? now + r % 150
                                                          : now + 1000000;
            // few orders, so that times and orders tie; the bank tells them apart
            const std::uint64_t order = ((r >> 24) % 4) << 39 | ((r >> 32) % 3) << 8 | bank;
            keys.set(bank, far, all_bound || (r >> 16 & 1) != 0, order);
            if ((r >> 40) % 4 == 0) keys.drop(bank);
        }
        const std::uint32_t groups = 1 + static_cast<std::uint32_t>(round % kGroups);
        const std::uint32_t skipped = (round / kGroups) % 2 == 0 ? 0 : kGroups - groups;
        const DramScanRange range{skipped * in_group, groups, in_group};
        const std::vector<DramScan> scans = dram_scans(groups, in_group, all_bound);
#ifdef __SSE2__
        ASSERT_FALSE(scans.empty());
#endif
        ASSERT_EQ(dram_scan_for(groups, in_group, all_bound), scans.empty() ? nullptr : scans.back());
        for (const DramScan scan : scans)
            ASSERT_EQ(scan(keys, range, &limit[skipped], now),
                      bank_by_bank(keys, range, &limit[skipped], now))
                << round;
    }
}
INSTANTIATE_TEST_SUITE_P(Groups, DramScanOf, testing::Combine(testing::Values(2u, 4u, 8u), testing::Bool()));

TEST(DramScan, NoneIsFoundAmongNone) {
    const DramScanKeys keys;
    const std::array<DramCycle, 4> limit{7, 5, 3, 1};
    for (const bool all_bound : {false, true})
        for (const DramScan scan : dram_scans(4, 4, all_bound))
            EXPECT_EQ(scan(keys, {0, 4, 4}, limit.data(), 1000), DramScanKeys::kAbsent);
}

TEST(DramScan, GroupsOfOneHaveNone) {
    EXPECT_TRUE(dram_scans(4, 1, false).empty());
    EXPECT_EQ(dram_scan_for(4, 1, false), nullptr);
}

}  // namespace
}  // namespace ropsim
