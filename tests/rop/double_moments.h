// Sharp bounds on the share of a distribution in front of a depth, from its moments, in double precision and
// by plain linear algebra: Gaussian elimination, roots by bisection, weights from a Vandermonde system.
// Nothing of rop/visibility/.
#pragma once

#include <cmath>
#include <complex>
#include <cstddef>
#include <vector>

namespace ropsim::test {

template <class T>
std::vector<T> solved(std::vector<std::vector<T>> m, std::vector<T> right) {
    const std::size_t n = right.size();
    for (std::size_t i = 0; i < n; ++i) {
        std::size_t pivot = i;
        for (std::size_t row = i + 1; row < n; ++row)
            if (std::abs(m[row][i]) > std::abs(m[pivot][i])) pivot = row;
        std::swap(m[i], m[pivot]);
        std::swap(right[i], right[pivot]);
        for (std::size_t row = i + 1; row < n; ++row) {
            const T factor = m[row][i] / m[i][i];
            for (std::size_t k = i; k < n; ++k) m[row][k] -= factor * m[i][k];
            right[row] -= factor * right[i];
        }
    }
    for (std::size_t i = n; i-- > 0;) {
        for (std::size_t k = i + 1; k < n; ++k) right[i] -= m[i][k] * right[k];
        right[i] /= m[i][i];
    }
    return right;
}

// Where f changes its sign between `low` and `high`, on a grid of `cells` finer than any two roots are close.
template <class F>
std::vector<double> sign_changes(F f, double low, double high, int cells) {
    std::vector<double> roots;
    double left = low;
    double at_left = f(left);
    for (int i = 1; i <= cells; ++i) {
        const double right = low + (high - low) * i / cells;
        const double at_right = f(right);
        if ((at_left < 0) != (at_right < 0)) {
            double a = left;
            double b = right;
            for (int step = 0; step < 80; ++step) {
                const double middle = 0.5 * (a + b);
                ((f(middle) < 0) == (at_left < 0) ? a : b) = middle;
            }
            roots.push_back(0.5 * (a + b));
        }
        left = right;
        at_left = at_right;
    }
    return roots;
}

struct Atom {
    double place;
    double weight;
};

// b_0 to b_{2 order} of the atoms' powers.
inline std::vector<double> power_moments(const std::vector<Atom>& atoms, int order) {
    std::vector<double> b(static_cast<std::size_t>(2 * order) + 1, 0.0);
    for (const Atom& atom : atoms)
        for (std::size_t k = 0; k < b.size(); ++k)
            b[k] += atom.weight * std::pow(atom.place, static_cast<double>(k));
    return b;
}

// The distribution with these moments whose support has order + 1 points, one of them z0; z0 comes first.
// Empty where the search for the others failed: two of them closer than a cell.
inline std::vector<Atom> power_support(const std::vector<double>& b, int order, double z0) {
    const auto n = static_cast<std::size_t>(order) + 1;
    std::vector<std::vector<double>> hankel(n, std::vector<double>(n));
    std::vector<double> powers(n);
    for (std::size_t i = 0; i < n; ++i) {
        powers[i] = std::pow(z0, static_cast<double>(i));
        for (std::size_t j = 0; j < n; ++j) hankel[i][j] = b[i + j];
    }
    const std::vector<double> c = solved(hankel, powers);
    // In s = 1 / (z - z0) every root is finite; s = tan covers the line.
    const auto at = [&](double angle) {
        double value = 0;
        for (std::size_t i = n; i-- > 0;)
            value += c[i] * std::pow(z0 * std::sin(angle) + std::cos(angle), static_cast<double>(i)) *
                     std::pow(std::sin(angle), static_cast<double>(n - 1 - i));
        return value;
    };
    constexpr double kHalfTurn = 1.5707963267948966;
    std::vector<Atom> support = {{z0, 0}};
    for (const double angle : sign_changes(at, -kHalfTurn, kHalfTurn, 20000))
        support.push_back({z0 + std::cos(angle) / std::sin(angle), 0});
    if (support.size() != n) return {};
    std::vector<std::vector<double>> vandermonde(n, std::vector<double>(n));
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
            vandermonde[i][j] = std::pow(support[j].place, static_cast<double>(i));
    const std::vector<double> w = solved(vandermonde, std::vector<double>(b.begin(), b.begin() + order + 1));
    for (std::size_t j = 0; j < n; ++j) support[j].weight = w[j];
    return support;
}

using Phasor = std::complex<double>;

// b_0 to b_order of the atoms' points on the circle, places in turns.
inline std::vector<Phasor> circle_moments(const std::vector<Atom>& atoms, int order) {
    std::vector<Phasor> b(static_cast<std::size_t>(order) + 1, Phasor(0));
    for (const Atom& atom : atoms)
        for (std::size_t k = 0; k < b.size(); ++k)
            b[k] += std::polar(atom.weight, 6.283185307179586 * atom.place * static_cast<double>(k));
    return b;
}

// The same on the circle, places in turns in [0, 1).
inline std::vector<Atom> circle_support(const std::vector<Phasor>& b, int order, double place) {
    const auto n = static_cast<std::size_t>(order) + 1;
    constexpr double kTurn = 6.283185307179586;
    std::vector<std::vector<Phasor>> toeplitz(n, std::vector<Phasor>(n));
    std::vector<Phasor> powers(n);
    for (std::size_t i = 0; i < n; ++i) {
        powers[i] = std::polar(1.0, -kTurn * place * static_cast<double>(i));
        for (std::size_t j = 0; j < n; ++j) toeplitz[i][j] = i >= j ? std::conj(b[i - j]) : b[j - i];
    }
    // Sum of c_j z^j times a half-integer power of z is real on the circle.
    const std::vector<Phasor> c = solved(toeplitz, powers);
    const auto at = [&](double turns) {
        Phasor value = 0;
        for (std::size_t j = 0; j < n; ++j)
            value +=
                c[j] *
                std::polar(1.0, kTurn * (turns * static_cast<double>(j) - 0.5 * order * (turns - place)));
        return value.real();
    };
    std::vector<Atom> support = {{place, 0}};
    for (const double turns : sign_changes(at, place, place + 1, 20000))
        support.push_back({turns - std::floor(turns), 0});
    if (support.size() != n) return {};
    std::vector<std::vector<Phasor>> vandermonde(n, std::vector<Phasor>(n));
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j < n; ++j)
            vandermonde[i][j] = std::polar(1.0, kTurn * support[j].place * static_cast<double>(i));
    const std::vector<Phasor> w = solved(vandermonde, b);
    for (std::size_t j = 0; j < n; ++j) support[j].weight = w[j].real();
    return support;
}

}  // namespace ropsim::test
