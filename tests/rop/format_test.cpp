// Stored formats against independent definitions, exhaustively where the format allows.
#include "rop/format.h"

#include "tests/rop/random_fragments.h"

#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

// Value of a small float's code: `mantissa` bits, a 5-bit exponent of bias 15.
double small_float_value(int code, int mantissa) {
    const int exponent = (code >> mantissa) & 31;
    const double fraction = std::ldexp(code & ((1 << mantissa) - 1), -mantissa);
    if (exponent == 31)
        return fraction == 0 ? std::numeric_limits<double>::infinity()
                             : std::numeric_limits<double>::quiet_NaN();
    return exponent == 0 ? std::ldexp(fraction, -14) : std::ldexp(1 + fraction, exponent - 15);
}

double half_value(int code) {
    return ((code & 0x8000) != 0 ? -1 : 1) * small_float_value(code & 0x7FFF, 10);
}

TEST(Float16, All65536CodesAreFixedPoints) {
    for (int code = 0; code < 65536; ++code) {
        const auto value = static_cast<float>(half_value(code));
        const float kept = round_to_float16(value);
        ASSERT_EQ(std::isnan(kept), std::isnan(value)) << code;
        if (std::isnan(value)) continue;
        ASSERT_EQ(std::bit_cast<std::uint32_t>(kept), std::bit_cast<std::uint32_t>(value)) << code;
    }
}

// Between neighbours a < b, of codes n and n + 1: up to the middle a, from the middle b, the middle to the
// even code.
TEST(Float16, RoundsToNearestTiesToEven) {
    for (int code = 0; code < 0x7BFF; ++code) {
        const double a = half_value(code);
        const double b = half_value(code + 1);
        const auto middle = static_cast<float>((a + b) / 2);  // exact: one bit more than a half has
        const float even = static_cast<float>(code % 2 == 0 ? a : b);
        for (const float sign : {1.0f, -1.0f}) {
            ASSERT_EQ(round_to_float16(sign * middle), sign * even) << code;
            ASSERT_EQ(round_to_float16(sign * std::nextafter(middle, 0.0f)), sign * static_cast<float>(a))
                << code;
            ASSERT_EQ(round_to_float16(sign * std::nextafter(middle, 1e9f)), sign * static_cast<float>(b))
                << code;
        }
    }
}

TEST(Float16, OverflowsToInfinityFromTheMiddleOn) {
    EXPECT_EQ(round_to_float16(65504.0f), 65504.0f);
    EXPECT_EQ(round_to_float16(std::nextafter(65520.0f, 0.0f)), 65504.0f);
    EXPECT_EQ(round_to_float16(65520.0f), std::numeric_limits<float>::infinity());
    EXPECT_EQ(round_to_float16(-1e30f), -std::numeric_limits<float>::infinity());
    EXPECT_EQ(std::bit_cast<std::uint32_t>(round_to_float16(-0.0f)), 0x80000000u);
    EXPECT_EQ(std::bit_cast<std::uint32_t>(round_to_float16(-1e-30f)), 0x80000000u);
}

// Codes are kept, values in between go to the nearest code. The product value * scale is rounded to a float
// before the half is added, as converters do: two roundings of half an ulp of the scale, so that much around
// a middle may go either way.
template <int kBits>
void check_unorm(double step_tolerance) {
    constexpr std::uint32_t kMax = (1u << kBits) - 1;
    const auto keep = [](float v) { return round_to_unorm<kBits>(v); };
    for (std::uint32_t code = 0; code <= kMax; ++code) {
        const auto value = static_cast<float>(code / static_cast<double>(kMax));
        ASSERT_EQ(keep(value), value) << code;
        if (code == kMax) break;
        const double middle = (code + 0.5) / kMax;
        const auto below = static_cast<float>(middle - step_tolerance / kMax);
        const auto above = static_cast<float>(middle + step_tolerance / kMax);
        ASSERT_EQ(keep(below), value) << code;
        ASSERT_EQ(keep(above), static_cast<float>((code + 1) / static_cast<double>(kMax))) << code;
    }
    EXPECT_EQ(keep(-0.5f), 0.0f);
    EXPECT_EQ(keep(1.5f), 1.0f);
    EXPECT_EQ(keep(std::numeric_limits<float>::infinity()), 1.0f);
    EXPECT_EQ(keep(std::numeric_limits<float>::quiet_NaN()), 0.0f);
}

