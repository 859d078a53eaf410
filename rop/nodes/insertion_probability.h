// The probability that a fragment is seen behind layers that cover part of a pixel: Wyman 2016, section 2.1,
// equation 1 and the one below it, as a table over numbers of coverage bits.
#pragma once

#include "rop/datapath.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ropsim {

enum class CoverageBits : std::uint8_t {
    kStratified,     // a fragment's t bits are t different ones of b: 1 - (s)_t / (b)_t
    kNonStratified,  // each bit is set by itself with probability t / b: 1 - ((b - t) / b)^(b - s)
};

class InsertionProbability {
 public:
    static constexpr int kMaxBits = 1024;

    InsertionProbability() = default;
    // `bits`: 1 to kMaxBits.
    InsertionProbability(int bits, CoverageBits kind);

    // For s of the bits covered in front and t of the fragment's own; both in [0, bits].
    float at(std::uint32_t s, std::uint32_t t) const {
        const auto most = static_cast<std::uint32_t>(bits_);
        return table_[static_cast<std::size_t>(std::min(s, most)) * (most + 1) + std::min(t, most)];
    }
    template <class D>
    typename D::Real look_up(const typename D::Uint& s, const typename D::Uint& t) const {
        const float probability = at(value_of(s), value_of(t));
        if constexpr (D::kCharged)
            return {probability, Ledger::active().charge(Unit::kTable, std::max(s.ready, t.ready))};
        else
            return probability;
    }
    // The number of bits nearest to alpha, halves up.
    template <class D>
    typename D::Uint count(const typename D::Real& alpha) const {
        using Real = typename D::Real;
        return floor_to_uint(Real(static_cast<float>(bits_)) * alpha + Real(0.5f));
    }

 private:
    int bits_ = 0;
    std::vector<float> table_;
};

}  // namespace ropsim
