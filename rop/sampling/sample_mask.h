// A set of stored samples on the datapath: a word of bits in software, a wire a sample in hardware.
#pragma once

#include "rop/pixel.h"
#include "rop/sampling/mask_patterns.h"

#include <array>
#include <bit>
#include <cstdint>

namespace ropsim {

template <class D>
struct SampleMask;

template <>
struct SampleMask<PlainDatapath> {
    std::uint64_t bits = 0;

    bool test(int sample) const { return ((bits >> sample) & 1) != 0; }
};

template <>
struct SampleMask<ChargedDatapath> {
    std::array<Wire<bool>, kMaxElements> wires{};

    const Wire<bool>& test(int sample) const { return wires[static_cast<std::size_t>(sample)]; }
};

// Calls body(sample) for the samples of the mask in software, and for all of them in hardware, where what the
// body does is gated by the sample's wire.
template <class Body>
void for_samples(const SampleMask<PlainDatapath>& mask, int, Body body) {
    for (std::uint64_t left = mask.bits; left != 0; left &= left - 1) body(std::countr_zero(left));
}
template <class Body>
void for_samples(const SampleMask<ChargedDatapath>&, int samples, Body body) {
    for (int s = 0; s < samples; ++s) body(s);
}

inline bool any_sample(const SampleMask<PlainDatapath>& mask, int) {
    return mask.bits != 0;
}
// A tree of gates.
inline Wire<bool> any_sample(const SampleMask<ChargedDatapath>& mask, int samples) {
    SampleMask<ChargedDatapath> level = mask;
    for (int stride = 1; stride < samples; stride *= 2)
        for (int s = 0; s + stride < samples; s += 2 * stride)
            level.wires[static_cast<std::size_t>(s)] = either(level.test(s), level.test(s + stride));
    return level.wires[0];
}

// Word `word` of the mask, as it goes into a field of bits: in hardware the wires side by side.
inline std::uint32_t word_of(const SampleMask<PlainDatapath>& mask, int, int word) {
    return static_cast<std::uint32_t>(mask.bits >> (32 * word));
}
inline Wire<std::uint32_t> word_of(const SampleMask<ChargedDatapath>& mask, int samples, int word) {
    Wire<std::uint32_t> result = 0u;
    for (int s = 32 * word; s < std::min(samples, 32 * word + 32); ++s) {
        result.value |= mask.test(s).value ? 1u << (s % 32) : 0u;
        result.ready = std::max(result.ready, mask.test(s).ready);
    }
    return result;
}

// The number of samples: a population count of each 32 of them in hardware.
inline std::uint32_t count_samples(const SampleMask<PlainDatapath>& mask, int) {
    std::uint64_t v = mask.bits;
    v -= (v >> 1) & 0x5555555555555555ull;
    v = (v & 0x3333333333333333ull) + ((v >> 2) & 0x3333333333333333ull);
    v = (v + (v >> 4)) & 0x0F0F0F0F0F0F0F0Full;
    return static_cast<std::uint32_t>((v * 0x0101010101010101ull) >> 56);
}
inline Wire<std::uint32_t> count_samples(const SampleMask<ChargedDatapath>& mask, int samples) {
    Wire<std::uint32_t> total = 0u;
    for (int from = 0; from < samples; from += 32) {
        Wire<std::uint32_t> word = 0u;
        for (int s = from; s < std::min(samples, from + 32); ++s) {
            word.value += mask.test(s).value ? 1u : 0u;
            word.ready = std::max(word.ready, mask.test(s).ready);
        }
        word.ready = Ledger::active().charge(Unit::kLogic, word.ready);
        total = from == 0 ? word : total + word;
    }
    return total;
}

// A mask whose bits are all ready at `ready`: a table's output, or an attribute of the fragment at 0.
template <class D>
SampleMask<D> mask_at(std::uint64_t bits, [[maybe_unused]] int ready) {
    SampleMask<D> mask;
    if constexpr (D::kCharged)
        for (int s = 0; s < kMaxElements; ++s)
            mask.wires[static_cast<std::size_t>(s)] = {((bits >> s) & 1) != 0, ready};
    else
        mask.bits = bits;
    return mask;
}

// The first `samples` stored samples where a coverage mask of M spatial samples has its bits: stored sample s
// lies at spatial sample s mod M.
inline std::uint64_t stored_coverage(std::uint32_t coverage, int spatial_samples, int samples) {
    if (spatial_samples == 1) return (coverage & 1u) != 0 ? low_bits(static_cast<std::uint32_t>(samples)) : 0;
    std::uint64_t bits = coverage & ((1u << spatial_samples) - 1u);
    for (int filled = spatial_samples; filled < samples; filled *= 2) bits |= bits << filled;
    return bits & low_bits(static_cast<std::uint32_t>(samples));
}

inline SampleMask<PlainDatapath> both(const SampleMask<PlainDatapath>& a, const SampleMask<PlainDatapath>& b,
                                      int) {
    return {a.bits & b.bits};
}
inline SampleMask<ChargedDatapath> both(const SampleMask<ChargedDatapath>& a,
                                        const SampleMask<ChargedDatapath>& b, int samples) {
    SampleMask<ChargedDatapath> result;
    for (int s = 0; s < samples; ++s) result.wires[static_cast<std::size_t>(s)] = both(a.test(s), b.test(s));
    return result;
}

}  // namespace ropsim
