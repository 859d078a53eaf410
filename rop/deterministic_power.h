// x to the power y from IEEE additions, multiplications and divisions alone: the same bits on every machine.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace ropsim {

// x finite, >= 0, not subnormal; y finite, with x^y in the range of normal doubles. Relative error below
// 1e-14 for |y log2 x| < 64. 0^y is 0 for y > 0 and 1 for y = 0. The C library's pow() picks another code
// path on processors with fused multiply-add, so its last bit is no basis for results that must be
// reproducible.
inline double deterministic_power(double x, double y) {
    if (x == 0.0) return y == 0.0 ? 1.0 : 0.0;
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
    double series = 1.0 / 21.0;
    for (int odd = 19; odd >= 1; odd -= 2) series = series * s2 + 1.0 / odd;
    constexpr double kLog2E = 1.4426950408889634;
    const double t = y * (static_cast<double>(exponent) + 2.0 * kLog2E * s * series);
    const double whole = std::floor(t + 0.5);
    const double u = (t - whole) * 0.6931471805599453;
    double e = 1.0;
    for (int n = 14; n >= 1; --n) e = 1.0 + e * u / n;
    const double scale =
        std::bit_cast<double>(static_cast<std::uint64_t>(static_cast<std::int64_t>(whole) + 1023) << 52);
    return e * scale;
}

}  // namespace ropsim
