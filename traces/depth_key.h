// A depth as a whole number that sorts like it.
#pragma once

#include <bit>
#include <cstdint>

namespace ropsim {

// Ascends with z for every z that is a number; -0 and +0 are one.
inline std::uint32_t depth_key(float z) {
    const auto bits = std::bit_cast<std::uint32_t>(z + 0.0f);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

}  // namespace ropsim
