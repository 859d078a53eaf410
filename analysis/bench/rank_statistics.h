// Intervals that take nothing about noise for granted but that it is independent: by ranks, exact for any
// number of values.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace ropsim {

struct RankInterval {
    double estimate = 0;  // the median
    double low = 0, high = 0;
    double confidence = 0;  // that the interval holds the truth: of ranks, so in steps
};

// Of values, at least one (CHECK): their median, and between which two of them in ascending order the median
// of their distribution lies (a count of values below it is binomial). The narrowest such interval of at
// least `confidence`; of few values, whose extremes reach less, from the least to the largest.
RankInterval median_interval(std::vector<double> values, double confidence = 0.95);

// Of how much `later` lies above `earlier`, unpaired: the median of all differences (Hodges and Lehmann
// 1963), and the interval of shifts that the rank-sum test (Mann and Whitney 1947) does not refuse. Absent
// where there are too few values for `confidence`.
std::optional<RankInterval> shift_interval(const std::vector<double>& earlier,
                                           const std::vector<double>& later, double confidence);

// In how many of all orders of n and m values Mann and Whitney's U, the pairs with the first value above
// the second, is u; by u from 0 to n m.
std::vector<double> rank_sum_counts(std::size_t n, std::size_t m);

}  // namespace ropsim
