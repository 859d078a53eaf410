// Visibility as a Haar series of absorbance over depth: Aizenshtein, Smal and McGuire 2022. A fragment of
// absorbance A at depth d adds a step of height A at d. The series has a mean over [0, 1] and 2^p
// coefficients at each level p = 0 to rank, with half-length 2^(-p-1); a step touches one of each level.
// Depth is scaled so that no step lies in the last bin: its value is all absorbance.
//
// Indices: level p's coefficient k is element 2^p - 1 + k, the mean is the last element, as in the public
// GLSL (Colorwheel, wavelet.glsl). Coefficients have that shader's sign: of a step all are positive.
#pragma once

#include "rop/datapath.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace ropsim {

inline constexpr int kMaxHaarRank = 5;

constexpr int haar_coefficients(int rank) {
    return 2 << rank;
}
constexpr int haar_mean(int rank) {
    return haar_coefficients(rank) - 1;
}
// 2^(p / 2).
inline constexpr std::array<float, kMaxHaarRank + 1> kHaarScale = {1.0f,        1.41421356f, 2.0f,
                                                                   2.82842712f, 4.0f,        5.65685425f};
inline constexpr std::array<float, kMaxHaarRank + 1> kHaarInverse = {1.0f,        0.70710678f, 0.5f,
                                                                     0.35355339f, 0.25f,       0.17677670f};

// Where a depth in [0, 1] lies: the bin and how far into it.
template <class D>
struct HaarPlace {
    typename D::Real position;  // in bins
    typename D::Uint bin;
    typename D::Real into;  // [0, 1)

    HaarPlace(int rank, const typename D::Real& depth)
        : position(depth * typename D::Real(static_cast<float>(haar_mean(rank)))),
          bin(floor_to_uint(position)),
          into(position - to_real(bin)) {}
};

// Coefficient of level p over the bin: which one, and whether the bin is in the nearer half of its support.
template <class D>
struct HaarTerm {
    typename D::Uint index;  // within the level
    typename D::Bool nearer;

    HaarTerm(int rank, int level, const typename D::Uint& bin)
        : index(shifted_right(bin, rank + 1 - level)), nearer(inverse(bit(bin, rank - level))) {}
};

// What a step of `absorbance` adds to the coefficient of its place at a level: a tent over the support.
template <class D>
typename D::Real haar_addend(int rank, int level, const HaarPlace<D>& place, const HaarTerm<D>& term,
                             const typename D::Real& absorbance) {
    using Real = typename D::Real;
    const int bins = rank + 1 - level;  // log2 of the support's length
    const Real start = to_real(term.index);
    const Real within = place.position * Real(1.0f / static_cast<float>(1 << bins)) - start;
    const Real tent = select(term.nearer, within, Real(1.0f) - within);
    return tent * (absorbance * Real(kHaarInverse[static_cast<std::size_t>(level)]));
}

// And to the mean.
template <class D>
typename D::Real haar_mean_addend(int rank, const HaarPlace<D>& place, const typename D::Real& absorbance) {
    using Real = typename D::Real;
    const float bins = static_cast<float>(haar_coefficients(rank));
    return absorbance - absorbance * (place.position * Real(1.0f / bins));
}

// The term of a coefficient in the series' value in a bin.
template <class D>
typename D::Real haar_value(int level, const HaarTerm<D>& term, const typename D::Real& coefficient) {
    const auto scaled = coefficient * typename D::Real(kHaarScale[static_cast<std::size_t>(level)]);
    return select(term.nearer, negative(scaled), scaled);
}

}  // namespace ropsim
