// Randomness as a pure function of its keys: the same draw on any thread, in any order.
#pragma once

#include <cstdint>

namespace ropsim {

// One round of a 64-bit finaliser (Stafford's variant 13 of the MurmurHash3 finaliser, as in SplitMix64).
constexpr std::uint64_t mix64(std::uint64_t x) {
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ull;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBull;
    return x ^ (x >> 31);
}

// 32 uniform bits from a key; successive `draw` values are independent streams.
constexpr std::uint32_t random_bits(std::uint64_t key, std::uint32_t draw) {
    return static_cast<std::uint32_t>(mix64(key + 0x9E3779B97F4A7C15ull * (draw + 1ull)) >> 32);
}

// Uniform in [0, 1): 24 bits, exactly representable, never 1.
constexpr float random_unit(std::uint64_t key, std::uint32_t draw) {
    return static_cast<float>(random_bits(key, draw) >> 8) * 0x1p-24f;
}

}  // namespace ropsim
