// Opacity references bit by bit: against independent formulations, as Owen scrambles, as charged hardware,
// and at the ends of alpha (Laine and Karras 2011, section 3).
#include "rop/sampling/opacity_reference.h"

#include "rop/sampling/mask_patterns.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr OpacityHash kHashes[] = {OpacityHash::kPaper, OpacityHash::kRadicalInverse, OpacityHash::kSobol,
                                   OpacityHash::kImproved};

std::uint32_t reference(OpacityHash hash, std::uint32_t index, std::uint32_t surface) {
    return opacity_reference<PlainDatapath>(hash, index, surface);
}

// Arithmetic on strings of bits, lowest first, as taught at school.
using Bits = std::array<bool, 32>;

Bits bits_of(std::uint32_t value) {
    Bits bits{};
    for (std::size_t i = 0; i < 32; ++i) bits[i] = value / (1u << i) % 2 == 1;
    return bits;
}
std::uint32_t value_of_bits(const Bits& bits) {
    std::uint32_t value = 0;
    for (std::size_t i = 32; i-- > 0;) value = 2 * value + (bits[i] ? 1 : 0);
    return value;
}
Bits sum(const Bits& a, const Bits& b) {
    Bits result{};
    int carry = 0;
    for (std::size_t i = 0; i < 32; ++i) {
        const int digit = (a[i] ? 1 : 0) + (b[i] ? 1 : 0) + carry;
        result[i] = digit % 2 == 1;
        carry = digit / 2;
    }
    return result;
}
Bits product(const Bits& a, std::uint32_t factor) {
    Bits result{};
    Bits shifted = a;
    for (const bool digit : bits_of(factor)) {
        if (digit) result = sum(result, shifted);
        std::rotate(shifted.begin(), shifted.end() - 1, shifted.end());
        shifted[0] = false;
    }
    return result;
}
Bits flipped_by_product(const Bits& a, std::uint32_t factor) {
    Bits result = product(a, factor);
    for (std::size_t i = 0; i < 32; ++i) result[i] = result[i] != a[i];
    return result;
}
Bits reversed(Bits bits) {
    std::ranges::reverse(bits);
    return bits;
}

std::uint32_t figure_four(std::uint32_t index, std::uint32_t surface) {
    Bits x = sum(reversed(bits_of(index)), bits_of(surface));
    for (const std::uint32_t factor : {0x6C50B47Cu, 0xB82F1E52u, 0xC7AFE638u, 0x8D22F6E6u})
        x = flipped_by_product(x, factor);
    return value_of_bits(x);
}
// Burley's scramble with Vegdahl's constants.
std::uint32_t improved(std::uint32_t index, std::uint32_t seed) {
    Bits x = flipped_by_product(reversed(bits_of(index)), 0x3D20ADEAu);
    x = product(sum(x, bits_of(seed)), seed / 65536 / 2 * 2 + 1);
    x = flipped_by_product(flipped_by_product(x, 0x05526C56u), 0x53A22864u);
    return value_of_bits(x);
}
// Point `index` of Sobol's second dimension: its direction numbers are the rows of Pascal's triangle
// modulo 2.
std::uint32_t sobol(std::uint32_t index) {
    std::uint32_t result = 0;
    std::array<std::uint32_t, 33> row = {1};
    for (std::uint32_t i = 0; i < 32; ++i) {
        if ((index >> i & 1) != 0)
            for (std::uint32_t j = 0; j <= i; ++j) result ^= row[j] << (31 - j);
        for (std::size_t j = 32; j > 0; --j) row[j] ^= row[j - 1];
    }
    return result;
}

TEST(OpacityReference, AgreesWithArithmeticOnBitStrings) {
    std::mt19937 random(1);
    for (int i = 0; i < 3000; ++i) {
        const std::uint32_t index = i < 64 ? static_cast<std::uint32_t>(i) : random();
        const std::uint32_t surface = i % 3 == 0 ? random() : random() % 64;
        const Bits numbered = sum(reversed(bits_of(index)), bits_of(surface));
        ASSERT_EQ(reference(OpacityHash::kPaper, index, surface), figure_four(index, surface));
        ASSERT_EQ(reference(OpacityHash::kRadicalInverse, index, surface), value_of_bits(numbered));
        ASSERT_EQ(reference(OpacityHash::kSobol, index, surface), sobol(value_of_bits(reversed(numbered))));
        const std::uint32_t seed = surface_seed<PlainDatapath>(OpacityHash::kImproved, surface);
        ASSERT_EQ(reference(OpacityHash::kImproved, index, surface), improved(index, seed));
    }
}

