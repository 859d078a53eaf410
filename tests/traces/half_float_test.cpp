// Half floats: exact against the definition, rounding to nearest, ties to even.
#include "traces/half_float.h"

#include <cmath>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

TEST(HalfFloat, EveryFiniteHalfRoundTrips) {
    for (unsigned half = 0; half < 65536; ++half) {
        if ((half & 0x7C00u) == 0x7C00u) continue;
        const float value = float_from_half(static_cast<std::uint16_t>(half));
        const int exponent = static_cast<int>((half >> 10) & 31u);
        const float significand = static_cast<float>(half & 1023u);
        const float magnitude =
            exponent == 0 ? std::ldexp(significand, -24) : std::ldexp(1024 + significand, exponent - 25);
        ASSERT_EQ(std::abs(value), magnitude);
        ASSERT_EQ(std::signbit(value), half >= 32768);
        ASSERT_EQ(half_from_float(value), half);
    }
}

TEST(HalfFloat, TiesGoToEvenBetweenAllNeighbours) {
    for (unsigned half = 0; half < 0x7BFF; ++half) {
        const float low = float_from_half(static_cast<std::uint16_t>(half));
        const float high = float_from_half(static_cast<std::uint16_t>(half + 1));
        const float middle = 0.5f * (low + high);  // exact: float32 has 13 more bits
        ASSERT_EQ(half_from_float(middle), half + (half & 1));
        ASSERT_EQ(half_from_float(std::nextafter(middle, 0.0f)), half);
        ASSERT_EQ(half_from_float(std::nextafter(middle, 1e9f)), half + 1);
    }
}

}  // namespace
}  // namespace ropsim
