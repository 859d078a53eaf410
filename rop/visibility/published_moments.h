// Visibility from power moments with the arithmetic of the paper's shaders (Muenstermann et al. 2018, their
// public MomentMath.hlsli), unguarded: a singular matrix gives NaN, and NaN saturates to 0 as in HLSL.
// power_moments.h says what it computes and has the form that cannot fail. Multiplications and additions are
// rounded apart, not fused.
#pragma once

#include "rop/visibility/power_moments.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace ropsim::published {

// As an instruction set has it: NaN of a negative number.
inline float root(float x) {
    return x < 0.0f ? std::numeric_limits<float>::quiet_NaN() : square_root(x);
}
inline Wire<float> root(const Wire<float>& x) {
    return ropsim::detail::transcendental(root(x.value), x);
}

// HLSL's saturate: NaN becomes 0.
template <class Real>
Real saturated(const Real& x) {
    return select(Real(0.0f) <= x, minimum(x, Real(1.0f)), Real(0.0f));
}

// The polynomial whose roots are the support beside z0, from the factors L D L^T of the Hankel matrix.
template <int kOrder, class Real>
std::array<Real, kOrder + 1> support_polynomial(const PowerMoments<kOrder, Real>& b, const Real& z0) {
    const std::size_t n = kOrder;
    constexpr std::size_t kTerms = kOrder + 1;
    std::array<std::array<Real, kTerms>, kTerms> lower;   // L, below the diagonal
    std::array<std::array<Real, kTerms>, kTerms> scaled;  // L D
    std::array<Real, kTerms> inverse;                     // of D
    for (std::size_t i = 1; i <= n; ++i) lower[i][0] = scaled[i][0] = b[i - 1];
    for (std::size_t j = 1; j <= n; ++j) {
        for (std::size_t i = j; i <= n; ++i) {
            scaled[i][j] = b[i + j - 1];
            for (std::size_t k = 0; k < j; ++k) scaled[i][j] = scaled[i][j] - scaled[j][k] * lower[i][k];
            if (i == j) inverse[j] = Real(1.0f) / scaled[j][j];
            if (i > j) lower[i][j] = scaled[i][j] * inverse[j];
        }
    }
    std::array<Real, kTerms> c;
    std::array<Real, kTerms> forward;
    Real power = Real(1.0f);
    forward[0] = Real(1.0f);
    for (std::size_t i = 1; i <= n; ++i) {
        power = i == 1 ? z0 : power * z0;
        Real sum = lower[i][0];
        for (std::size_t k = 1; k < i; ++k) sum = sum + lower[i][k] * forward[k];
        forward[i] = power - sum;
    }
    for (std::size_t i = 1; i <= n; ++i) c[i] = forward[i] * inverse[i];
    c[0] = Real(1.0f);
    for (std::size_t i = n; i-- > 0;)
        for (std::size_t k = n; k > i; --k) c[i] = c[i] - lower[k][i] * c[k];
    return c;
}

// x^2 + 2 half x + c.
template <class Real>
std::array<Real, 2> quadratic(const Real& half, const Real& c) {
    const Real r = root(half * half - c);
    const auto above = Real(0.0f) <= half;
    const Real larger = select(above, negative(half + r), r - half);
    return {larger, c / larger};
}

// d + c x + b x^2 + x^3, the middle coefficients already divided by three.
template <class Real>
std::array<Real, 3> cubic(const Real& d, const Real& c, const Real& b) {
    const Real first = c - b * b;
    const Real mixed = d - c * b;
    const Real last = b * d - c * c;
    const Real discriminant = Real(4.0f) * first * last - mixed * mixed;
    const Real constant = mixed - Real(2.0f) * b * first;
    const Real turns = angle(root(discriminant), negative(constant)) * Real(1.0f / 3.0f);
    const Real x = cosine(turns);
    const Real y = sine(turns) * Real(0.8660254f);
    const Real scale = Real(2.0f) * root(negative(first));
    const Real half = Real(-0.5f) * x;
    return {scale * x - b, scale * (half - y) - b, scale * (half + y) - b};
}

// Blinn's least root of the same cubic.
template <class Real>
Real least_cubic_root(const Real& d, const Real& c, const Real& b) {
    const Real first = c - b * b;
    const Real mixed = d - b * c;
    const Real last = b * d - c * c;
    const Real discriminant = Real(4.0f) * first * last - mixed * mixed;
    const Real constant = Real(2.0f) * c * last - d * mixed;
    const Real turns = magnitude(angle(d * root(discriminant), negative(constant))) * Real(1.0f / 3.0f);
    const Real x = cosine(turns);
    const Real scale = Real(2.0f) * root(negative(last));
    const Real x0 = scale * x;
    const Real x1 = scale * (Real(-0.5f) * x - Real(0.8660254f) * sine(turns));
    return negative(d) / (select(x0 + x1 < Real(2.0f) * c, x0, x1) + c);
}

