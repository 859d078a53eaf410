#include "rop/format.h"

#include "base/error.h"
#include "rop/transcendental.h"

#include <functional>

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
    {"log8", 8, "[0,1]: 2^(-k/32) for k = 0..254, and 0; round to nearest value"},
};

// The values of the logarithmic format by code, falling.
const std::array<float, 256>& log8_values() {
    static const std::array<float, 256> values = [] {
        std::array<float, 256> v{};
        for (std::size_t k = 0; k < 255; ++k)
            v[k] = static_cast<float>(deterministic_exp2(-static_cast<double>(k) / 32.0));
        return v;
    }();
    return values;
}
// Code of the largest value that is not above `value`, which is in [0, 1].
std::size_t log8_code_below(float value) {
    const auto& values = log8_values();
    const auto at = std::lower_bound(values.begin(), values.end(), value, std::greater<>());
    return static_cast<std::size_t>(at - values.begin());
}

// Steps of a UNORM or SNORM format from 0 to 1; 0 for others.
float steps_to_one(Format format) {
    switch (format) {
        case Format::kUnorm8:
            return 255.0f;
        case Format::kUnorm16:
            return 65535.0f;
        case Format::kUnorm24:
            return 16777215.0f;
        case Format::kSnorm8:
            return 127.0f;
        default:
            return 0.0f;
    }
}
float neighbour_in_steps(Format format, float stored, double step) {
    const double scale = steps_to_one(format);
    const double code = std::nearbyint(static_cast<double>(stored) * scale) + step;
    return stored_value(format, static_cast<float>(std::clamp(code, 0.0, scale) / scale));
}

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

float round_to_log8(float value) {
    if (!(value > 0.0f)) return 0.0f;
    if (value >= 1.0f) return 1.0f;
    const std::size_t code = log8_code_below(value);
    const float lower = log8_values()[code];
    const float upper = log8_values()[code - 1];
    return value - lower < upper - value ? lower : upper;
}

float next_stored_below(Format format, float stored) {
    if (!(stored > 0.0f)) return 0.0f;
    switch (format) {
        case Format::kFloat32:
            return std::nextafter(stored, 0.0f);
        case Format::kFloat16:
            if (stored <= 0x1p-14f) return stored - 0x1p-24f;  // subnormal
            return std::bit_cast<float>(std::bit_cast<std::uint32_t>(stored) - 0x2000u);
        case Format::kLog8:
            return log8_values()[std::min<std::size_t>(log8_code_below(stored) + 1, 255)];
        default:
            CHECK(steps_to_one(format) > 0, "{} has no neighbours", format_info(format).name);
            return neighbour_in_steps(format, stored, -1.0);
    }
}

float next_stored_above(Format format, float stored) {
    switch (format) {
        case Format::kFloat32:
            return std::nextafter(stored, 2.0f);
        case Format::kFloat16:
            if (stored < 0x1p-14f) return stored + 0x1p-24f;
            return std::bit_cast<float>(std::bit_cast<std::uint32_t>(stored) + 0x2000u);
        case Format::kLog8:
            return log8_values()[std::max<std::size_t>(log8_code_below(stored), 1) - 1];
        default:
            CHECK(steps_to_one(format) > 0, "{} has no neighbours", format_info(format).name);
            return neighbour_in_steps(format, stored, 1.0);
    }
}

float stored_value_down(Format format, float value) {
    const float nearest = stored_value(format, value);
    return nearest <= value ? nearest : next_stored_below(format, nearest);
}

float stored_value_dithered(Format format, float value, float draw) {
    const float lower = stored_value_down(format, value);
    if (lower == value) return value;
    const float upper = next_stored_above(format, lower);
    return draw * (upper - lower) < value - lower ? upper : lower;
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
