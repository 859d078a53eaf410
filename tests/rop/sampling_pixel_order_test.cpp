// The Morton order of pixels.
#include "rop/sampling/pixel_order.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

// Quadrant by quadrant: the index of a square's pixel is its quadrant's number, then its index in that.
std::uint32_t by_quadrants(int side, int x, int y) {
    if (side == 1) return 0;
    const int half = side / 2;
    const int quadrant = 2 * (y / half) + x / half;
    return static_cast<std::uint32_t>(quadrant * half * half) + by_quadrants(half, x % half, y % half);
}

TEST(Morton, IsTheOrderOfQuadrants) {
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x) ASSERT_EQ(morton_index(x, y), by_quadrants(64, x, y));
    EXPECT_EQ(morton_index(0xFFFF, 0), 0x55555555u);
    EXPECT_EQ(morton_index(0, 0xFFFF), 0xAAAAAAAAu);
    EXPECT_EQ(morton_index(1, 0), 1u);
}

}  // namespace
}  // namespace ropsim
