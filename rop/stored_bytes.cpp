#include "rop/stored_bytes.h"

#include "base/error.h"
#include "rop/format.h"
#include "rop/transcendental.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace ropsim {

namespace {

// Appends bits, the lowest first.
class BitWriter {
 public:
    explicit BitWriter(std::uint8_t* out) : out_(out) {}
    void put(std::uint32_t value, int bits) {
        pending_ |= static_cast<std::uint64_t>(value) << count_;
        count_ += bits;
        for (; count_ >= 8; count_ -= 8, pending_ >>= 8) *out_++ = static_cast<std::uint8_t>(pending_);
    }
    void finish() {
        if (count_ > 0) *out_++ = static_cast<std::uint8_t>(pending_);
    }

 private:
    std::uint8_t* out_;
    std::uint64_t pending_ = 0;
    int count_ = 0;
};

class BitReader {
 public:
    explicit BitReader(const std::uint8_t* in) : in_(in) {}
    std::uint32_t get(int bits) {
        for (; count_ < bits; count_ += 8) pending_ |= static_cast<std::uint64_t>(*in_++) << count_;
        const auto value = static_cast<std::uint32_t>(pending_ & ((std::uint64_t{1} << bits) - 1));
        pending_ >>= bits;
        count_ -= bits;
        return value;
    }

 private:
    const std::uint8_t* in_;
    std::uint64_t pending_ = 0;
    int count_ = 0;
};

// Bit pattern of a float with a 5-bit exponent, bias 15, that holds `value` exactly (binary16 without its
// sign is one of 10 mantissa bits).
std::uint32_t small_float_code(float value, int mantissa) {
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(value) & 0x7FFFFFFFu;
    const auto cut = static_cast<std::uint32_t>(23 - mantissa);
    if (bits >= 0x7F800000u) {  // infinity; NaN keeps the top of its payload and never becomes infinity
        const std::uint32_t payload = (bits & 0x7FFFFFu) >> cut;
        const std::uint32_t nan = bits > 0x7F800000u ? std::max(payload, 1u) : 0u;
        return (31u << mantissa) | nan;
    }
    if (bits < 0x38800000u)  // below 2^-14: subnormal
        return static_cast<std::uint32_t>(std::ldexp(std::bit_cast<float>(bits), 14 + mantissa));
    return (bits >> cut) - (112u << mantissa);
}
float small_float_value(std::uint32_t code, int mantissa) {
    const std::uint32_t exponent = code >> mantissa;
    const std::uint32_t fraction = code & ((1u << mantissa) - 1);
    if (exponent == 0) return std::ldexp(static_cast<float>(fraction), -14 - mantissa);
    if (exponent == 31)
        return std::bit_cast<float>(0x7F800000u | fraction << static_cast<std::uint32_t>(23 - mantissa));
    return std::bit_cast<float>(((exponent + 112u) << 23) | fraction
                                                                << static_cast<std::uint32_t>(23 - mantissa));
}

double steps_of(Format format) {
    switch (format) {
        case Format::kUnorm8:
            return 255.0;
        case Format::kUnorm16:
            return 65535.0;
        case Format::kUnorm24:
            return 16777215.0;
        default:
            return 127.0;
    }
}

std::uint32_t code_of(Format format, std::uint32_t word) {
    const float value = std::bit_cast<float>(word);
    switch (format) {
        case Format::kFloat16:
            return small_float_code(value, 10) | (word >> 31) << 15;
        case Format::kUnorm8:
        case Format::kUnorm16:
        case Format::kUnorm24:
            return static_cast<std::uint32_t>(std::lround(static_cast<double>(value) * steps_of(format)));
        case Format::kSnorm8:
            return static_cast<std::uint32_t>(std::lround(static_cast<double>(value) * 127.0)) & 0xFFu;
        case Format::kLog8:
            return value > 0 ? static_cast<std::uint32_t>(
                                   std::lround(-32.0 * deterministic_log2(static_cast<double>(value))))
                             : 255u;
        default:
            return word;
    }
}

std::uint32_t word_of(Format format, std::uint32_t code) {
    const auto word = [](float value) { return std::bit_cast<std::uint32_t>(value); };
    switch (format) {
        case Format::kFloat16:
            return word(small_float_value(code & 0x7FFFu, 10)) | (code >> 15) << 31;
        // By the divisions that rounding makes, so that the value is the same one.
        case Format::kUnorm8:
            return word(static_cast<float>(code) / 255.0f);
        case Format::kUnorm16:
            return word(static_cast<float>(code) / 65535.0f);
        case Format::kUnorm24:
            return word(static_cast<float>(code / steps_of(format)));
        case Format::kSnorm8:
            return word(static_cast<float>(static_cast<std::int8_t>(code)) / 127.0f);
        case Format::kLog8:
            return word(code == 255 ? 0.0f
                                    : round_to_log8(static_cast<float>(
                                          deterministic_exp2(-static_cast<double>(code) / 32.0))));
        default:
            return code;
    }
}

// The exponent is the least that holds the largest mantissa in 9 bits.
void put_rgb9e5(const std::array<float, 3>& rgb, BitWriter& out) {
    const float largest = std::max({rgb[0], rgb[1], rgb[2]});
    int exponent = 0;
    std::frexp(largest, &exponent);  // largest < 2^exponent
    exponent = std::clamp(exponent, -15, 16);
    const auto mantissa = [&](float v) { return static_cast<std::uint32_t>(std::ldexp(v, 9 - exponent)); };
    for (const float v : rgb) out.put(mantissa(v), 9);
    out.put(static_cast<std::uint32_t>(exponent + 15), 5);
}

void put_packed(Format format, const std::uint32_t* words, BitWriter& out) {
    const std::array<float, 3> rgb = {std::bit_cast<float>(words[0]), std::bit_cast<float>(words[1]),
                                      std::bit_cast<float>(words[2])};
    if (format == Format::kRgb9e5) return put_rgb9e5(rgb, out);
    out.put(small_float_code(rgb[0], 6), 11);
    out.put(small_float_code(rgb[1], 6), 11);
    out.put(small_float_code(rgb[2], 5), 10);
}

void get_packed(Format format, BitReader& in, std::uint32_t* words) {
    std::array<float, 3> rgb{};
    if (format == Format::kRgb9e5) {
        std::array<std::uint32_t, 3> mantissa{};
        for (std::uint32_t& m : mantissa) m = in.get(9);
        const int exponent = static_cast<int>(in.get(5)) - 15;
        for (std::size_t c = 0; c < 3; ++c)
            rgb[c] = std::ldexp(static_cast<float>(mantissa[c]), exponent - 9);
    } else {
        rgb = {small_float_value(in.get(11), 6), 0, 0};
        rgb[1] = small_float_value(in.get(11), 6);
        rgb[2] = small_float_value(in.get(10), 5);
    }
    for (std::size_t c = 0; c < 3; ++c) words[c] = std::bit_cast<std::uint32_t>(rgb[c]);
}

bool packed(Format format) {
    return format == Format::kR11G11B10 || format == Format::kRgb9e5;
}

}  // namespace

