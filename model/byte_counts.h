// Bytes that were moved, by direction, surface and cause.
#pragma once

#include "memory/memory_cause.h"

#include <array>
#include <cstdint>
#include <vector>

namespace ropsim {

struct ReadWriteBytes {
    std::uint64_t read = 0;
    std::uint64_t write = 0;
    std::uint64_t sum() const { return read + write; }
};

struct CauseBytes {
    std::uint64_t read = 0;
    std::uint64_t write = 0;
    std::uint64_t forwarded = 0;  // of the reads: answered by the channel's write queue without the pins
};
// [surface][cause]
using BytesByCause = std::vector<std::array<CauseBytes, kMemoryCauses>>;

}  // namespace ropsim