// Neumark's factors: e + d x + c x^2 + b x^3 + x^4.
template <class Real>
std::array<Real, 4> quartic(const Real& e, const Real& d, const Real& c, const Real& b) {
    const Real e4 = Real(4.0f) * e;
    const Real square = b * b;
    const Real y =
        least_cubic_root<Real>(d * d + square * e - b * c * d, (c * c + b * d - e4) * Real(1.0f / 3.0f),
                               Real(-2.0f) * c * Real(1.0f / 3.0f));
    const Real y4 = Real(4.0f) * y;
    const Real z = c - y;
    const Real z2 = z * z;
    const auto by_linear = either(y < Real(0.0f), (z2 - e4) * (square + y4) < (z2 + e4) * (square - y4));
    const Real r = root(select(by_linear, square - y4, z2 - e4));
    const Real cross = (b * z - Real(2.0f) * d) / (Real(2.0f) * r);
    const Real half_b = Real(0.5f) * b;
    const Real half_z = Real(0.5f) * z;
    const Real g = select(by_linear, Real(0.5f) * r, cross);
    const Real h = select(by_linear, cross, Real(0.5f) * r);
    const auto one = quadratic<Real>(Real(0.5f) * (half_b + g), half_z + h);
    const auto other = quadratic<Real>(Real(0.5f) * (half_b - g), half_z - h);
    return {one[0], one[1], other[0], other[1]};
}

// The support beside z0, z[1] to z[order].
template <int kOrder, class Real>
void find_support(const std::array<Real, kOrder + 1>& c, std::array<Real, kOrder + 1>& z) {
    const Real inverse = Real(1.0f) / c[kOrder];
    if constexpr (kOrder == 2) {
        const Real p = c[1] * inverse;
        const Real r = root(p * p * Real(0.25f) - c[0] * inverse);
        const Real mean = Real(-0.5f) * p;
        z[1] = mean - r;
        z[2] = mean + r;
    } else if constexpr (kOrder == 3) {
        const auto roots = cubic<Real>(c[0] * inverse, c[1] * inverse * Real(1.0f / 3.0f),
                                       c[2] * inverse * Real(1.0f / 3.0f));
        for (std::size_t i = 0; i < 3; ++i) z[i + 1] = roots[i];
    } else {
        const auto roots = quartic<Real>(c[0] * inverse, c[1] * inverse, c[2] * inverse, c[3] * inverse);
        for (std::size_t i = 0; i < 4; ++i) z[i + 1] = roots[i];
    }
}

// The transmittance in front of z0 for moments normalised by `total`, the sum of all absorbance.
template <int kOrder, class Real>
Real transmittance(const MomentBias& bias, const Real& total, const PowerMoments<kOrder, Real>& moments,
                   const Real& z0) {
    const std::size_t n = kOrder;
    const PowerMoments<kOrder, Real> b = biased<kOrder, Real>(bias, moments);
    std::array<Real, n + 1> z;
    z[0] = z0;
    find_support<kOrder, Real>(support_polynomial<kOrder, Real>(b, z0), z);
    // Newton's divided differences of the weights 0 and 1.
    std::array<Real, n + 1> f;
    f[0] = Real(bias.overestimation);
    for (std::size_t i = 1; i <= n; ++i)
        f[i] = select(n == 4 ? z[i] <= z0 : z[i] < z0, Real(1.0f), Real(0.0f));
    for (std::size_t step = 1; step <= n; ++step)
        for (std::size_t i = n; i >= step; --i) f[i] = (f[i] - f[i - 1]) / (z[i] - z[i - step]);
    // The same polynomial by powers of z.
    std::array<Real, n + 1> polynomial;
    polynomial[0] = f[n];
    for (std::size_t i = n; i-- > 0;) {
        const std::size_t degree = n - i;
        polynomial[degree] = polynomial[degree - 1];
        for (std::size_t k = degree - 1; k > 0; --k) polynomial[k] = polynomial[k - 1] - polynomial[k] * z[i];
        polynomial[0] = f[i] - polynomial[0] * z[i];
    }
    Real absorbance = polynomial[1] * b[0];
    for (std::size_t k = 2; k <= n; ++k) absorbance = absorbance + polynomial[k] * b[k - 1];
    return saturated(exponential(negative(total * (polynomial[0] + absorbance))));
}

}  // namespace ropsim::published
