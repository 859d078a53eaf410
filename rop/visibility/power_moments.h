// Visibility from power moments b_k = sum of A z^k, z in [-1, 1]: Muenstermann, Krumpen, Klein and Peters
// 2018, after Tari et al. 2005. Of all distributions of absorbance with these moments, two bound the share in
// front of a depth z0; both have z0 and n further points as their support, and what is returned lies between
// them.
//
// Two ways to the same number. `published::transmittance` (published_moments.h) is the paper's: factors
// of the Hankel matrix, the support's polynomial in z, an interpolation polynomial. A single fragment makes
// the matrix singular and float arithmetic then takes roots of negative numbers. `share_in_front` here is
// mended. It takes the recurrence of the orthogonal polynomials from the moments (Chebyshev's algorithm),
// where a bound on each coefficient makes any input the moments of some distribution; solves for 1 / (z -
// z0), which has no root at infinity; and takes the support's weights as reciprocals of sums of squares
// (Christoffel numbers), which no rounding makes negative.
#pragma once

#include "rop/visibility/real_roots.h"

#include <array>
#include <cstddef>

namespace ropsim {

inline constexpr int kMaxMomentOrder = 4;  // n: half the number of power moments

template <int kOrder, class Real>
using PowerMoments = std::array<Real, std::size_t{2} * kOrder>;  // b_1 / b_0, b_2 / b_0, ...

// The share of the fragment's own point that counts as in front (the paper's beta), and the bias: the weight
// of a distribution that no rounding makes singular.
struct MomentBias {
    float weight = 0;
    float overestimation = 0;
    std::array<float, std::size_t{2} * kMaxMomentOrder> moments{};
};

template <int kOrder, class Real>
PowerMoments<kOrder, Real> biased(const MomentBias& bias, const PowerMoments<kOrder, Real>& b) {
    PowerMoments<kOrder, Real> result;
    for (std::size_t i = 0; i < result.size(); ++i)
        result[i] = b[i] + (Real(bias.moments[i]) - b[i]) * Real(bias.weight);
    return result;
}

namespace detail {
// p_{k+1}(z) = (z - shift_k) p_k(z) - norm_k p_{k-1}(z), with norm_k > 0.
template <int kOrder, class Real>
struct Recurrence {
    std::array<Real, kOrder> shift;
    std::array<Real, kOrder + 1> norm;  // norm[0] is not used
};

// Rounding of moments stored as float32. A norm below it says that the distribution is concentrated in fewer
// points than the order; what further polynomials would say is noise.
inline constexpr float kMomentNoise = 0x1p-23f;

template <int kOrder, class Real>
Recurrence<kOrder, Real> recurrence_of(const PowerMoments<kOrder, Real>& b) {
    Recurrence<kOrder, Real> r;
    constexpr std::size_t kColumns = 2 * kOrder + 1;
    std::array<Real, kColumns> before{};  // row k - 1 of the mixed moments <p_k, z^l>
    std::array<Real, kColumns> row;       // row k
    row[0] = Real(1.0f);
    for (std::size_t l = 1; l < kColumns; ++l) row[l] = b[l - 1];
    r.shift[0] = b[0];
    Real before_ratio = b[0];  // row[k + 1] / row[k]
    decltype(b[0] < b[0]) concentrated = false;
    for (std::size_t k = 1; k <= kOrder; ++k) {
        std::array<Real, kColumns> next{};
        for (std::size_t l = k; l < kColumns - k; ++l) {
            next[l] = row[l + 1] - r.shift[k - 1] * row[l];
            if (k > 1) next[l] = next[l] - r.norm[k - 1] * before[l];
        }
        const auto noisy = inverse(Real(kMomentNoise) < next[k]);
        next[k] = maximum(next[k], Real(kMomentNoise));
        const Real norm = k == 1 ? next[k] : next[k] / row[k - 1];
        r.norm[k] = k == 1 ? norm : select(concentrated, Real(0.25f), norm);
        concentrated = k == 1 ? noisy : either(concentrated, noisy);
        if (k < kOrder) {
            const Real ratio = next[k + 1] / next[k];
            const Real shift = minimum(maximum(ratio - before_ratio, Real(-1.0f)), Real(1.0f));
            r.shift[k] = select(concentrated, Real(0.0f), shift);
            before_ratio = ratio;
        }
        before = row;
        row = next;
    }
    return r;
}

// Sum of p_k(z0 + h)^2 times the product of the norms behind k: inverse to the weight that a point of support
// at z0 + h has.
template <int kOrder, class Real>
Real inverse_weight(const Recurrence<kOrder, Real>& r, const std::array<Real, kOrder>& tail, const Real& z0,
                    const Real& h) {
    Real p = Real(1.0f);
    Real before = Real(0.0f);
    Real sum = tail[0];
    for (std::size_t i = 0; i < kOrder; ++i) {
        Real next = (h + (z0 - r.shift[i])) * p;
        if (i > 0) next = next - r.norm[i] * before;
        before = p;
        p = next;
        const Real square = p * p;
        sum = sum + (i + 1 == kOrder ? square : square * tail[i + 1]);
    }
    return sum;
}

// Coefficients of the sum of p_k(z0) p_k(z0 + h) times the tail, by power of h. Its roots are the support
// beside z0.
template <int kOrder, class Real>
std::array<Real, kOrder + 1> support_polynomial(const Recurrence<kOrder, Real>& r,
                                                const std::array<Real, kOrder>& tail, const Real& z0) {
    constexpr std::size_t kTerms = kOrder + 1;
    std::array<Real, kTerms> before;
    std::array<Real, kTerms> p;
    std::array<Real, kTerms> sum;
    p[0] = Real(1.0f);
    sum[0] = tail[0];
    for (std::size_t k = 0; k < kOrder; ++k) {
        std::array<Real, kTerms> next;
        const Real offset = z0 - r.shift[k];
        for (std::size_t j = 0; j <= k + 1; ++j) {
            if (j == k + 1) {
                next[j] = p[k];
                continue;
            }
            next[j] = offset * p[j];
            if (j > 0) next[j] = next[j] + p[j - 1];
            if (k > 0 && j < k) next[j] = next[j] - r.norm[k] * before[j];
        }
        before = p;
        p = next;
        const Real factor = k + 1 == kOrder ? p[0] : p[0] * tail[k + 1];
        for (std::size_t j = 0; j <= k + 1; ++j) {
            const Real term = j == k + 1 ? factor : factor * p[j];
            sum[j] = j == k + 1 ? term : sum[j] + term;
        }
    }
    return sum;
}

// Roots s = 1 / h for the coefficients by power of h, the first above 0.
template <std::size_t kTerms, class Real>
std::array<Real, kTerms - 1> inverse_distances(const std::array<Real, kTerms>& c, const Real& inverse_first) {
    const Real b1 = c[1] * inverse_first;
    const Real b2 = c[2] * inverse_first;
    if constexpr (kTerms == 3)
        return quadratic_roots<Real>(b1, b2);
    else if constexpr (kTerms == 4)
        return cubic_roots<Real>(b1, b2, c[3] * inverse_first);
    else
        return quartic_roots<Real>(b1, b2, c[3] * inverse_first, c[4] * inverse_first);
}

// The product of norm[k + 1] to norm[order] for each k below the order.
template <int kOrder, class Real>
std::array<Real, kOrder> tails(const Recurrence<kOrder, Real>& r) {
    std::array<Real, kOrder> tail;
    tail[kOrder - 1] = r.norm[kOrder];
    for (std::size_t k = kOrder - 1; k > 0; --k) tail[k - 1] = r.norm[k] * tail[k];
    return tail;
}
}  // namespace detail

// The share of all absorbance that is in front of z0, in [0, 1], whatever the moments are.
template <int kOrder, class Real>
Real share_in_front(const MomentBias& bias, const PowerMoments<kOrder, Real>& moments, const Real& z0) {
    const auto r = detail::recurrence_of<kOrder, Real>(biased<kOrder, Real>(bias, moments));
    const std::array<Real, kOrder> tail = detail::tails(r);
    const auto polynomial = detail::support_polynomial<kOrder, Real>(r, tail, z0);
    const Real own = Real(1.0f) / polynomial[0];
    const std::array<Real, kOrder> inverses = detail::inverse_distances(polynomial, own);
    // A point farther away than this has no weight that float32 could add to the others.
    constexpr float kFar = 1e4f;
    Real front = Real(bias.overestimation) * own;
    Real all = own;
    for (const Real& inverse : inverses) {
        const auto is_front = inverse < Real(0.0f);
        const auto far = magnitude(inverse) < Real(1.0f / kFar);
        const Real h = Real(1.0f) / select(far, Real(1.0f / kFar), inverse);
        const Real weight = Real(1.0f) / detail::inverse_weight<kOrder, Real>(r, tail, z0, h);
        all = all + weight;
        front = front + select(is_front, weight, Real(0.0f));
    }
    return front / all;
}

}  // namespace ropsim
