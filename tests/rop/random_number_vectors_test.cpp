// The model draws the numbers that docs/random-numbers.md specifies.
#include "base/random.h"
#include "rop/hilbert.h"
#include "rop/sampling/mask_patterns.h"
#include "rop/sampling/opacity_reference.h"
#include "rop/sampling/pixel_order.h"
#include "rop/sampling/random_masks.h"
#include "rop/threshold_hash.h"
#include "tests/base/test_vectors.h"

#include <bit>
#include <functional>
#include <map>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::TestVector;

float real(std::uint32_t bits) {
    return std::bit_cast<float>(bits);
}
std::uint64_t bits_of(float value) {
    return std::bit_cast<std::uint32_t>(value);
}
// R = floor(alpha n + xi) as MaskChooser has it; x, y and whether to dither stand from argument `at` on.
std::uint32_t count(const TestVector& v, float alpha, std::uint32_t n, std::size_t at) {
    const float xi = v.word(at + 2) != 0
                         ? dither_threshold(static_cast<int>(v.word(at)), static_cast<int>(v.word(at + 1)))
                         : draw_unit<PlainDatapath>(v.arguments[0], 0);
    return floor_to_uint(alpha * static_cast<float>(n) + xi);
}

std::uint64_t chosen(const TestVector& v) {
    const auto n = static_cast<std::uint32_t>(std::popcount(v.arguments[2]));
    return random_subset<PlainDatapath>(v.arguments[0], count(v, real(v.word(3)), n, 4),
                                        SampleMask<PlainDatapath>{v.arguments[2]}, n,
                                        static_cast<int>(v.word(1)))
        .bits;
}
std::uint64_t run(const TestVector& v) {
    const auto samples = static_cast<int>(v.word(1));
    return run_mask(samples, scaled_draw<PlainDatapath>(random_bits(v.arguments[0], 1), v.word(1)),
                    count(v, real(v.word(2)), v.word(1), 3));
}

const std::map<std::string, std::function<std::uint64_t(const TestVector&)>> model_draws = {
    {"mix", [](const TestVector& v) { return mix64(v.arguments[0]); }},
    {"bits", [](const TestVector& v) { return random_bits(v.arguments[0], v.word(1)); }},
    {"unit", [](const TestVector& v) { return bits_of(random_unit(v.arguments[0], v.word(1))); }},
    // As operation_of.h and MaskChooser make it; that they do is what `ropsim validate` shows.
    {"key",
     [](const TestVector& v) {
         return mix64(mix64(v.arguments[0] * 0x9E3779B97F4A7C15ull + v.arguments[1]) ^
                      (v.arguments[2] << 32) ^ v.arguments[3]);
     }},
    {"coin",
     [](const TestVector& v) {
         return coin_mask<PlainDatapath>(v.arguments[0], real(v.word(2)), static_cast<int>(v.word(1))).bits;
     }},
    {"choose", chosen},
    {"run", run},
    {"covers",
     [](const TestVector& v) {
         return alpha_to_coverage_mask(static_cast<int>(v.word(0)), real(v.word(1)));
     }},
    {"dither",
     [](const TestVector& v) {
         return bits_of(dither_threshold(static_cast<int>(v.word(0)), static_cast<int>(v.word(1))));
     }},
    {"hilbert",
     [](const TestVector& v) {
         return hilbert_index(static_cast<int>(v.word(0)), static_cast<int>(v.word(1)),
                              static_cast<int>(v.word(2)));
     }},
    {"morton",
     [](const TestVector& v) {
         return morton_index(static_cast<int>(v.word(0)), static_cast<int>(v.word(1)));
     }},
    {"reference",
     [](const TestVector& v) {
         return opacity_reference<PlainDatapath>(OpacityHash::kPaper, v.word(0), v.word(1));
     }},
    {"words",
     [](const TestVector& v) {
         return hash_words<PlainDatapath>({v.word(0), v.word(1), v.word(2)}, v.word(3));
     }},
};

TEST(RandomNumberVectors, ModelDrawsThem) {
    const auto vectors = test::read_test_vectors(ROPSIM_SOURCE_DIR "/docs/random-number-vectors.txt");
    ASSERT_GT(vectors.size(), 500u);
    std::map<std::string, int> seen;
    for (const TestVector& v : vectors) {
        ASSERT_TRUE(model_draws.contains(v.name)) << v.line;
        EXPECT_EQ(model_draws.at(v.name)(v), v.result) << v.line;
        ++seen[v.name];
    }
    EXPECT_EQ(seen.size(), model_draws.size());
}

}  // namespace
}  // namespace ropsim
