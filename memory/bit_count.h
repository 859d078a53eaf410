// Counting set bits in line: std::popcount is a library call on a plain x86-64.
#pragma once

#include <cstdint>

namespace ropsim {

constexpr std::uint32_t bits_set(std::uint32_t word) {
    word -= word >> 1 & 0x55555555u;
    word = (word & 0x33333333u) + (word >> 2 & 0x33333333u);
    word = (word + (word >> 4)) & 0x0F0F0F0Fu;
    return word * 0x01010101u >> 24;
}

constexpr std::uint32_t bits_set(std::uint64_t word) {
    word -= word >> 1 & 0x5555555555555555u;
    word = (word & 0x3333333333333333u) + (word >> 2 & 0x3333333333333333u);
    word = (word + (word >> 4)) & 0x0F0F0F0F0F0F0F0Fu;
    return static_cast<std::uint32_t>(word * 0x0101010101010101u >> 56);
}

// Of four words together: the words are added as soon as their counts fit into the same bits.
constexpr std::uint32_t bits_set(std::uint64_t a, std::uint64_t b, std::uint64_t c, std::uint64_t d) {
    const auto nibbles = [](std::uint64_t word) {
        word -= word >> 1 & 0x5555555555555555u;
        return (word & 0x3333333333333333u) + (word >> 2 & 0x3333333333333333u);
    };
    const auto bytes = [](std::uint64_t two) {
        return (two & 0x0F0F0F0F0F0F0F0Fu) + (two >> 4 & 0x0F0F0F0F0F0F0F0Fu);
    };
    const std::uint64_t sum =
        bytes(nibbles(a) + nibbles(b)) + bytes(nibbles(c) + nibbles(d));  // at most 32 a byte
    constexpr std::uint64_t kLow = 0x00FF00FF00FF00FFu;                   // 256 do not fit into a byte
    return static_cast<std::uint32_t>(((sum & kLow) + (sum >> 8 & kLow)) * 0x0001000100010001u >> 48);
}

}  // namespace ropsim
