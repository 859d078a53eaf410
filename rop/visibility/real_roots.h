// Roots of monic polynomials of degree 2, 3 and 4 whose roots are all real, in closed form with a fixed
// amount of work on either datapath. Rounding may make a pair of roots complex; its common real part is
// returned then.
//
// The published moment shaders (Muenstermann et al. 2018) solve the same equations with Vieta's, Blinn's and
// Neumark's formulas and do not guard their square roots. Here the root (or pair) of largest magnitude is
// found first and divided out, so that small roots beside a large one keep their digits.
#pragma once

#include "rop/transcendental.h"

#include <array>
#include <cstddef>

namespace ropsim {

// s^2 + b s + c = 0.
template <class Real>
std::array<Real, 2> quadratic_roots(const Real& b, const Real& c) {
    const Real half = Real(0.5f) * b;
    const Real root = square_root(half * half - c);
    const auto below = half < Real(0.0f);
    // The root of larger magnitude; the other one is the product of both over it.
    const Real larger = select(below, root - half, negative(half + root));
    const auto none = magnitude(larger) < Real(1e-30f);
    return {larger, select(none, Real(0.0f), c / select(none, Real(1.0f), larger))};
}

// The root of largest magnitude of s^3 + b s^2 + c s + d = 0.
template <class Real>
Real largest_cubic_root(const Real& b, const Real& c, const Real& d) {
    const Real third = Real(1.0f / 3.0f) * b;
    const Real third_c = Real(1.0f / 3.0f) * c;
    // With u = s + b/3: u^3 - 3 p u + 2 q = 0.
    const Real p = maximum(third * third - third_c, Real(1e-30f));
    const Real q = third * (third * third - Real(1.5f) * third_c) + Real(0.5f) * d;
    const Real root = square_root(p);
    const auto below = third < Real(0.0f);
    const Real cosine = select(below, negative(q), q) / (p * root);
    // q over p^1.5 is the cosine of thrice the angle.
    const Real bounded = maximum(minimum(cosine, Real(1.0f)), Real(-1.0f));
    const Real size = magnitude(third) + (root + root) * third_angle_cosine(bounded);
    return select(below, size, negative(size));
}

// s^3 + b s^2 + c s + d = 0.
template <class Real>
std::array<Real, 3> cubic_roots(const Real& b, const Real& c, const Real& d) {
    const Real largest = largest_cubic_root(b, c, d);
    const auto none = magnitude(largest) < Real(1e-14f);
    const Real inverse = Real(1.0f) / select(none, Real(1.0f), largest);
    const Real product = negative(d * inverse);
    const auto rest = quadratic_roots<Real>((product - c) * inverse, product);
    return {largest, rest[0], rest[1]};
}

// The root of largest magnitude of s^4 + b s^3 + c s^2 + d s + e = 0. Ferrari's way: of the three splits into
// two quadratics the one with the largest root of the resolvent sets the two smaller roots apart from the two
// larger ones.
template <class Real>
Real largest_quartic_root(const Real& b, const Real& c, const Real& d, const Real& e) {
    // With x = s + b/4: x^4 + p x^2 + q x + r = (x^2 + w x + low)(x^2 - w x + high), w^2 = 2 m.
    const Real quarter = Real(0.25f) * b;
    const Real square = quarter * quarter;
    const Real p = c - Real(6.0f) * square;
    const Real q = d - quarter * (c + c - Real(8.0f) * square);
    const Real r = (e - quarter * d) + square * (c - Real(3.0f) * square);
    const Real m = largest_cubic_root<Real>(p, Real(0.25f) * (p * p) - r, Real(-0.125f) * (q * q));
    const Real w = square_root(m + m);
    // Where -b/4 is, the larger ones are: of x^2 + 2 half x + constant the root on that side.
    const auto below = quarter < Real(0.0f);
    const Real half_difference = q / maximum(w + w, Real(1e-15f));
    const Real constant = Real(0.5f) * p + m + select(below, half_difference, negative(half_difference));
    const Real half = Real(0.5f) * w;
    const Real size = half + square_root(half * half - constant) + magnitude(quarter);
    const Real root = select(below, size, negative(size));
    // One step of Newton's method.
    const Real value = (((root + b) * root + c) * root + d) * root + e;
    const Real slope = ((Real(4.0f) * root + Real(3.0f) * b) * root + (c + c)) * root + d;
    const auto flat = magnitude(slope) < Real(1e-20f);
    const Real step = value / select(flat, Real(1.0f), slope);
    const Real bound = Real(0.125f) * size;
    return root - select(flat, Real(0.0f), maximum(minimum(step, bound), negative(bound)));
}

// s^4 + b s^3 + c s^2 + d s + e = 0.
template <class Real>
std::array<Real, 4> quartic_roots(const Real& b, const Real& c, const Real& d, const Real& e) {
    const Real largest = largest_quartic_root(b, c, d, e);
    const auto none = magnitude(largest) < Real(1e-9f);
    const Real inverse = Real(1.0f) / select(none, Real(1.0f), largest);
    const Real constant = negative(e * inverse);
    const Real linear = (constant - d) * inverse;
    const auto rest = cubic_roots<Real>((linear - c) * inverse, linear, constant);
    return {largest, rest[0], rest[1], rest[2]};
}

}  // namespace ropsim
