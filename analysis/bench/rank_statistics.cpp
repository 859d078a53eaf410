// Order statistics and exact distributions of ranks.
#include "analysis/bench/rank_statistics.h"

#include "base/error.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ropsim {
namespace {

double median_of(const std::vector<double>& ascending) {
    const std::size_t half = ascending.size() / 2;
    return ascending.size() % 2 == 1 ? ascending[half] : (ascending[half - 1] + ascending[half]) / 2;
}

// What lies between the k-th value from below and the k-th from above, k from 1.
RankInterval between(const std::vector<double>& ascending, std::size_t k, double confidence) {
    return {median_of(ascending), ascending[k - 1], ascending[ascending.size() - k], confidence};
}

}  // namespace

RankInterval median_interval(std::vector<double> values, double confidence) {
    CHECK(!values.empty());
    std::sort(values.begin(), values.end());
    const auto n = static_cast<double>(values.size());
    // P(k - 1 of the values or fewer lie below the median), k from 1.
    double outside = std::exp2(-n);
    double term = outside;
    std::size_t k = 1;
    while (2 * (k + 1) <= values.size()) {
        term *= (n - static_cast<double>(k) + 1) / static_cast<double>(k);
        if (1 - 2 * (outside + term) < confidence) break;
        outside += term;
        ++k;
    }
    return between(values, k, std::max(0.0, 1 - 2 * outside));
}

std::vector<double> rank_sum_counts(std::size_t n, std::size_t m) {
    // The largest of all is of the first kind, above m of the second, or of the second.
    std::vector<std::vector<double>> row(m + 1);  // of one n, by m
    for (auto& counts : row) counts = {1};
    for (std::size_t i = 1; i <= n; ++i) {
        for (std::size_t j = 1; j <= m; ++j) {
            std::vector<double> counts(i * j + 1, 0.0);
            for (std::size_t u = 0; u < row[j].size(); ++u) counts[u + j] += row[j][u];
            for (std::size_t u = 0; u < row[j - 1].size(); ++u) counts[u] += row[j - 1][u];
            row[j] = std::move(counts);
        }
    }
    return row[m];
}

std::optional<RankInterval> shift_interval(const std::vector<double>& earlier,
                                           const std::vector<double>& later, double confidence) {
    if (earlier.empty() || later.empty()) return {};
    const std::vector<double> counts = rank_sum_counts(earlier.size(), later.size());
    const double all = std::accumulate(counts.begin(), counts.end(), 0.0);
    double outside = counts[0];
    if (1 - 2 * outside / all < confidence) return {};
    std::size_t k = 1;
    while (2 * (k + 1) <= earlier.size() * later.size() && 1 - 2 * (outside + counts[k]) / all >= confidence)
        outside += counts[k++];
    std::vector<double> differences;
    for (const double a : earlier)
        for (const double b : later) differences.push_back(b - a);
    std::sort(differences.begin(), differences.end());
    return between(differences, k, 1 - 2 * outside / all);
}

}  // namespace ropsim
