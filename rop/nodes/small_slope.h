// A slope of depth in 8 bits: sign, 5 bits of exponent, 2 of mantissa, no subnormals. Jouppi and Chang 1999
// keep "compact floating-point Z gradients"; how the bits are spent is decided here. From 2^-30 of the depth
// range a pixel, below which a plane is flat, to 1.75, to which steeper ones are cut; in between within one
// part in 9.
#pragma once

#include "rop/datapath.h"

#include <cmath>
#include <cstdint>

namespace ropsim {

inline constexpr int kSlopeExponentBias = 31;

inline float slope_of(std::uint32_t code) {
    const auto exponent = static_cast<int>((code >> 2) & 31u);
    if (exponent == 0) return 0.0f;
    const float value =
        std::ldexp(1.0f + static_cast<float>(code & 3u) / 4.0f, exponent - kSlopeExponentBias);
    return (code & 0x80u) != 0 ? -value : value;
}

// The nearest code, away from zero from half way on. Not a number is flat.
inline std::uint32_t slope_code(float slope) {
    const float size = std::fabs(slope);
    if (!(size >= std::ldexp(1.0f, -kSlopeExponentBias))) return 0;
    const std::uint32_t sign = slope < 0.0f ? 0x80u : 0u;
    int exponent = 0;
    const float mantissa = std::frexp(size, &exponent);  // size = mantissa * 2^exponent, mantissa in [1/2, 1)
    int quarters = 0;
    if (std::isfinite(size)) quarters = static_cast<int>(std::floor(mantissa * 8.0f + 0.5f));  // 4 to 8
    exponent += kSlopeExponentBias - 1;
    if (quarters == 8) {
        quarters = 4;
        ++exponent;
    }
    if (!std::isfinite(size) || exponent > 31) return sign | 0x7Fu;
    return sign | (exponent < 1 ? 4u : static_cast<std::uint32_t>(exponent * 4 + quarters - 4));
}

inline Wire<float> slope_of(const Wire<std::uint32_t>& code) {
    return {slope_of(code.value), Ledger::active().charge(Unit::kConverter, code.ready)};
}
inline Wire<std::uint32_t> slope_code(const Wire<float>& slope) {
    return {slope_code(slope.value), Ledger::active().charge(Unit::kConverter, slope.ready)};
}

}  // namespace ropsim
