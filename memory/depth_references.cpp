// Depths as one of four high parts and low bits.
#include "memory/depth_references.h"

#include <algorithm>

namespace ropsim {

int reference_low_bits(std::uint32_t room, std::uint32_t count, std::uint32_t depth_bits) {
    const int all = static_cast<int>(room) - 2 * static_cast<int>(depth_bits) - 2 * static_cast<int>(count);
    // Each low bit takes one from both high parts.
    const int each = static_cast<int>(count) - 2;
    if (all < 0 && each <= 0) return -1;
    if (each <= 0) return 0;
    if (all < 0) return -1;
    return std::min(all / each, static_cast<int>(depth_bits) - 1);
}

}  // namespace ropsim
