// What the formats of phenomenological transparency's targets (McGuire and Mara 2017, Table 2) lose over many
// layers: from which count on, by what closed form, and what a wider format costs.
#include "tests/rop/phenomenological_pixel.h"
#include "tests/rop/worst_case_bytes.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using Pixel = test::TransparentPixel;

// The nearest binary16, ties to even, by quanta in double; infinity from 65520 on.
double half(double value) {
    if (value == 0) return 0;
    const double quantum = std::ldexp(1.0, std::max(std::ilogb(value), -14) - 10);
    const double rounded = std::nearbyint(value / quantum) * quantum;
    return std::abs(rounded) > 65504 ? std::copysign(INFINITY, rounded) : rounded;
}

struct Costs {
    int bits;
    std::uint64_t read, write;
    bool operator==(const Costs&) const = default;
};
Costs costs(const std::string& parameters) {
    const std::string technique = "phenomenological" + parameters;
    const auto bytes = test::worst_case_bytes(technique);
    return {test::storage_bits(technique), bytes.read, bytes.write};
}

// Bits a pixel and bytes a fragment. RT1 is one target: a wider beta widens D^2 too.
TEST(PhenomenologicalPrecision, WhatWiderFormatsCost) {
    EXPECT_EQ(costs(""), (Costs{112, 14, 14}));
    EXPECT_EQ(costs(":beta_format=unorm16"), (Costs{144, 18, 18}));
    EXPECT_EQ(costs(":beta_format=float16"), (Costs{144, 18, 18}));
    EXPECT_EQ(costs(":beta_format=float32"), (Costs{208, 26, 26}));
    EXPECT_EQ(costs(":delta_format=float16"), (Costs{128, 16, 16}));
    EXPECT_EQ(costs(":accumulated_format=float32"), (Costs{176, 22, 22}));
    EXPECT_EQ(costs(":format=float32"), (Costs{320, 40, 40}));
    EXPECT_EQ(costs(":form=alpha,beta_format=unorm16"), (Costs{96, 12, 12}));
}

// beta - a beta rounds back to beta where a beta is half a code or less: at floor(.5 / a) codes, if it ever
// moves. Of n bits a code is 1 / (2^n - 1). Alpha up to 1/510 never moves eight bits.
TEST(PhenomenologicalPrecision, BetaStallsWhereALayerTakesHalfACode) {
    for (const float a : {0.3f, 0.11f, 0.03f, 0.01f, 0.005f, 0.0023f, 0.00197f, 0.00196f, 0.0011f}) {
        Pixel narrow("");
        Pixel wide(",beta_format=unorm16");
        for (int n = 0; n < 3000; ++n) narrow.draw(0.5f, a);
        for (int n = 0; n < 12000; ++n) wide.draw(0.5f, a);
        const double stalled = std::floor(0.5 / a);
        EXPECT_NEAR(narrow.stored(test::kBetaWord) * 255, std::min(stalled, 255.0), 1e-4) << a;
        EXPECT_NEAR(wide.stored(test::kBetaWord) * 65535, stalled, 1e-2) << a;
    }
}

// Half an ulp of binary16 is 2^-12 from .5 to 1: alpha of that and less never moves it, and up to twice as
// much it stalls at 2^-12 / alpha. Above, each binade's ulp shrinks in time, and it goes on.
TEST(PhenomenologicalPrecision, BetaInBinary16Starts) {
    const auto after = [](float a) {
        Pixel pixel(",beta_format=float16");
        for (int n = 0; n < 3000; ++n) pixel.draw(0.5f, a);
        return pixel.stored(test::kBetaWord);
    };
    EXPECT_EQ(after(0.000244f), 1);
    EXPECT_NEAR(after(0.0003f), std::ldexp(1, -12) / 0.0003, std::ldexp(1, -11));
    EXPECT_LT(after(0.0005f), 0.25);
    EXPECT_LT(after(0.01f), 1e-5);
}

