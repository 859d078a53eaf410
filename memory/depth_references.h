// Depths as one of four high parts and low bits, as ATTILA's HILO codes blocks.
#pragma once

#include "memory/depth_planes.h"

#include <array>
#include <cstdint>

namespace ropsim {

// The high parts of the least and the largest depth, one above the first and one below the second.
struct DepthReferences {
    std::uint32_t low = 0;  // bits of a depth below its high part
    std::array<std::uint32_t, 4> high;

    DepthReferences(std::uint32_t least_high, std::uint32_t largest_high, std::uint32_t low_count)
        : low(low_count), high{least_high, largest_high, least_high + 1, largest_high - 1} {}
    // Which of them a depth has; 4: none.
    std::uint32_t index(std::uint32_t z) const {
        for (std::uint32_t r = 0; r < 4; ++r)
            if (z >> low == high[r]) return r;
        return 4;
    }
};

// Low bits a depth when `room` bits hold two high parts and, for each depth, two bits and its low ones. Below
// the depth's bits; -1 if there is no room even for none.
int reference_low_bits(std::uint32_t room, std::uint32_t count, std::uint32_t depth_bits);

}  // namespace ropsim
