// Powers, logarithms, exponentials, sines and roots from IEEE additions, multiplications, divisions and roots
// alone: the same bits on every machine. The C library picks another code path on processors with fused
// multiply-add, so its last bit is no basis for results that must be reproducible.
#pragma once

#include "rop/datapath.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace ropsim {

namespace detail {
// 1/n for Horner's rule, so that no division stands in its chain.
template <std::size_t kTerms>
constexpr std::array<double, kTerms> reciprocals(int first, int step) {
    std::array<double, kTerms> values{};
    for (std::size_t i = 0; i < kTerms; ++i) values[i] = 1.0 / (first + step * static_cast<int>(i));
    return values;
}
}  // namespace detail

// x finite, > 0, not subnormal. Absolute error below 1e-14.
inline double deterministic_log2(double x) {
    // x = 2^exponent * m with m in [sqrt(1/2), sqrt(2)).
    const auto bits = std::bit_cast<std::uint64_t>(x);
    auto exponent = static_cast<std::int64_t>(bits >> 52) - 1023;
    double m = std::bit_cast<double>((bits & 0xFFFFFFFFFFFFFull) | 0x3FF0000000000000ull);
    if (m > 1.4142135623730951) {
        m *= 0.5;
        exponent += 1;
    }
    // ln m = 2 atanh(s), s = (m - 1) / (m + 1), |s| < 0.172.
    const double s = (m - 1.0) / (m + 1.0);
    const double s2 = s * s;
    static constexpr auto kOdd = detail::reciprocals<11>(1, 2);
    double series = kOdd[10];
    for (int i = 9; i >= 0; --i) series = series * s2 + kOdd[static_cast<std::size_t>(i)];
    constexpr double kLog2E = 1.4426950408889634;
    return static_cast<double>(exponent) + 2.0 * kLog2E * s * series;
}

// 2^t for |t| < 1022. Relative error below 1e-14.
inline double deterministic_exp2(double t) {
    const double whole = std::floor(t + 0.5);
    const double u = (t - whole) * 0.6931471805599453;
    static constexpr auto kInverse = detail::reciprocals<14>(1, 1);
    double e = 1.0;
    for (int n = 13; n >= 0; --n) e = 1.0 + e * u * kInverse[static_cast<std::size_t>(n)];
    const double scale =
        std::bit_cast<double>(static_cast<std::uint64_t>(static_cast<std::int64_t>(whole) + 1023) << 52);
    return e * scale;
}

// 20 log10(ratio) of a ratio >= 0, for figures in decibels.
inline double decibels(double ratio) {
    if (ratio == 0) return -std::numeric_limits<double>::infinity();
    return std::isfinite(ratio) ? 6.020599913279624 * deterministic_log2(ratio) : ratio;
}

// x finite, >= 0, not subnormal; y finite, with x^y in the range of normal doubles. Relative error below
// 1e-13 for |y log2 x| < 64. 0^y is 0 for y > 0 and 1 for y = 0.
inline double deterministic_power(double x, double y) {
    if (x == 0.0) return y == 0.0 ? 1.0 : 0.0;
    return deterministic_exp2(y * deterministic_log2(x));
}

// Sine and cosine of an angle in turns (1 is the whole circle), |turns| < 2^31. Absolute error below 1e-14.
struct SineCosine {
    double sine;
    double cosine;
};
inline SineCosine deterministic_sine_cosine(double turns) {
    // turns = quarter / 4 + rest, |rest| <= 1/8.
    const double quarter = std::floor(4.0 * turns + 0.5);
    const double x = (turns - 0.25 * quarter) * 6.283185307179586;
    const double x2 = x * x;
    static constexpr auto kInverse = detail::reciprocals<17>(1, 1);
    double sine = 1.0;
    double cosine = 1.0;
    for (std::size_t n = 8; n >= 1; --n) {
        sine = 1.0 - sine * x2 * (kInverse[2 * n - 1] * kInverse[2 * n]);
        cosine = 1.0 - cosine * x2 * (kInverse[2 * n - 2] * kInverse[2 * n - 1]);
    }
    sine *= x;
    // No number has no quarter, and goes through as such.
    switch (std::isfinite(quarter) ? static_cast<std::int64_t>(quarter) & 3 : 0) {
        case 0:
            return {sine, cosine};
        case 1:
            return {cosine, -sine};
        case 2:
            return {-sine, -cosine};
        default:
            return {-cosine, sine};
    }
}

