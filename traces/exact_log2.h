// The logarithm of a count by IEEE operations only: the same bits on every machine.
#pragma once

#include <bit>
#include <cstdint>

namespace ropsim {

// log2(n) of n >= 1 to 20 bits, by repeated squaring.
inline float exact_log2(std::uint32_t n) {
    const int exponent = 31 - std::countl_zero(n);
    double mantissa = static_cast<double>(n) / static_cast<double>(1u << exponent);  // in [1, 2)
    double result = exponent;
    double bit = 1;
    for (int i = 0; i < 20; ++i) {
        bit *= 0.5;
        mantissa *= mantissa;
        if (mantissa >= 2) {
            mantissa *= 0.5;
            result += bit;
        }
    }
    return static_cast<float>(result);
}

}  // namespace ropsim
