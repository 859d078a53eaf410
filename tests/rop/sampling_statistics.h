// Limits for the statistical tests of rop/sampling/.
#pragma once

#include <cmath>
#include <map>

namespace ropsim::test {

// A chi-square of `freedom` degrees of freedom exceeds this with probability 1e-6 (Wilson and Hilferty's
// approximation).
inline double chi_square_limit(double freedom) {
    const double spread = 2.0 / (9.0 * freedom);
    return freedom * std::pow(1.0 - spread + 4.753 * std::sqrt(spread), 3);
}

// Of the observed counts against `outcomes` equally likely ones; an outcome not in `counts` never occurred.
template <class Key>
double chi_square(const std::map<Key, int>& counts, double outcomes) {
    double total = 0;
    for (const auto& [key, count] : counts) total += count;
    const double expected = total / outcomes;
    double sum = expected * (outcomes - static_cast<double>(counts.size()));
    for (const auto& [key, count] : counts) sum += (count - expected) * (count - expected) / expected;
    return sum;
}

}  // namespace ropsim::test
