// The bank whose command comes first: the least of one key a bank, two or four banks at a time.
#pragma once

#include "memory/dram_banks.h"

#include <array>
#include <cstdint>
#include <vector>

namespace ropsim {

// The candidates of one kind of command, by bank. As the bits of positive doubles, which compare as the
// integers they are: neither SSE2 nor AVX2 has another minimum and maximum of 64 bits.
struct DramScanKeys {
    static constexpr std::uint64_t kTimeBias = std::uint64_t{0x433} << 52;
    static constexpr std::uint64_t kKeyBias = std::uint64_t{1} << 62;
    static constexpr std::uint64_t kAbsent = (std::uint64_t{0x5ff} << 52) | ((std::uint64_t{1} << 52) - 1);
    static constexpr int kTimeShift = 41;                       // a key: time ahead, then order
    static constexpr DramCycle kFarthest = DramCycle{1} << 20;  // times ahead are below

    alignas(32) std::array<std::uint64_t, DramBanks::kMaxBanks> time;   // kTimeBias + the bank's own earliest
    alignas(32) std::array<std::uint64_t, DramBanks::kMaxBanks> bound;  // all bits: rules between banks hold
    alignas(32) std::array<std::uint64_t, DramBanks::kMaxBanks> order;  // kKeyBias + order, or kAbsent

    DramScanKeys() {
        time.fill(kTimeBias);
        bound.fill(~std::uint64_t{0});
        order.fill(kAbsent);
    }
    DramCycle time_of(std::size_t bank) const { return time[bank] - kTimeBias; }
    std::uint64_t order_of(std::size_t bank) const { return order[bank] - kKeyBias; }
};

// Banks in their groups.
struct DramScanRange {
    std::uint32_t bank;  // the first
    std::uint32_t groups;
    std::uint32_t in_group;
};

// The least of kKeyBias + (max(time, limit, floor) - floor) << kTimeShift + order over the banks of `range`;
// limit[g] are the rules between banks for its group g. kAbsent without any.
using DramScan = std::uint64_t (*)(const DramScanKeys& keys, const DramScanRange& range,
                                   const DramCycle* limit, DramCycle floor);

// The fastest that this processor and so many groups of so many banks allow; nullptr: none. Of `all_bound`
// banks no `bound` is looked at: all must have all bits.
DramScan dram_scan_for(std::uint32_t groups, std::uint32_t in_group, bool all_bound);
// Those there are for them. For tests.
std::vector<DramScan> dram_scans(std::uint32_t groups, std::uint32_t in_group, bool all_bound);

}  // namespace ropsim
