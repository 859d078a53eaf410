#include "rop/format.h"

namespace ropsim {

namespace {

constexpr FormatInfo kFormats[] = {
    {"float32", 32, "IEEE binary32"},
    {"float16", 16, "IEEE binary16, round to nearest even, overflow to infinity"},
    {"unorm8", 8, "[0,1] in 255 steps, round to nearest"},
    {"unorm16", 16, "[0,1] in 65535 steps, round to nearest"},
    {"unorm24", 24, "[0,1] in 2^24 - 1 steps, round to nearest (D24)"},
    {"snorm8", 8, "[-1,1] in 127 steps each way, round to nearest"},
    {"r11g11b10", 32, "three unsigned floats of 6, 6 and 5 mantissa bits, round to nearest even"},
    {"rgb9e5", 32, "three 9-bit mantissas with a shared exponent, round to nearest"},
    {"uint32", 32, "integer"},
    {"bits", 1, "integer of as many bits as declared"},
};

// Unsigned float with a 5-bit exponent (bias 15) and `mantissa` bits; negative becomes 0, overflow the
// largest finite.
float round_to_small_float(float value, int mantissa) {
    if (!(value > 0.0f)) return 0.0f;
    int exponent = 0;
    std::frexp(value, &exponent);  // value = m * 2^exponent, m in [0.5, 1)
    const int scale = std::max(exponent, -13) - 1 - mantissa;
    const float rounded = std::ldexp(std::nearbyint(std::ldexp(value, -scale)), scale);
    const float largest = std::ldexp(2.0f - std::ldexp(1.0f, -mantissa), 15);
    return std::min(rounded, largest);
}

}  // namespace

std::span<const FormatInfo> format_table() {
    return kFormats;
}

float round_to_snorm8(float value) {
    if (std::isnan(value)) return 0.0f;
    return std::round(std::clamp(value, -1.0f, 1.0f) * 127.0f) / 127.0f;
}

std::array<float, 3> round_to_r11g11b10(std::array<float, 3> rgb) {
    return {round_to_small_float(rgb[0], 6), round_to_small_float(rgb[1], 6),
            round_to_small_float(rgb[2], 5)};
}

std::array<float, 3> round_to_rgb9e5(std::array<float, 3> rgb) {
    constexpr float kLargest = 65408.0f;  // 511/512 * 2^16
    for (float& v : rgb) v = v > 0.0f ? std::min(v, kLargest) : 0.0f;
    const float largest = std::max({rgb[0], rgb[1], rgb[2]});
    if (largest == 0.0f) return rgb;
    int exponent = 0;
    std::frexp(largest, &exponent);
    int shared = std::max(exponent, -15);
    // In double: a float just below a half would be rounded up to the half, and then to the next integer.
    const auto mantissa = [&](float v) {
        return std::floor(std::ldexp(static_cast<double>(v), 9 - shared) + 0.5);
    };
    if (mantissa(largest) >= 512.0) ++shared;
    for (float& v : rgb) v = static_cast<float>(std::ldexp(mantissa(v), shared - 9));
    return rgb;
}

}  // namespace ropsim
