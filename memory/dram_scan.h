// The bank whose command comes first: the least of one key a bank, two or four banks at a time.
#pragma once

#include "memory/dram_banks.h"

#include <array>
#include <cstdint>
#include <vector>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace ropsim {

// The candidates of one kind of command, by bank. As the bits of doubles, which compare as the integers they
// are if positive: neither SSE2 nor AVX2 has another minimum and maximum of 64 bits. A candidate is written
// as one number of 16 bytes, just before a scan reads it: a processor hands a load only what one store holds
// whole.
class DramScanKeys {
 public:
    static constexpr std::uint64_t kTimeBias = std::uint64_t{0x433} << 52;
    static constexpr std::uint64_t kKeyBias = std::uint64_t{1} << 62;
    static constexpr std::uint64_t kAbsent = (std::uint64_t{0x5ff} << 52) | ((std::uint64_t{1} << 52) - 1);
    static constexpr std::uint64_t kUnbound = std::uint64_t{1} << 63;
    static constexpr int kTimeShift = 41;                       // a key: time ahead, then order
    static constexpr DramCycle kFarthest = DramCycle{1} << 20;  // times ahead are below

    struct alignas(16) Key {
        std::uint64_t time;  // kTimeBias + the bank's own earliest; kUnbound: rules between banks do not hold
        std::uint64_t order;  // kKeyBias + order, or kAbsent
    };

    DramScanKeys() {
        for (std::size_t bank = 0; bank < keys_.size(); ++bank) drop(bank);
    }
    bool has(std::size_t bank) const { return keys_[bank].order != kAbsent; }
    DramCycle time_of(std::size_t bank) const { return (keys_[bank].time & ~kUnbound) - kTimeBias; }
    std::uint64_t order_of(std::size_t bank) const { return keys_[bank].order - kKeyBias; }
    bool bound(std::size_t bank) const { return (keys_[bank].time & kUnbound) == 0; }
    void set(std::size_t bank, DramCycle time, bool bound, std::uint64_t order) {
        store(bank, (kTimeBias + time) | (bound ? 0 : kUnbound), kKeyBias + order);
    }
    void drop(std::size_t bank) { store(bank, kTimeBias, kAbsent); }
    void make_older(std::size_t bank, std::uint64_t by) { keys_[bank].order -= by; }
    const Key* from(std::size_t bank) const { return &keys_[bank]; }

 private:
    void store(std::size_t bank, std::uint64_t time, std::uint64_t order) {
#ifdef __SSE2__
        _mm_store_si128(reinterpret_cast<__m128i*>(&keys_[bank]),
                        _mm_set_epi64x(static_cast<long long>(order), static_cast<long long>(time)));
#else
        keys_[bank] = {time, order};
#endif
    }

    alignas(64) std::array<Key, DramBanks::kMaxBanks> keys_;
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

// The fastest that this processor and so many groups of so many banks allow; nullptr: none. Where all are
// `all_bound` none may be kUnbound.
DramScan dram_scan_for(std::uint32_t groups, std::uint32_t in_group, bool all_bound);
// Those there are for them. For tests.
std::vector<DramScan> dram_scans(std::uint32_t groups, std::uint32_t in_group, bool all_bound);

}  // namespace ropsim