TEST(Unorm, AllCodesOf8BitsAreKeptAndNeighboursRoundToThem) {
    check_unorm<8>(2 * 256 * 0x1p-24);
}
TEST(Unorm, AllCodesOf16BitsAreKeptAndNeighboursRoundToThem) {
    check_unorm<16>(2 * 65536 * 0x1p-24);
}
// A float in [0.5, 1) is already half a step from its neighbours at 24 bits: only the codes themselves are
// asked.
TEST(Unorm, AllCodesOf24BitsAreKept) {
    for (std::uint32_t code = 0; code <= 0xFFFFFFu; ++code) {
        const auto value = static_cast<float>(code / 16777215.0);
        ASSERT_EQ(round_to_unorm<24>(value), value) << code;
    }
    // Small depths have room between codes.
    for (std::uint32_t code = 0; code < 100000; ++code) {
        ASSERT_EQ(round_to_unorm<24>(static_cast<float>((code + 0.45) / 16777215.0)),
                  static_cast<float>(code / 16777215.0));
        ASSERT_EQ(round_to_unorm<24>(static_cast<float>((code + 0.55) / 16777215.0)),
                  static_cast<float>((code + 1) / 16777215.0));
    }
    EXPECT_EQ(round_to_unorm<24>(1e30f), 1.0f);
}

TEST(Snorm8, CodesAreKeptAndNeighboursRoundToThem) {
    for (int code = -127; code <= 127; ++code) {
        const auto value = static_cast<float>(code / 127.0);
        ASSERT_EQ(round_to_snorm8(value), value) << code;
        ASSERT_EQ(round_to_snorm8(static_cast<float>((code + 0.4999) / 127.0)), value) << code;
        ASSERT_EQ(round_to_snorm8(static_cast<float>((code - 0.4999) / 127.0)), value) << code;
    }
    EXPECT_EQ(round_to_snorm8(-3.0f), -1.0f);
    EXPECT_EQ(round_to_snorm8(3.0f), 1.0f);
    EXPECT_EQ(round_to_snorm8(std::numeric_limits<float>::quiet_NaN()), 0.0f);
}

TEST(R11G11B10, CodesAreKeptMiddlesGoToTheEvenCode) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
        const int mantissa = channel == 2 ? 5 : 6;
        const int codes = 31 << mantissa;  // finite ones
        const auto keep = [&](double v) {
            std::array<float, 3> rgb{};
            rgb[channel] = static_cast<float>(v);
            return static_cast<double>(round_to_r11g11b10(rgb)[channel]);
        };
        for (int code = 0; code < codes; ++code) {
            const double a = small_float_value(code, mantissa);
            ASSERT_EQ(keep(a), a) << code;
            if (code + 1 == codes) break;
            const double b = small_float_value(code + 1, mantissa);
            ASSERT_EQ(keep((a + b) / 2), code % 2 == 0 ? a : b) << code;
            ASSERT_EQ(keep(a + (b - a) * 0.499), a) << code;
            ASSERT_EQ(keep(a + (b - a) * 0.501), b) << code;
        }
        EXPECT_EQ(keep(-1), 0.0);
        EXPECT_EQ(keep(1e9), small_float_value(codes - 1, mantissa)) << "the largest finite value";
        EXPECT_EQ(keep(std::numeric_limits<double>::infinity()), small_float_value(codes - 1, mantissa));
        EXPECT_EQ(keep(std::numeric_limits<double>::quiet_NaN()), 0.0);
    }
}

// By its definition (OpenGL 4.6, section 8.5.2): exponent of the largest channel, one more if that rounds to
// 512.
std::array<double, 3> rgb9e5_by_definition(const std::array<float, 3>& rgb) {
    std::array<double, 3> clamped{};
    for (std::size_t c = 0; c < 3; ++c)
        clamped[c] = std::clamp(static_cast<double>(rgb[c]), 0.0, 511.0 / 512.0 * 65536.0);
    const double largest = std::max({clamped[0], clamped[1], clamped[2]});
    int exponent = 0;
    if (largest > 0) exponent = std::max(-16, static_cast<int>(std::floor(std::log2(largest)))) + 1 + 15;
    const auto scale = [&] { return std::pow(2.0, exponent - 15 - 9); };
    if (std::floor(largest / scale() + 0.5) == 512) ++exponent;
    for (double& v : clamped) v = std::floor(v / scale() + 0.5) * scale();
    return clamped;
}