// 151 layers of alpha .01 leave 50/255 for good and should leave .219; of .005 it is 155 and .460.
TEST(PhenomenologicalPrecision, LayersUntilBetaStalls) {
    const auto layers = [](float a) {
        Pixel pixel("");
        const double stalled = std::floor(0.5 / a);
        return pixel.draw_until(0.5f, a, 1, 1000,
                                [&] { return pixel.stored(test::kBetaWord) * 255 < stalled + 0.5; });
    };
    const auto counted = [](double a) {
        int n = 0;
        for (double code = 255; code * a > 0.5; ++n) code = std::floor(code - code * a + 0.5);
        return n;
    };
    EXPECT_EQ(counted(0.01f), 151);
    EXPECT_EQ(counted(0.005f), 155);
    EXPECT_EQ(layers(0.01f), 151);
    EXPECT_EQ(layers(0.005f), 155);
    EXPECT_NEAR(std::pow(0.99, 151), 0.219, 5e-4);
    EXPECT_NEAR(std::pow(0.995, 155), 0.460, 5e-4);
}

// A clear pane's reflection comes back as (1 - beta) A / A_a: what the pane absorbs, divided by the same in
// more bits. Eight of beta leave whole codes of it: the highlight is wrong by up to half a code over the
// absorption, and gone where that is below 1/510.
TEST(PhenomenologicalPrecision, ReflectionsOffClearGlassAreQuantised) {
    const auto highlight = [](const std::string& format, float absorbed) {
        Pixel pixel = Pixel::of_materials(",self_modulation=off,beta_format=" + format);
        Material clear;
        std::ranges::fill(clear.transmission, 1 - absorbed);
        pixel.draw(0.5f, 1, {1, 1, 1}, clear);
        return pixel.color();
    };
    for (const float absorbed : {0.04f, 0.02f, 0.0099f, 0.0057f, 0.0041f, 0.0021f, 0.0019f}) {
        const double codes = std::floor(255 * absorbed + 0.5);
        EXPECT_NEAR(highlight("unorm8", absorbed), codes / 255 / absorbed, 4e-3) << absorbed;
        EXPECT_NEAR(highlight("unorm16", absorbed), 1, 0.5 / 65535 / absorbed + 2e-3) << absorbed;
    }
    EXPECT_EQ(highlight("unorm8", 0.0019f), 0);
    EXPECT_NEAR(highlight("unorm8", 0.0057f), 0.69, 0.01);
    EXPECT_NEAR(highlight("unorm8", 0.0021f), 1.87, 0.01);
}

int counted_to_overflow(double addend) {
    int n = 0;
    for (double sum = 0; std::isfinite(sum) && n < 1 << 20; ++n) sum = half(sum + addend);
    return n;
}

// Opaque surfaces at the near plane, where equation 5 is at its cap of 30: 2057 of white, 222 ten times as
// bright, 22 a hundred times. (65520 / 30 = 2184: from 4096 on the sum grows by 32 a layer.) Equation 10 of
// weighted blended OIT, whose most is 3000: 22 of white, 3 ten times as bright.
TEST(PhenomenologicalPrecision, BrightSurfacesNearTheEyeOverflow) {
    struct Case {
        const char* parameters;
        float a, color;
        double addend;
        int layers;
    };
    for (const Case& c : std::initializer_list<Case>{{"", 1, 1, 30, 2057},
                                                     {"", 1, 10, 300, 222},
                                                     {"", 0.5f, 10, 150, 427},
                                                     {"", 1, 100, 3000, 22},
                                                     {",weight=eq10", 1, 1, 3000, 22},
                                                     {",weight=eq10", 0.5f, 10, 7500, 9},
                                                     {",weight=eq10", 1, 10, 30000, 3}}) {
        EXPECT_EQ(counted_to_overflow(c.addend), c.layers) << c.addend;
        const std::string parameters = std::string(",beta_format=float32") + c.parameters;
        Pixel pixel(parameters);
        EXPECT_EQ(pixel.draw_until(0, c.a, c.color, 5000, [&] { return std::isinf(pixel.stored(0)); }),
                  c.layers)
            << c.addend;
        const double covered = 1 - std::pow(1.0 - static_cast<double>(c.a), c.layers);
        EXPECT_NEAR(pixel.color(), covered, 1e-6) << "white";
        Pixel stops(parameters + ",overflow=saturate");
        for (int n = 0; n < c.layers; ++n) stops.draw(0, c.a, {c.color, c.color, c.color});
        EXPECT_EQ(stops.stored(0), 65504);
        Pixel wide(parameters + ",accumulated_format=float32");
        for (int n = 0; n < c.layers; ++n) wide.draw(0, c.a, {c.color, c.color, c.color});
        EXPECT_NEAR(wide.color(), c.color * covered, 1e-4 * c.color);
    }
}

