// Random masks of stored samples, as a pure function of a key: a coin a sample, or a uniformly random subset
// of a given size (Enderton et al. 2011, section 3.1). Sample s uses draw 1 + s.
#pragma once

#include "rop/datapath.h"
#include "rop/sampling/sample_mask.h"

#include <algorithm>
#include <bit>
#include <cstdint>

namespace ropsim {

// floor(bits n / 2^32): uniform in [0, n).
template <class D>
typename D::Uint scaled_draw(const typename D::Uint& bits, const typename D::Uint& n) {
    const auto high =
        static_cast<std::uint32_t>((static_cast<std::uint64_t>(value_of(bits)) * value_of(n)) >> 32);
    if constexpr (D::kCharged)
        return {high, Ledger::active().charge(Unit::kIntegerMultiplier, std::max(bits.ready, n.ready))};
    else
        return high;
}

// Each of `samples` samples with probability alpha, independently.
template <class D>
SampleMask<D> coin_mask(std::uint64_t key, const typename D::Real& alpha, int samples) {
    const std::uint64_t threshold = alpha_threshold(value_of(alpha));
    SampleMask<D> mask;
    for (int s = 0; s < samples; ++s) {
        const auto bits = draw_bits<D>(key, static_cast<std::uint32_t>(1 + s));
        const bool taken = value_of(bits) < threshold;
        if constexpr (D::kCharged)
            mask.wires[static_cast<std::size_t>(s)] = {
                taken, Ledger::active().charge(Unit::kComparator, bits.ready)};
        else
            mask.bits |= static_cast<std::uint64_t>(taken) << s;
    }
    return mask;
}

namespace detail {
inline bool takes(std::uint64_t key, int s, std::uint32_t left, std::uint32_t wanted) {
    const std::uint32_t bits = random_bits(key, static_cast<std::uint32_t>(1 + s));
    return ((std::uint64_t{bits} * left) >> 32) < wanted;
}
// Without branches on the draws, which no processor predicts.
inline std::uint64_t subset_of_all(std::uint64_t key, std::uint32_t wanted, int samples) {
    std::uint64_t chosen = 0;
    auto left = static_cast<std::uint32_t>(samples);
    for (int s = 0; s < samples; ++s, --left) {
        const std::uint64_t taken = takes(key, s, left, wanted) ? 1 : 0;
        chosen |= taken << s;
        wanted -= static_cast<std::uint32_t>(taken);
    }
    return chosen;
}
}  // namespace detail

// Uniform choice of `count` of the n candidates by selection sampling: a candidate is taken with
// probability (still to take) / (still to come). Exact up to 2^-32.
template <class D>
SampleMask<D> random_subset(std::uint64_t key, const typename D::Uint& count, const SampleMask<D>& candidates,
                            const typename D::Uint& n, int samples) {
    using Uint = typename D::Uint;
    SampleMask<D> chosen;
    Uint wanted = count;
    Uint left = n;
    if constexpr (D::kCharged) {
        for (int s = 0; s < samples; ++s) {
            const auto position = scaled_draw<D>(draw_bits<D>(key, static_cast<std::uint32_t>(1 + s)), left);
            const auto take = both(position < wanted, candidates.test(s));
            chosen.wires[static_cast<std::size_t>(s)] = take;
            wanted = wanted - select(take, Uint(1u), Uint(0u));
            left = left - select(candidates.test(s), Uint(1u), Uint(0u));
        }
    } else {
        if (candidates.bits == low_bits(static_cast<std::uint32_t>(samples)))
            return {detail::subset_of_all(key, count, samples)};
        std::uint64_t rest = candidates.bits;
        for (; rest != 0 && wanted != 0 && wanted < left; rest &= rest - 1, --left) {
            const int s = std::countr_zero(rest);
            if (!detail::takes(key, s, left, wanted)) continue;
            chosen.bits |= 1ull << s;
            --wanted;
        }
        if (wanted != 0) chosen.bits |= rest;  // as many as are left
    }
    return chosen;
}

}  // namespace ropsim
