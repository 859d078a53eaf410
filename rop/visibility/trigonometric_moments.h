// Visibility from trigonometric moments b_k = sum of A e^(i k phi): Muenstermann et al. 2018.
// Depth -1 to 1 runs once round the circle but for a wrapping zone, so that the far end does not meet the
// near one.
//
// The same numbers as the paper's shaders by another way. They factor the Toeplitz matrix and find complex
// roots of a complex polynomial. Turned so that the fragment lies at angle 0, and with t = cot(angle / 2) for
// the rest of the circle, the polynomial is real with real roots and a leading coefficient that is never 0:
// the solvers of power moments do, and no root has to be kept on the circle. Polynomials come from Szego's
// recurrence, weights are reciprocals of sums of squares.
#pragma once

#include "rop/visibility/power_moments.h"

#include <array>
#include <cstddef>

namespace ropsim {

template <class Real>
struct Complex {
    Real re;
    Real im;
};
template <class Real>
Complex<Real> operator+(const Complex<Real>& a, const Complex<Real>& b) {
    return {a.re + b.re, a.im + b.im};
}
template <class Real>
Complex<Real> operator-(const Complex<Real>& a, const Complex<Real>& b) {
    return {a.re - b.re, a.im - b.im};
}
template <class Real>
Complex<Real> operator*(const Complex<Real>& a, const Complex<Real>& b) {
    return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
template <class Real>
Complex<Real> scaled(const Complex<Real>& a, const Real& factor) {
    return {a.re * factor, a.im * factor};
}
template <class Real>
Complex<Real> conjugate(const Complex<Real>& a) {
    return {a.re, negative(a.im)};
}
template <class Real>
Real squared_magnitude(const Complex<Real>& a) {
    return a.re * a.re + a.im * a.im;
}

template <int kOrder, class Real>
using TrigonometricMoments = std::array<Complex<Real>, kOrder>;  // b_1 / b_0, b_2 / b_0, ...

inline constexpr float kWrappingZone = 0.05f;  // of the circle

// The point on the circle for a depth in [-1, 1].
template <class Real>
Complex<Real> circle_point(const Real& z) {
    const Real turns = (z + Real(1.0f)) * Real(0.5f - 0.5f * kWrappingZone);
    return {cosine(turns), sine(turns)};
}

// Grows with the angle from -1 at 0 to 7 at a whole turn, without a transcendental function: the paper's.
template <class Real>
Real circle_parameter(const Complex<Real>& point) {
    const Real first = magnitude(point.im) - magnitude(point.re);
    const Real half = select(point.re < Real(0.0f), Real(2.0f) - first, first);
    return select(point.im < Real(0.0f), Real(6.0f) - half, half);
}

namespace detail {
// Szego's recurrence: p_{k+1}(z) = z p_k(z) - step_k q_k(z), q_{k+1}(z) = q_k(z) - conj(step_k) z p_k(z), and
// the ratio of the norms of p_{k+1} and p_k.
template <int kOrder, class Real>
struct CircleRecurrence {
    std::array<Complex<Real>, kOrder> step;
    std::array<Real, kOrder> norm;
};

template <int kOrder, class Real>
struct CirclePolynomials {
    CircleRecurrence<kOrder, Real> recurrence;
    // Coefficients of p_0 to p_order, lowest power first.
    std::array<std::array<Complex<Real>, kOrder + 1>, kOrder + 1> p;
};

template <int kOrder, class Real>
CirclePolynomials<kOrder, Real> circle_polynomials(const TrigonometricMoments<kOrder, Real>& b) {
    CirclePolynomials<kOrder, Real> result;
    auto& p = result.p;
    p[0][0] = {Real(1.0f), Real(0.0f)};
    Real whole = Real(1.0f);  // norm of p_k
    decltype(whole < whole) concentrated = false;
    for (std::size_t k = 0; k < kOrder; ++k) {
        Complex<Real> sum = k == 0 ? b[0] : p[k][0] * b[0];
        for (std::size_t j = 1; j <= k; ++j) sum = sum + (j == k ? b[j] : p[k][j] * b[j]);
        Complex<Real> step = k == 0 ? sum : scaled(sum, Real(1.0f) / whole);
        if (k > 0)
            step = {select(concentrated, Real(0.0f), step.re), select(concentrated, Real(0.0f), step.im)};
        const Real left = Real(1.0f) - squared_magnitude(step);
        result.recurrence.step[k] = step;
        result.recurrence.norm[k] = maximum(left, Real(kMomentNoise));
        whole = k == 0 ? result.recurrence.norm[k] : whole * result.recurrence.norm[k];
        const auto noisy = whole < Real(8.0f * kMomentNoise);
        concentrated = k == 0 ? noisy : either(concentrated, noisy);
        // The leading coefficient stays 1; q_k has the conjugates in reverse.
        for (std::size_t j = 0; j <= k; ++j) {
            const Complex<Real> change = j == 0 ? step : step * conjugate(p[k][k - j]);
            p[k + 1][j] =
                j == 0 ? Complex<Real>{negative(change.re), negative(change.im)} : p[k][j - 1] - change;
        }
        p[k + 1][k + 1] = {Real(1.0f), Real(0.0f)};
    }
    return result;
}

// Sum of |p_k|^2 times the norms behind k at the point of the circle.
template <int kOrder, class Real>
Real inverse_weight(const CircleRecurrence<kOrder, Real>& r, const std::array<Real, kOrder>& tail,
                    const Complex<Real>& point) {
    Complex<Real> p = {Real(1.0f), Real(0.0f)};
    Complex<Real> q = p;
    Real sum = tail[0];
    for (std::size_t k = 0; k < kOrder; ++k) {
        const Complex<Real> moved = k == 0 ? point : point * p;
        const Complex<Real> next = moved - (k == 0 ? r.step[k] : r.step[k] * q);
        q = q - conjugate(r.step[k]) * moved;
        p = next;
        const Real square = squared_magnitude(p);
        sum = sum + (k + 1 == kOrder ? square : square * tail[k + 1]);
    }
    return sum;
}

// From coefficients c_j of z^j, c_{n-j} the conjugate of c_j, to those of the real polynomial in t by falling
// power: z = (t + i) / (t - i).
template <class Real>
std::array<Real, 3> on_the_line(const std::array<Complex<Real>, 3>& c) {
    const Real x0 = c[0].re + c[2].re;
    const Real y0 = c[0].im - c[2].im;
    return {x0 + c[1].re, y0 + y0, c[1].re - x0};
}
template <class Real>
std::array<Real, 4> on_the_line(const std::array<Complex<Real>, 4>& c) {
    const Real x0 = c[0].re + c[3].re;
    const Real y0 = c[0].im - c[3].im;
    const Real x1 = c[1].re + c[2].re;
    const Real y1 = c[1].im - c[2].im;
    return {x0 + x1, Real(3.0f) * y0 + y1, x1 - Real(3.0f) * x0, y1 - y0};
}
template <class Real>
std::array<Real, 5> on_the_line(const std::array<Complex<Real>, 5>& c) {
    const Real x0 = c[0].re + c[4].re;
    const Real y0 = c[0].im - c[4].im;
    const Real x1 = c[1].re + c[3].re;
    const Real y1 = c[1].im - c[3].im;
    const Real x2 = c[2].re;
    return {(x0 + x1) + x2, Real(4.0f) * y0 + (y1 + y1), (x2 + x2) - Real(6.0f) * x0,
            (y1 + y1) - Real(4.0f) * y0, (x0 - x1) + x2};
}

// How much of a point of support counts as in front of the fragment: all of it if it comes before on the way
// round, and in the wrapping zone, behind the far end and before the near one, a share that rises from 0
// to 1.
template <class Real>
Real share_of_point(const Complex<Real>& point, const Real& fragment_parameter) {
    // The zone begins at an angle of 2 pi less the zone, in the quarter where the parameter is 6 + sin + cos.
    constexpr double kBegin = 6.0 - 0.30901699437494742 + 0.95105651629515357;
    constexpr auto kSlope = static_cast<float>(1.0 / (7.0 - kBegin));
    constexpr auto kOffset = static_cast<float>(1.0 - 7.0 / (7.0 - kBegin));
    const Real parameter = circle_parameter(point);
    const Real ramp = minimum(maximum(parameter * Real(kSlope) + Real(kOffset), Real(0.0f)), Real(1.0f));
    return select(parameter < fragment_parameter, Real(1.0f), ramp);
}
}  // namespace detail

// The share of all absorbance that is in front of depth z0 in [-1, 1]; in [0, 1], whatever the moments are.
template <int kOrder, class Real>
Real share_in_front(const MomentBias& bias, const TrigonometricMoments<kOrder, Real>& moments,
                    const Real& z0) {
    const std::size_t n = kOrder;
    const Complex<Real> place = circle_point(z0);
    const Complex<Real> back = conjugate(place);
    TrigonometricMoments<kOrder, Real> b;
    Complex<Real> turn = back;
    for (std::size_t k = 0; k < n; ++k) {
        b[k] = moments[k] * scaled(turn, Real(1.0f - bias.weight));
        if (k + 1 < n) turn = turn * back;
    }
    const auto polynomials = detail::circle_polynomials<kOrder, Real>(b);
    const auto& norm = polynomials.recurrence.norm;
    std::array<Real, n> tail;  // the product of the norms from k on
    tail[n - 1] = norm[n - 1];
    for (std::size_t k = n - 1; k > 0; --k) tail[k - 1] = norm[k - 1] * tail[k];
    std::array<Complex<Real>, n + 1> c;
    c[0] = {tail[0], Real(0.0f)};
    for (std::size_t k = 1; k <= n; ++k) {
        Complex<Real> at_place = polynomials.p[k][0];
        for (std::size_t j = 1; j <= k; ++j) at_place = at_place + polynomials.p[k][j];
        const Complex<Real> factor = k == n ? conjugate(at_place) : scaled(conjugate(at_place), tail[k]);
        for (std::size_t j = 0; j < k; ++j) c[j] = c[j] + factor * polynomials.p[k][j];
        c[k] = factor;
    }
    const auto t = detail::on_the_line(c);
    const Real own = Real(1.0f) / t[0];
    const std::array<Real, n> roots = detail::inverse_distances(t, own);
    const Real parameter = circle_parameter(place);
    Real front = Real(bias.overestimation) * own;
    Real all = own;
    for (const Real& root : roots) {
        const Real square = root * root;
        const Real inverse = Real(1.0f) / (square + Real(1.0f));
        const Complex<Real> point = {(square - Real(1.0f)) * inverse, (root + root) * inverse};
        const Real weight =
            Real(1.0f) / detail::inverse_weight<kOrder, Real>(polynomials.recurrence, tail, point);
        all = all + weight;
        front = front + weight * detail::share_of_point<Real>(point * place, parameter);
    }
    return front / all;
}

}  // namespace ropsim
