// Stored formats: what a surface keeps of a value. Values convert and round when they are stored, so that
// quantisation error and bandwidth both come out of the same declaration.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <string_view>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace ropsim {

enum class Format : std::uint8_t {
    kFloat32,
    kFloat16,
    kUnorm8,
    kUnorm16,
    kUnorm24,
    kSnorm8,
    kR11G11B10,  // three unsigned small floats in 32 bits; three channels
    kRgb9e5,     // three 9-bit mantissas with a shared 5-bit exponent; three channels
    kUint32,     // integers, kept exactly
    kBits,       // an integer of as many bits as the field says, kept exactly
    kLog8,       // transmittance on a logarithmic scale: code k is 2^(-k/32), code 255 is 0
};

struct FormatInfo {
    std::string_view name;
    int bits;  // of one channel; of all three for the packed formats
    std::string_view summary;
};

// Indexed by Format.
std::span<const FormatInfo> format_table();

inline const FormatInfo& format_info(Format format) {
    return format_table()[static_cast<std::size_t>(format)];
}

// Nearest binary16 as a float, ties to even; overflow to infinity, as a float-to-half converter does.
inline float round_to_float16(float value) {
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(value);
    const std::uint32_t magnitude = bits & 0x7FFFFFFFu;
    if (magnitude >= 0x7F800000u) return value;  // infinity and NaN stay
    if (magnitude >= 0x477FF000u)                // rounds to 65536 or more
        return std::bit_cast<float>((bits & 0x80000000u) | 0x7F800000u);
    if (magnitude < 0x38800000u) {
        // Subnormal in binary16: adding a power of two with the same ulp makes the float adder round.
        const float shifted = std::bit_cast<float>(magnitude) + 0.5f;
        const float rounded = shifted - 0.5f;
        return std::bit_cast<float>(std::bit_cast<std::uint32_t>(rounded) | (bits & 0x80000000u));
    }
    const std::uint32_t rounded = (magnitude + 0x0FFFu + ((magnitude >> 13) & 1u)) & ~0x1FFFu;
    return std::bit_cast<float>(rounded | (bits & 0x80000000u));
}

#if defined(__SSE2__)
// The same of four values.
inline __m128 round_to_float16(__m128 values) {
    const __m128i bits = _mm_castps_si128(values);
    const __m128i sign = _mm_and_si128(bits, _mm_set1_epi32(static_cast<int>(0x80000000u)));
    const __m128i magnitude = _mm_xor_si128(bits, sign);
    const auto chosen = [](__m128i mask, __m128i yes, __m128i no) {
        return _mm_or_si128(_mm_and_si128(mask, yes), _mm_andnot_si128(mask, no));
    };
    const __m128i odd = _mm_and_si128(_mm_srli_epi32(magnitude, 13), _mm_set1_epi32(1));
    __m128i rounded = _mm_andnot_si128(_mm_set1_epi32(0x1FFF),
                                       _mm_add_epi32(_mm_add_epi32(magnitude, _mm_set1_epi32(0x0FFF)), odd));
    const __m128 half = _mm_set1_ps(0.5f);
    const __m128i subnormal =
        _mm_castps_si128(_mm_sub_ps(_mm_add_ps(_mm_castsi128_ps(magnitude), half), half));
    rounded = chosen(_mm_cmpgt_epi32(_mm_set1_epi32(0x38800000), magnitude), subnormal, rounded);
    const __m128i infinity = _mm_set1_epi32(0x7F800000);
    rounded = chosen(_mm_cmpgt_epi32(magnitude, _mm_set1_epi32(0x477FEFFF)), infinity, rounded);
    rounded = chosen(_mm_cmpgt_epi32(magnitude, infinity), magnitude, rounded);  // NaN stays
    return _mm_castsi128_ps(_mm_or_si128(rounded, sign));
}
#endif

// Nearest multiple of 1 / (2^bits - 1) in [0, 1]; NaN becomes 0.
template <int kBitCount>
inline float round_to_unorm(float value) {
    constexpr float kScale = static_cast<float>((1u << kBitCount) - 1u);
    const float clamped = value > 0.0f ? (value < 1.0f ? value : 1.0f) : 0.0f;
    // 24 bits need double: the float product would round before the floor.
    if constexpr (kBitCount > 16) {
        return static_cast<float>(std::floor(static_cast<double>(clamped) * kScale + 0.5) / kScale);
    } else {
        return static_cast<float>(static_cast<std::int32_t>(clamped * kScale + 0.5f)) / kScale;
    }
}

float round_to_snorm8(float value);
// Nearest value of the logarithmic format, of two equally near the larger; NaN becomes 0. Its 32 codes an
// octave make the code a binary number of 3 and 5 bits, which a shifter and a table of 32 entries decode. The
// smallest value above 0, 2^(-254/32) = 1/245, is about UNORM8's, and so is the number of codes; they stand
// closer than UNORM8's below .18 and wider above, up to .0214 apart next to 1.
float round_to_log8(float value);
std::array<float, 3> round_to_r11g11b10(std::array<float, 3> rgb);
std::array<float, 3> round_to_rgb9e5(std::array<float, 3> rgb);

// What a scalar format keeps of `value`. Integer formats are not values of this kind.
inline float stored_value(Format format, float value) {
    switch (format) {
        case Format::kFloat16:
            return round_to_float16(value);
        case Format::kUnorm8:
            return round_to_unorm<8>(value);
        case Format::kUnorm16:
            return round_to_unorm<16>(value);
        case Format::kUnorm24:
            return round_to_unorm<24>(value);
        case Format::kSnorm8:
            return round_to_snorm8(value);
        case Format::kLog8:
            return round_to_log8(value);
        default:
            return value;
    }
}

// The neighbours of a value that the scalar format keeps, 0 <= stored <= 1. There is none below 0, and none
// above 1 in the formats that end there: then the value itself.
float next_stored_below(Format format, float stored);
float next_stored_above(Format format, float stored);

// Other ways of rounding a value in [0, 1] than to nearest: the largest stored value that is not above it
// (bits cut off), and one of its two stored neighbours such that the mean over uniform `draw` in [0, 1) is
// the value. With the same draw, larger values never become smaller than smaller ones.
float stored_value_down(Format format, float value);
float stored_value_dithered(Format format, float value, float draw);

// What three channels of any format but the integer ones keep of a colour.
inline std::array<float, 3> stored_rgb(Format format, std::array<float, 3> rgb) {
    if (format == Format::kR11G11B10) return round_to_r11g11b10(rgb);
    if (format == Format::kRgb9e5) return round_to_rgb9e5(rgb);
    return {stored_value(format, rgb[0]), stored_value(format, rgb[1]), stored_value(format, rgb[2])};
}

}  // namespace ropsim