// The angle of the point (x, y) in turns, in [-1/2, 1/2]; 0 at the origin. Finite arguments; absolute error
// below 1e-15.
inline double deterministic_angle(double y, double x) {
    const double across = std::abs(x);
    const double up = std::abs(y);
    if (across == 0.0 && up == 0.0) return 0.0;
    const bool steep = up > across;
    const double slope = steep ? across / up : up / across;  // in [0, 1]
    // Half the angle twice: the argument of the series is below tan(pi / 16) < 0.2.
    const double half = slope / (1.0 + std::sqrt(1.0 + slope * slope));
    const double t = half / (1.0 + std::sqrt(1.0 + half * half));
    const double t2 = t * t;
    static constexpr auto kOdd = detail::reciprocals<12>(1, 2);
    double series = kOdd[11];
    for (int i = 10; i >= 0; --i) series = kOdd[static_cast<std::size_t>(i)] - series * t2;
    double turns = 4.0 * t * series * 0.15915494309189535;
    if (steep) turns = 0.25 - turns;
    if (x < 0.0) turns = 0.5 - turns;
    return y < 0.0 ? -turns : turns;
}

// The functions of a GPU's special function unit, on either datapath: exact to the last bit of a float but
// for one case in 2^20, which hardware is not.

// ln x; -inf at 0 and below, inf at inf, NaN at NaN.
inline float natural_log(float x) {
    if (!(x > 0.0f)) return std::isnan(x) ? x : -std::numeric_limits<float>::infinity();
    if (std::isinf(x)) return x;
    return static_cast<float>(0.6931471805599453 * deterministic_log2(static_cast<double>(x)));
}
// e^x; 0 below -104, inf above 89, NaN at NaN.
inline float exponential(float x) {
    if (x < -104.0f) return 0.0f;
    if (x > 89.0f) return std::numeric_limits<float>::infinity();
    if (std::isnan(x)) return x;
    return static_cast<float>(deterministic_exp2(1.4426950408889634 * static_cast<double>(x)));
}
// Of an angle in turns.
inline float sine(float turns) {
    return static_cast<float>(deterministic_sine_cosine(static_cast<double>(turns)).sine);
}
inline float cosine(float turns) {
    return static_cast<float>(deterministic_sine_cosine(static_cast<double>(turns)).cosine);
}
// 0 of anything that is not above 0.
inline float square_root(float x) {
    return x > 0.0f ? std::sqrt(x) : 0.0f;
}
// The cosine of a third of the angle, in [0, pi], whose cosine is x in [-1, 1]: from 1/2 to 1. It solves
// cubic equations with three real roots. As a function of the cosine of half the angle it is smooth, so
// hardware takes a root and a table of its special function unit.
inline float third_angle_cosine(float x) {
    const double half = std::sqrt(0.5 * (1.0 + static_cast<double>(x)));
    // (2 c - 1) sqrt((1 + c) / 2) = half by Newton's method; the start is within 0.003.
    double c = 0.5 + half * (0.57735 - 0.07735 * half);
    for (int i = 0; i < 3; ++i) {
        const double root = std::sqrt(0.5 * (1.0 + c));
        const double twice = 2.0 * c - 1.0;
        c -= (twice * root - half) / (2.0 * root + 0.25 * twice / root);
    }
    return static_cast<float>(c);
}
// The angle of the point (x, y) in turns; NaN if either is.
inline float angle(float y, float x) {
    if (!std::isfinite(x) || !std::isfinite(y)) return std::numeric_limits<float>::quiet_NaN();
    return static_cast<float>(deterministic_angle(static_cast<double>(y), static_cast<double>(x)));
}

namespace detail {
inline Wire<float> transcendental(float value, const Wire<float>& x) {
    return {value, Ledger::active().charge(Unit::kTranscendental, x.ready)};
}
}  // namespace detail

inline Wire<float> natural_log(const Wire<float>& x) {
    return detail::transcendental(natural_log(x.value), x);
}
inline Wire<float> exponential(const Wire<float>& x) {
    return detail::transcendental(exponential(x.value), x);
}
inline Wire<float> sine(const Wire<float>& turns) {
    return detail::transcendental(sine(turns.value), turns);
}
inline Wire<float> cosine(const Wire<float>& turns) {
    return detail::transcendental(cosine(turns.value), turns);
}
inline Wire<float> square_root(const Wire<float>& x) {
    return detail::transcendental(square_root(x.value), x);
}
// A quotient and a table.
inline Wire<float> angle(const Wire<float>& y, const Wire<float>& x) {
    const Wire<float> quotient = y / x;
    return detail::transcendental(angle(y.value, x.value), quotient);
}
inline Wire<float> third_angle_cosine(const Wire<float>& x) {
    return detail::transcendental(third_angle_cosine(x.value), detail::transcendental(x.value, x));
}

}  // namespace ropsim
