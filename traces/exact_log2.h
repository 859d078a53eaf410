// The logarithm of a count by IEEE operations only: the same bits on every machine.
#pragma once

#include <bit>
#include <cstdint>

namespace ropsim {

// log2(n) of n >= 1 to 20 bits, by repeated squaring.
inline float exact_log2(std::uint32_t n) {
    const int exponent = std::bit_width(n) - 1;
    double mantissa = static_cast<double>(n) / static_cast<double>(1u << exponent);  // in [1, 2)
    double result = exponent;
    for (double bit = 0.5; bit > 0x1p-21; bit *= 0.5) {
        mantissa *= mantissa;
        if (mantissa >= 2) {
            mantissa *= 0.5;
            result += bit;
        }
    }
    return static_cast<float>(result);
}

}  // namespace ropsim
