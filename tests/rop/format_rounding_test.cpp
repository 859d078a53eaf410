// The logarithmic format, and the ways of rounding that are not to nearest.
#include "rop/format.h"
#include "tests/rop/random_fragments.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;

constexpr Format kScalar[] = {Format::kFloat16, Format::kUnorm8, Format::kUnorm16,
                              Format::kUnorm24, Format::kSnorm8, Format::kLog8};

double log8_value(int code) {
    return code == 255 ? 0.0 : std::exp2(-code / 32.0);
}

TEST(Log8, CodesAreKeptAndValuesBetweenGoToTheNearest) {
    for (int code = 0; code < 256; ++code) {
        const auto value = static_cast<float>(log8_value(code));
        ASSERT_NEAR(round_to_log8(value), log8_value(code), 1e-7) << code;
        ASSERT_EQ(round_to_log8(round_to_log8(value)), round_to_log8(value)) << code;
        if (code == 255) break;
        const double next = log8_value(code + 1);
        const double middle = (log8_value(code) + next) / 2;
        ASSERT_NEAR(round_to_log8(static_cast<float>(middle * 1.0001)), log8_value(code), 1e-7) << code;
        ASSERT_NEAR(round_to_log8(static_cast<float>(middle * 0.9999)), next, 1e-7) << code;
    }
}

TEST(Log8, EndsOfItsRange) {
    EXPECT_EQ(round_to_log8(1.0f), 1.0f);
    EXPECT_EQ(round_to_log8(7.0f), 1.0f);
    EXPECT_EQ(round_to_log8(std::numeric_limits<float>::infinity()), 1.0f);
    EXPECT_EQ(round_to_log8(0.0f), 0.0f);
    EXPECT_EQ(round_to_log8(-0.5f), 0.0f);
    EXPECT_EQ(round_to_log8(std::numeric_limits<float>::quiet_NaN()), 0.0f);
    EXPECT_EQ(round_to_log8(0.002f), 0.0f) << "below half of the smallest value";
    EXPECT_NEAR(round_to_log8(0.0021f), std::exp2(-254 / 32.0), 1e-7);
    EXPECT_EQ(format_info(Format::kLog8).name, "log8");
    EXPECT_EQ(format_info(Format::kLog8).bits, 8);
    EXPECT_EQ(stored_value(Format::kLog8, 0.5f), 0.5f) << "code 32";
}

// Up and down the neighbours from 0 to 1: all different, each the other's, as many as the format has.
TEST(Rounding, NeighboursAreNextToEachOther) {
    const auto count = [](Format format) {
        std::uint64_t values = 1;
        for (float v = 0; v < 1.0f; ++values) {
            const float above = next_stored_above(format, v);
            EXPECT_GT(above, v);
            EXPECT_EQ(stored_value(format, above), above);
            EXPECT_EQ(next_stored_below(format, above), v);
            EXPECT_EQ(stored_value(format, v + (above - v) * 0.4f), v);
            if (!(above > v)) break;
            v = above;
        }
        return values;
    };
    EXPECT_EQ(count(Format::kUnorm8), 256u);
    EXPECT_EQ(count(Format::kUnorm16), 65536u);
    EXPECT_EQ(count(Format::kSnorm8), 128u);
    EXPECT_EQ(count(Format::kLog8), 256u);
    EXPECT_EQ(count(Format::kFloat16), 0x3C00u + 1) << "the codes of 0 to 1.0";
    EXPECT_EQ(next_stored_below(Format::kUnorm24, 1.0f), static_cast<float>(16777214 / 16777215.0));
    EXPECT_EQ(next_stored_above(Format::kUnorm24, 0.0f), static_cast<float>(1 / 16777215.0));
    EXPECT_EQ(next_stored_below(Format::kFloat32, 1.0f), 1.0f - 0x1p-24f);
    for (const Format format : kScalar) EXPECT_EQ(next_stored_below(format, 0.0f), 0.0f);
}

TEST(Rounding, DownIsTheLargestStoredValueNotAbove) {
    for (const Format format : kScalar) {
        Random random(1);
        for (int i = 0; i < 20000; ++i) {
            const float v = random.real(0, 1) * static_cast<float>(std::exp2(-random.integer(0, 12)));
            const float down = stored_value_down(format, v);
            ASSERT_EQ(stored_value(format, down), down);
            ASSERT_LE(down, v);
            ASSERT_GT(next_stored_above(format, down), v) << format_info(format).name;
            ASSERT_EQ(stored_value_down(format, down), down) << "what is stored stays";
        }
    }
    EXPECT_EQ(stored_value_down(Format::kFloat32, 0.1f), 0.1f);
}

// Over an even grid of draws the mean is the value to half a step of the grid; one draw keeps order.
TEST(Rounding, DitheredHasTheValueAsItsMeanAndKeepsOrder) {
    constexpr int kDraws = 1000;
    for (const Format format : kScalar) {
        Random random(2);
        for (int i = 0; i < 300; ++i) {
            const float v = random.real(0, 1) * static_cast<float>(std::exp2(-random.integer(0, 10)));
            const float lower = stored_value_down(format, v);
            const float upper = next_stored_above(format, lower);
            double mean = 0;
            for (int k = 0; k < kDraws; ++k) {
                const float kept = stored_value_dithered(format, v, (static_cast<float>(k) + 0.5f) / kDraws);
                ASSERT_TRUE(kept == lower || kept == upper);
                mean += static_cast<double>(kept) / kDraws;
            }
            ASSERT_NEAR(mean, v, static_cast<double>(upper - lower) / kDraws) << format_info(format).name;
            const float draw = random.real(0, 1);
            const float larger = std::min(1.0f, v * random.real(1, 1.02));
            ASSERT_LE(stored_value_dithered(format, v, draw), stored_value_dithered(format, larger, draw));
            ASSERT_EQ(stored_value_dithered(format, lower, draw), lower) << "what is stored stays";
        }
    }
}

}  // namespace
}  // namespace ropsim
