// IEEE binary16 as stored in traces: conversions by integer and IEEE operations only, the same on every
// machine.
#pragma once

#include <bit>
#include <cstdint>

namespace ropsim {

inline constexpr float kLargestHalf = 65504.0f;

// Nearest half, ties to even; finite values beyond +-65504 become +-65504. The argument must not be a NaN.
inline std::uint16_t half_from_float(float value) {
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(value);
    const std::uint32_t sign = (bits >> 16) & 0x8000u;
    const std::uint32_t magnitude = bits & 0x7FFFFFFFu;
    std::uint32_t half = 0;
    if (magnitude >= 0x477FF000u) {  // 65520: would round to infinity
        half = 0x7BFFu;
    } else if (magnitude <
               0x38800000u) {  // below 2^-14: subnormal halves are multiples of 2^-24, as floats at 0.5 are
        const float aligned = std::bit_cast<float>(magnitude) + 0.5f;
        half = std::bit_cast<std::uint32_t>(aligned) - 0x3F000000u;
    } else {
        half = (magnitude + 0xFFFu + ((magnitude >> 13) & 1u) - (112u << 23)) >> 13;
    }
    return static_cast<std::uint16_t>(sign | half);
}

// Exact for every finite half. (Exponent 31 reads as 65536 and more, which is how a reader detects it.)
inline float float_from_half(std::uint16_t half) {
    const std::uint32_t sign = (half & 0x8000u) << 16;
    const float scaled = std::bit_cast<float>((half & 0x7FFFu) << 13) * 0x1p112f;
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(scaled) | sign);
}

}  // namespace ropsim
