// A value known from a sample, with its 95 % confidence interval.
#pragma once

#include <cmath>

namespace ropsim {

struct Estimate {
    double value = 0;
    double low = 0;
    double high = 0;

    // `variance` of a sum over units of which so many (effective) degrees of freedom are behind it.
    static Estimate with_variance(double value, double variance, double degrees);
    bool covers(double truth) const { return low <= truth && truth <= high; }
};

// The 97.5 % quantile of Student's t: the Cornish-Fisher expansion about the normal one (Abramowitz and
// Stegun 26.7.5), within 1 % from 3 degrees of freedom on. Arithmetic only: the same on any machine.
constexpr double student_t_975(double degrees) {
    const double z = 1.959963984540054;
    const double z3 = z * z * z;
    const double z5 = z3 * z * z;
    const double z7 = z5 * z * z;
    const double d = degrees < 3 ? 3 : degrees;
    return z + (z3 + z) / (4 * d) + (5 * z5 + 16 * z3 + 3 * z) / (96 * d * d) +
           (3 * z7 + 19 * z5 + 17 * z3 - 15 * z) / (384 * d * d * d);
}

inline Estimate Estimate::with_variance(double value, double variance, double degrees) {
    const double half = student_t_975(degrees) * std::sqrt(variance);
    return {value, value - half, value + half};
}

}  // namespace ropsim