// Where a sum of like addends s stops: at the first power of two half of whose ulp is not less than s.
double stalled_at(double s) {
    return std::ldexp(1.0, static_cast<int>(std::ceil(std::log2(2048 * s))));
}

// So such a sum overflows only of addends above 16, whatever their number: with equation 5, of light below
// white, only where surfaces near the eye cover more than 16/30. The weight of G3D, 1 at most, never does
// below 16 times white.
TEST(PhenomenologicalPrecision, WhatStallsCannotOverflow) {
    const auto after = [](const std::string& parameters, float a, float color) {
        Pixel pixel(parameters);
        for (int n = 0; n < 6000; ++n) pixel.draw(0, a, {color, color, color});
        return pixel.stored(0);
    };
    EXPECT_EQ(after("", 0.53f, 1), stalled_at(30 * 0.53));
    EXPECT_EQ(after("", 0.53f, 1), 32768);
    EXPECT_TRUE(std::isinf(after("", 0.54f, 1)));
    EXPECT_EQ(after(",weight=g3d", 1, 1), 2048);
    EXPECT_EQ(after(",weight=g3d", 1, 16), 32768);
    EXPECT_TRUE(std::isinf(after(",weight=g3d", 1, 16.5f)));
}

// Thin layers are all weighted .01. 4096 of alpha .01 sum to .41 and stop at .25 after 2181, 39% lost; colour
// and coverage each stop at a power of two, so that their quotient, the colour shown, is one.
TEST(PhenomenologicalPrecision, StalledColoursArePowersOfTwo) {
    for (const float color : {1.0f, 0.5f, 0.3f, 0.4f, 0.7f, 0.26f, 0.24f}) {
        Pixel pixel(",beta_format=float32");
        Pixel wide(",beta_format=float32,accumulated_format=float32");
        int last_change = 0;
        for (int n = 1; n <= 4096; ++n) {
            const double before = pixel.stored(test::kNetWord);
            pixel.draw(0.5f, 0.01f, {color, color, color});
            wide.draw(0.5f, 0.01f, {color, color, color});
            if (pixel.stored(test::kNetWord) != before) last_change = n;
        }
        EXPECT_EQ(last_change, 2181);
        EXPECT_EQ(pixel.stored(test::kNetWord), stalled_at(1e-4));
        EXPECT_EQ(pixel.stored(0), stalled_at(1e-4 * color));
        EXPECT_EQ(pixel.color(), stalled_at(1e-4 * color) / stalled_at(1e-4)) << color;
        EXPECT_NEAR(wide.stored(test::kNetWord), 0.4096, 2e-5);
        EXPECT_NEAR(wide.color(), color, 1e-4);
    }
    EXPECT_EQ(stalled_at(1e-4), 0.25);
    EXPECT_NEAR(1 - 0.25 / 0.4096, 0.39, 5e-3);
}

// Resolve divides by 1e-5 at least, and thin layers weigh .01: below a net coverage of .001 in all, colour
// darkens in proportion, and 2^-25 / .01 is the least that binary16 holds at all. Eight bits of beta hide
// what is below 1/510 anyway, so this is seen with a wider beta alone.
TEST(PhenomenologicalPrecision, ColourNeedsANetCoverageOfAThousandth) {
    const auto share = [](float a, int layers) {
        Pixel pixel(",beta_format=float32");
        for (int n = 0; n < layers; ++n) pixel.draw(0.5f, a);
        return pixel.color() / (1 - std::pow(1 - static_cast<double>(a), layers));
    };
    for (const float a : {0.1f, 0.01f, 0.0011f, 0.001f, 0.0009f, 0.0005f, 0.0001f, 0.00001f}) {
        const double stored = half(0.01 * a);
        EXPECT_NEAR(share(a, 1), std::min(1.0, stored / 1e-5), 0.005) << a;
    }
    EXPECT_NEAR(share(0.0005f, 1), 0.5, 0.005);
    EXPECT_NEAR(share(0.0005f, 2), 1, 0.005);
    EXPECT_EQ(share(2.9e-6f, 1), 0);
    EXPECT_GT(share(3.1e-6f, 1), 0);
    Pixel narrow("");
    narrow.draw(0.5f, 0.0019f);
    EXPECT_EQ(narrow.color(), 0);
}

}  // namespace
}  // namespace ropsim
