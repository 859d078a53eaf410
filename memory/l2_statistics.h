// What a slice of the second-level cache counts.
#pragma once

#include "memory/memory_cause.h"
#include "memory/rop_cache.h"

#include <array>
#include <cstdint>

namespace ropsim {

// What the look-up stage did in a cycle.
enum class L2Label : std::uint8_t {
    kBusy,
    kIdle,
    kReadsFull,     // as many reads as can be between look-up and answer
    kMshrsFull,     // no miss register left
    kRequestQueue,  // the queue between slice and memory is full
    kWays,          // every way of the set waits for its fill
};
inline constexpr int kL2Labels = 6;

struct PortBytes {
    std::uint64_t read = 0;
    std::uint64_t write = 0;
};
// [surface][cause]
using PortBytesByCause = std::array<std::array<PortBytes, kMemoryCauses>, kMaxSurfaces>;

struct L2Statistics {
    RopCacheStatistics cache;
    std::uint64_t reads = 0, writes = 0;                  // requests
    PortBytesByCause looked_up{};                         // bytes asked for or written by whoever is above
    PortBytesByCause memory{};                            // bytes between slice and memory
    std::array<std::uint64_t, kL2Labels> label_cycles{};  // sums to `cycles`
    std::uint64_t cycles = 0;

    std::uint64_t label(L2Label which) const { return label_cycles[static_cast<std::size_t>(which)]; }
    // Adds another slice's counts (cycles add up too: slice cycles).
    void add(const L2Statistics& other);
};

}  // namespace ropsim