void store_elements(const Surface& surface, const std::uint32_t* words, std::uint64_t mask,
                    std::uint8_t* out) {
    for (; mask != 0; mask &= mask - 1, out += surface.element_bytes()) {
        const int element = std::countr_zero(mask);
        BitWriter bits(out);
        for (const StoredField& field : surface.fields) {
            const std::uint32_t* from = words + (field.first_word + field.channels * element);
            if (packed(field.format)) {
                put_packed(field.format, from, bits);
                continue;
            }
            for (int c = 0; c < field.channels; ++c) {
                const int width = field.format == Format::kBits ? std::min(32, field.bits - 32 * c)
                                                                : field.bits / field.channels;
                bits.put(code_of(field.format, from[c]), width);
            }
        }
        bits.finish();
    }
}

void load_element(const Surface& surface, int element, const std::uint8_t* bytes, std::uint32_t* words) {
    BitReader bits(bytes);
    for (const StoredField& field : surface.fields) {
        std::uint32_t* to = words + (field.first_word + field.channels * element);
        if (packed(field.format)) {
            get_packed(field.format, bits, to);
            continue;
        }
        for (int c = 0; c < field.channels; ++c) {
            const int width = field.format == Format::kBits ? std::min(32, field.bits - 32 * c)
                                                            : field.bits / field.channels;
            to[c] = word_of(field.format, bits.get(width));
        }
    }
}

void store_color(Format format, const float* rgb, std::uint32_t bytes, std::uint8_t* out) {
    BitWriter bits(out);
    if (packed(format)) {
        const std::array<std::uint32_t, 3> words = {std::bit_cast<std::uint32_t>(rgb[0]),
                                                    std::bit_cast<std::uint32_t>(rgb[1]),
                                                    std::bit_cast<std::uint32_t>(rgb[2])};
        put_packed(format, words.data(), bits);
        return;
    }
    const int width = format_info(format).bits;
    CHECK(bytes * 8 == static_cast<std::uint32_t>(4 * width), "{} bytes of {}", bytes,
          format_info(format).name);
    for (int c = 0; c < 4; ++c)
        bits.put(code_of(format, std::bit_cast<std::uint32_t>(c < 3 ? rgb[c] : 1.0f)), width);
}

}  // namespace ropsim