TEST(Rgb9e5, EqualsItsDefinition) {
    test::Random random(1);
    const auto check = [](const std::array<float, 3>& rgb) {
        const auto kept = round_to_rgb9e5(rgb);
        const auto expected = rgb9e5_by_definition(rgb);
        for (std::size_t c = 0; c < 3; ++c)
            ASSERT_EQ(static_cast<double>(kept[c]), expected[c]) << rgb[0] << " " << rgb[1] << " " << rgb[2];
        ASSERT_EQ(round_to_rgb9e5(kept), kept);
    };
    for (int i = 0; i < 200000; ++i) {
        const double scale = std::exp2(random.integer(-30, 17));
        check({random.real(-0.1, 1) * static_cast<float>(scale),
               random.real(0, 1) * static_cast<float>(scale), random.real(0, 1) * static_cast<float>(scale)});
    }
    // A channel a hair below the middle of two mantissas stays below.
    check({1.0f, std::nextafter(0.5f / 256, 0.0f), 0.5f / 256});
    check({std::nextafter(511.5f / 512, 0.0f), 0.1f, 0.2f});
    check({511.5f / 512, 0.1f, 0.2f});
    check({0, 0, 0});
    check({1e9f, 65408.0f, 1.0f});
}

TEST(StoredValue, NamesEveryFormat) {
    EXPECT_EQ(stored_value(Format::kFloat32, 0.1f), 0.1f);
    EXPECT_EQ(stored_value(Format::kFloat16, 0.1f), round_to_float16(0.1f));
    EXPECT_EQ(stored_value(Format::kUnorm8, 0.1f), 26.0f / 255.0f);
    EXPECT_EQ(stored_value(Format::kUnorm16, 0.1f), 6554.0f / 65535.0f);
    EXPECT_EQ(stored_value(Format::kUnorm24, 0.1f), static_cast<float>(1677722 / 16777215.0));
    EXPECT_EQ(stored_value(Format::kSnorm8, -0.1f), -13.0f / 127.0f);
    const std::array<float, 3> rgb = {0.1f, 0.7f, 3.3f};
    EXPECT_EQ(stored_rgb(Format::kRgb9e5, rgb), round_to_rgb9e5(rgb));
    EXPECT_EQ(stored_rgb(Format::kR11G11B10, rgb), round_to_r11g11b10(rgb));
    EXPECT_EQ(stored_rgb(Format::kUnorm8, rgb), (std::array<float, 3>{26.0f / 255, 179.0f / 255, 1}));
    EXPECT_EQ(format_info(Format::kRgb9e5).bits, 32);
    EXPECT_EQ(format_info(Format::kFloat16).name, "float16");
}

#if defined(__SSE2__)
// Four at a time rounds as one by one does: over all exponents, both signs, NaN and infinity, and every tie.
TEST(Float16, FourAtATimeIsOneByOne) {
    const auto expect_equal = [](const std::array<float, 4>& values) {
        std::array<float, 4> rounded{};
        _mm_storeu_ps(rounded.data(), round_to_float16(_mm_loadu_ps(values.data())));
        for (std::size_t i = 0; i < 4; ++i)
            ASSERT_EQ(std::bit_cast<std::uint32_t>(rounded[i]),
                      std::bit_cast<std::uint32_t>(round_to_float16(values[i])))
                << values[i];
    };
    for (std::uint64_t bits = 0; bits < (1ull << 32); bits += 4093 * 4) {
        std::array<float, 4> values{};
        for (std::uint64_t i = 0; i < 4; ++i)
            values[i] = std::bit_cast<float>(static_cast<std::uint32_t>(bits + 4093 * i));
        ASSERT_NO_FATAL_FAILURE(expect_equal(values));
    }
    for (std::uint32_t half = 0; half < 0x80000; ++half) {  // halfway and its neighbours, each sign
        const std::uint32_t tie = (half << 13) | 0x1000u;
        ASSERT_NO_FATAL_FAILURE(
            expect_equal({std::bit_cast<float>(tie), std::bit_cast<float>(tie - 1),
                          std::bit_cast<float>(tie + 1), std::bit_cast<float>(half << 13)}));
    }
}
#endif

}  // namespace
}  // namespace ropsim
