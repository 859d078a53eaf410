// The Morton order of pixels, which Laine and Karras 2011 (section 3.1) rejects for the Hilbert curve
// (rop/hilbert.h).
#pragma once

#include <cstdint>

namespace ropsim {

// The bits of x and y, each below 2^16, in turns; x has the lowest.
constexpr std::uint32_t morton_index(int x, int y) {
    const auto spread = [](std::uint32_t v) {
        v = (v | (v << 8)) & 0x00FF00FFu;
        v = (v | (v << 4)) & 0x0F0F0F0Fu;
        v = (v | (v << 2)) & 0x33333333u;
        return (v | (v << 1)) & 0x55555555u;
    };
    return spread(static_cast<std::uint32_t>(x)) | (spread(static_cast<std::uint32_t>(y)) << 1);
}

}  // namespace ropsim
