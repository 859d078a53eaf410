// The opacity reference values of stratified stochastic transparency (Laine and Karras 2011, section 3) and
// three that they are compared with, over either datapath.
#pragma once

#include "rop/datapath.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace ropsim {

// All take the same input: x, the 32 bits of the index reversed. Each but the last then adds the surface's
// number to x, that is, to the highest bits of the index. In all, bit b of the result depends on the bits of
// x up to b and flips with bit b, so that any aligned run of 2^k indices has one result in each of 2^k equal
// intervals.
enum class OpacityHash : std::uint8_t {
    kPaper,           // Laine and Karras, Fig. 4: four rounds of multiply and xor
    kRadicalInverse,  // x itself: nearly equal in all surfaces, hence biased (section 3)
    kSobol,           // Fig. 3b: the second dimension of Sobol's sequence
    // A nested uniform scramble seeded by the surface: the Laine-Karras permutation as Burley (Practical
    // hash-based Owen scrambling, 2020) uses it, with the constants of N. Vegdahl.
    kImproved,
};

namespace detail {
// Direction numbers of Sobol's second dimension: the recurrence m(k) = 2 m(k-1) xor m(k-1) of the primitive
// polynomial x + 1 from m(1) = 1, as binary fractions of 32 bits. Bit i of the index xors number i.
constexpr std::array<std::uint32_t, 32> sobol_directions() {
    std::array<std::uint32_t, 32> directions{};
    std::uint32_t m = 1;
    for (std::size_t i = 0; i < directions.size(); ++i) {
        directions[i] = m << (31 - i);
        m = (2 * m) ^ m;
    }
    return directions;
}

// Constant shifts and masks are wires.
constexpr std::uint32_t masked_left(std::uint32_t x, std::uint32_t mask, int shift) {
    return (x & mask) << shift;
}
inline Wire<std::uint32_t> masked_left(const Wire<std::uint32_t>& x, std::uint32_t mask, int shift) {
    return {masked_left(x.value, mask, shift), x.ready};
}
constexpr std::uint32_t made_odd(std::uint32_t x) {
    return x | 1u;
}
inline Wire<std::uint32_t> made_odd(const Wire<std::uint32_t>& x) {
    return {made_odd(x.value), x.ready};
}

// Sobol's second dimension of an index given as its reversed bits. Direction number i has the bits of row i
// of Pascal's triangle modulo 2, which is a product of five sparse matrices: five xors of a word with part of
// itself.
template <class Uint>
constexpr Uint sobol_of_reversed(Uint x) {
    x = x ^ masked_left(x, 0x55555555u, 1);
    x = x ^ masked_left(x, 0x33333333u, 2);
    x = x ^ masked_left(x, 0x0F0F0F0Fu, 4);
    x = x ^ masked_left(x, 0x00FF00FFu, 8);
    x = x ^ masked_left(x, 0x0000FFFFu, 16);
    return x;
}
// Both are linear over xor, so that agreeing on single bits is agreeing.
constexpr bool five_xors_are_sobol() {
    const std::array<std::uint32_t, 32> directions = sobol_directions();
    for (std::size_t i = 0; i < directions.size(); ++i)
        if (sobol_of_reversed(0x80000000u >> i) != directions[i]) return false;
    return true;
}
static_assert(five_xors_are_sobol());

// Fig. 4, lines 3 to 6.
template <class Uint>
Uint paper_scramble(Uint x) {
    x = x ^ (x * Uint(0x6C50B47Cu));
    x = x ^ (x * Uint(0xB82F1E52u));
    x = x ^ (x * Uint(0xC7AFE638u));
    x = x ^ (x * Uint(0x8D22F6E6u));
    return x;
}

template <class Uint>
Uint improved_scramble(Uint x, const Uint& seed) {
    x = x ^ (x * Uint(0x3D20ADEAu));
    x = x + seed;
    x = x * made_odd(shifted_right(seed, 16));
    x = x ^ (x * Uint(0x05526C56u));
    x = x ^ (x * Uint(0x53A22864u));
    return x;
}
}  // namespace detail

// What opacity_reference uses of a surface's number, the same for all samples of a fragment: the number
// itself or, for kImproved, a hash of it, since its scramble needs seeds that differ in all bits: the 32-bit
// finaliser of MurmurHash3 after adding 2^32 / golden ratio, which keeps surface 0 off its fixed point 0.
template <class D>
typename D::Uint surface_seed(OpacityHash hash, const typename D::Uint& surface) {
    using Uint = typename D::Uint;
    if (hash != OpacityHash::kImproved) return surface;
    Uint h = surface + Uint(0x9E3779B9u);
    h = h ^ shifted_right(h, 16);
    h = h * Uint(0x85EBCA6Bu);
    h = h ^ shifted_right(h, 13);
    h = h * Uint(0xC2B2AE35u);
    return h ^ shifted_right(h, 16);
}

// The reference of one sample, to be divided by 2^32; `seed` is the surface's surface_seed.
template <class D>
typename D::Uint seeded_reference(OpacityHash hash, const typename D::Uint& index,
                                  const typename D::Uint& seed) {
    const typename D::Uint x = reverse_bits(index);
    switch (hash) {
        case OpacityHash::kPaper:
            return detail::paper_scramble(x + seed);
        case OpacityHash::kRadicalInverse:
            return x + seed;
        case OpacityHash::kSobol:
            return detail::sobol_of_reversed(x + seed);
        case OpacityHash::kImproved:
            return detail::improved_scramble(x, seed);
    }
    CHECK(false);
    return x;
}

// CalcAlphaRef of Fig. 4 without its scaling to [0, 1]: the reference of the sample numbered `index` (pixel
// index x samples a pixel + number of the sample) on surface number `surface`, to be divided by 2^32. It must
// be compared as an integer (mask_patterns.h, alpha_threshold): in float32 the highest 128 round to 1, where
// alpha 1 fails. Bit reversal, constant shifts and masks are wires; all else is charged.
template <class D>
typename D::Uint opacity_reference(OpacityHash hash, const typename D::Uint& index,
                                   const typename D::Uint& surface) {
    return seeded_reference<D>(hash, index, surface_seed<D>(hash, surface));
}

}  // namespace ropsim