// MurmurHash3 of no bytes is its finaliser of the seed; published values.
TEST(OpacityReference, SeedIsMurmursFinaliser) {
    const auto seed = [](std::uint32_t before) {
        return surface_seed<PlainDatapath>(OpacityHash::kImproved, before - 0x9E3779B9u);
    };
    EXPECT_EQ(seed(0), 0u);
    EXPECT_EQ(seed(1), 0x514E28B7u);
    EXPECT_EQ(seed(0xFFFFFFFFu), 0x81F16F39u);
    EXPECT_EQ(surface_seed<PlainDatapath>(OpacityHash::kPaper, 7), 7u);
}

// With the radical inverse, Sobol's second dimension is a (0, 2)-sequence: one of any 256 points in each box
// of 2^-k by 2^-(8 - k).
TEST(OpacityReference, SobolPairsStratifyInAllBoxes) {
    for (std::uint32_t first = 0; first < 2048; first += 256)
        for (int k = 0; k <= 8; ++k) {
            std::set<std::pair<std::uint64_t, std::uint64_t>> boxes;
            for (std::uint32_t i = first; i < first + 256; ++i)
                boxes.insert({std::uint64_t{reverse_bits(i)} >> (32 - k),
                              std::uint64_t{reference(OpacityHash::kSobol, i, 0)} >> (24 + k)});
            ASSERT_EQ(boxes.size(), 256u) << "from " << first << ", " << k;
        }
}

// The index of a given reference, by what makes a map of x an Owen scramble: result bit b is a function of
// x's bits below b, xor bit b. Works for no other map.
std::uint32_t index_of(OpacityHash hash, std::uint32_t wanted, std::uint32_t surface) {
    std::uint32_t x = 0;
    for (int b = 0; b < 32; ++b)
        if (((reference(hash, reverse_bits(x), surface) ^ wanted) >> b & 1) != 0) x |= 1u << b;
    return reverse_bits(x);
}

TEST(OpacityReference, IsAnOwenScramble) {
    std::mt19937 random(2);
    for (const OpacityHash hash : kHashes)
        for (int i = 0; i < 2000; ++i) {
            const std::uint32_t wanted = random();
            const std::uint32_t surface = random() % 1000;
            ASSERT_EQ(reference(hash, index_of(hash, wanted, surface), surface), wanted);
            // Bits above b never reach bit b.
            const int b = static_cast<int>(random() % 31);
            const std::uint32_t x = random();
            const std::uint32_t other = x ^ (random() << b << 1);
            const std::uint32_t change =
                reference(hash, reverse_bits(x), surface) ^ reference(hash, reverse_bits(other), surface);
            ASSERT_EQ(change & low_bits(static_cast<std::uint32_t>(b) + 1), 0u);
        }
}

TEST(OpacityReference, AlignedSpansAreStratified) {
    std::mt19937 random(3);
    for (const OpacityHash hash : kHashes)
        for (std::uint32_t surface = 0; surface < 64; ++surface)
            for (int k = 1; k <= 10; ++k)
                for (int trial = 0; trial < 3; ++trial) {
                    const std::uint32_t first = random() >> k << k;
                    std::vector<bool> hit(std::size_t{1} << k);
                    for (std::uint32_t i = 0; i < hit.size(); ++i)
                        hit[reference(hash, first + i, surface) >> (32 - k)] = true;
                    ASSERT_EQ(std::ranges::count(hit, true), 1 << k) << "span of 2^" << k;
                }
}

TEST(OpacityReference, AlignedSamplesCoverFloorOrCeiling) {
    std::mt19937 random(4);
    for (const OpacityHash hash : kHashes)
        for (int trial = 0; trial < 50000; ++trial) {
            const std::uint32_t samples = 1u << (random() % 7);
            const std::uint32_t first = random() / samples * samples;
            const std::uint32_t surface = random() % 64;
            const float alpha = static_cast<float>(random() >> 8) * 0x1p-24f;
            std::uint32_t covered = 0;
            for (std::uint32_t k = 0; k < samples; ++k)
                covered += reference(hash, first + k, surface) < alpha_threshold(alpha) ? 1 : 0;
            const double wanted = static_cast<double>(alpha) * samples;
            ASSERT_GE(covered, std::floor(wanted));
            ASSERT_LE(covered, std::ceil(wanted));
        }
}

// Alpha 1 passes and alpha 0 fails for every reference. In float32, the highest 128 references round to 1,
// and alpha 1 is not above them: one failure in 2^25.
TEST(OpacityReference, AlphaOneAlwaysPassesAlphaZeroNever) {
    std::mt19937 random(5);
    for (const OpacityHash hash : kHashes) {
        for (std::uint64_t index = 0; index < std::uint64_t{1} << 32; index += 65521) {
            const std::uint32_t r = reference(hash, static_cast<std::uint32_t>(index), random() % 16);
            ASSERT_LT(r, alpha_threshold(1.0f));
            ASSERT_GE(r, alpha_threshold(0.0f));
        }
        for (std::uint32_t wanted = 0xFFFFFF7Fu; wanted != 0; ++wanted) {
            const std::uint32_t r = reference(hash, index_of(hash, wanted, 3), 3);
            ASSERT_EQ(r, wanted) << "each of them does occur";
            ASSERT_LT(r, alpha_threshold(1.0f));
            ASSERT_EQ(1.0f > static_cast<float>(r) * 0x1p-32f, r == 0xFFFFFF7Fu) << r;
        }
        EXPECT_EQ(reference(hash, index_of(hash, 0, 3), 3), 0u);
        EXPECT_GE(0u, alpha_threshold(0.0f));
    }
}

