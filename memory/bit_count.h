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

}  // namespace ropsim
