// The Hilbert curve as a pixel index: nearby pixels get nearby indices (Hilbert 1891).
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <utility>

namespace ropsim {

// Smallest order n whose 2^n x 2^n square holds the image.
constexpr int hilbert_order(int width, int height) {
    return static_cast<int>(std::bit_width(static_cast<unsigned>(std::max(width, height) - 1)));
}

// Distance along the curve of order `order` that starts at (0, 0) and ends at (2^order - 1, 0).
constexpr std::uint32_t hilbert_index(int order, int x, int y) {
    auto u = static_cast<std::uint32_t>(x);
    auto v = static_cast<std::uint32_t>(y);
    std::uint32_t index = 0;
    for (std::uint32_t side = order > 0 ? 1u << (order - 1) : 0u; side > 0; side /= 2) {
        const std::uint32_t right = (u & side) != 0 ? 1u : 0u;
        const std::uint32_t low = (v & side) != 0 ? 1u : 0u;
        index += side * side * ((3u * right) ^ low);
        // Turn the quadrant so that the curve inside it runs the same way.
        if (low == 0) {
            if (right != 0) {
                u = (2 * side - 1) - (u & (2 * side - 1));
                v = (2 * side - 1) - (v & (2 * side - 1));
            }
            std::swap(u, v);
        }
    }
    return index;
}

}  // namespace ropsim