// Section 3's printed example. It is an Owen scramble, but not by the hash of Fig. 4, of which surface 0
// begins 0 .5 .25 .75 .625 .125 .875 .375 and none below 2^29 gives the example: see
// HighestBitIgnoresTheNext.
TEST(OpacityReference, PrintedScrambleIsNotFigureFour) {
    const std::array<double, 8> printed = {.75, .25, 0, .5, .375, .875, .125, .625};
    const std::array<double, 8> actual = {0, .5, .25, .75, .625, .125, .875, .375};
    std::array<std::uint32_t, 8> scrambled{};
    for (std::uint32_t i = 0; i < 8; ++i) {
        EXPECT_EQ(reference(OpacityHash::kPaper, i, 0) >> 29, static_cast<std::uint32_t>(actual[i] * 8));
        scrambled[i] = static_cast<std::uint32_t>(printed[i] * 8);
    }
    // Whether bit b (of 3) is flipped is a function of the bits below it.
    for (std::uint32_t b = 0; b < 3; ++b)
        for (std::uint32_t i = 0; i < 8; ++i)
            for (std::uint32_t j = 0; j < 8; ++j) {
                const std::uint32_t x = reverse_bits(i) >> 29;
                const std::uint32_t y = reverse_bits(j) >> 29;
                if ((x ^ y) % (1u << b) != 0) continue;
                EXPECT_EQ((x ^ scrambled[i]) >> b & 1, (y ^ scrambled[j]) >> b & 1) << i << " " << j;
            }
}

// An even factor's bit 1 decides whether a round flips bit 31 with bit 30. Two of Fig. 4's four factors have
// it, so that the flips cancel: whether the highest bit is flipped never depends on bit 1 of the index, on
// which a random Owen scramble lets it depend in half of the cases. The printed example flips it at index 0
// and not at index 2.
TEST(OpacityReference, HighestBitIgnoresTheNext) {
    std::mt19937 random(6);
    int improved_flips = 0;
    for (int i = 0; i < 20000; ++i) {
        // Low bits of x that the index leaves free, so that adding the surface carries into no other.
        const std::uint32_t index = random() >> 12;
        const std::uint32_t surface = random() >> 20;
        const auto flip = [&](OpacityHash hash) {
            return (reference(hash, index, surface) ^ reference(hash, index ^ 2u, surface)) >> 31;
        };
        ASSERT_EQ(flip(OpacityHash::kPaper), 0u);
        improved_flips += static_cast<int>(flip(OpacityHash::kImproved));
    }
    EXPECT_NEAR(improved_flips, 10000, 5 * std::sqrt(20000 / 4.0));
}

// What hardware uses, by hand, on a shape whose latencies tell the units apart.
TEST(OpacityReference, ChargesItsUnits) {
    DatapathShape shape;
    shape.latency[static_cast<std::size_t>(Unit::kIntegerMultiplier)] = 100;
    shape.latency[static_cast<std::size_t>(Unit::kIntegerAdder)] = 10;
    shape.latency[static_cast<std::size_t>(Unit::kLogic)] = 1;
    struct Expected {
        OpacityHash hash;
        std::uint32_t multipliers, adders, logic;
        int latency;
    };
    for (const Expected& expected :
         {Expected{OpacityHash::kPaper, 4, 1, 4, 414}, Expected{OpacityHash::kRadicalInverse, 0, 1, 0, 10},
          Expected{OpacityHash::kSobol, 0, 1, 5, 15},
          // The seed (213) is awaited after the first round (101).
          Expected{OpacityHash::kImproved, 6, 2, 6, 213 + 10 + 100 + 202}}) {
        Ledger ledger(shape);
        const Wire<std::uint32_t> r = opacity_reference<ChargedDatapath>(
            expected.hash, Wire<std::uint32_t>(123456u), Wire<std::uint32_t>(5u));
        EXPECT_EQ(r.value, reference(expected.hash, 123456, 5));
        UnitCounts units{};
        units[static_cast<std::size_t>(Unit::kIntegerMultiplier)] = expected.multipliers;
        units[static_cast<std::size_t>(Unit::kIntegerAdder)] = expected.adders;
        units[static_cast<std::size_t>(Unit::kLogic)] = expected.logic;
        EXPECT_EQ(ledger.work().units, units);
        EXPECT_EQ(r.ready, expected.latency);
        EXPECT_EQ(ledger.work().latency, expected.latency);
    }
}

}  // namespace
}  // namespace ropsim
