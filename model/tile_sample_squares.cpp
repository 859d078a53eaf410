#include "model/tile_sample_squares.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ropsim {

SampleSquares::SampleSquares(const SurfaceMap& map, const TraceReader& trace, std::uint32_t square_tiles,
                             const std::vector<int>& sampled)
    : partition_fragments_(static_cast<std::size_t>(map.partitions())),
      partition_tiles_(partition_fragments_.size()),
      sample_size_(sampled.size()) {
    const auto across = static_cast<std::size_t>(tiles_across(trace.header().width));
    const std::size_t squares_across = (across + square_tiles - 1) / square_tiles;
    const std::vector<std::uint64_t>& counts = trace.tile_fragments();
    for (std::size_t tile = 0; tile < counts.size(); ++tile) {
        const std::size_t square =
            tile / across / square_tiles * squares_across + tile % across / square_tiles;
        square_of_.push_back(square);
        if (square >= fragments_.size()) {
            fragments_.resize(square + 1);
            tiles_.resize(square + 1);
            sampled_.resize(square + 1);
        }
        const int partition = map.partition_of(tile);
        const auto p = static_cast<std::size_t>(partition);
        const auto fragments = static_cast<double>(counts[tile]);
        fragments_[square] += fragments;
        tiles_[square] += counts[tile] > 0 ? 1 : 0;
        partition_fragments_[p] += fragments;
        partition_tiles_[p] += counts[tile] > 0 ? 1 : 0;
        all_fragments_ += fragments;
        if (std::ranges::find(sampled, partition) == sampled.end()) continue;
        sampled_[square] = 1;
        sample_fragments_ += fragments;
    }
    find_neighbours(squares_across);
}

void SampleSquares::find_neighbours(std::size_t squares_across) {
    for (std::size_t s = 0; s < size(); ++s)
        if (sampled(s) && fragments_[s] > 0) used_.push_back(s);
    for (std::size_t i = 0; i < used_.size(); ++i) {
        std::vector<std::pair<std::size_t, std::size_t>> others;  // squared distance, and which
        for (std::size_t j = 0; j < used_.size(); ++j) {
            if (i == j) continue;
            const auto apart = [](std::size_t a, std::size_t b) { return a > b ? a - b : b - a; };
            const std::size_t x = apart(used_[i] % squares_across, used_[j] % squares_across);
            const std::size_t y = apart(used_[i] / squares_across, used_[j] / squares_across);
            others.emplace_back(x * x + y * y, j);
        }
        const std::size_t count = std::min(kNeighbours, others.size());
        std::ranges::partial_sort(others, others.begin() + static_cast<std::ptrdiff_t>(count));
        std::array<std::size_t, kNeighbours>& near = near_.emplace_back();
        near.fill(i);
        for (std::size_t n = 0; n < count; ++n) near[n] = others[n].second;
    }
}

SampleSquares::Fit SampleSquares::fit(const std::vector<double>& values) const {
    double nn = 0, nm = 0, mm = 0, ny = 0, my = 0;
    for (const std::size_t s : used_) {
        const double n = fragments_[s];
        nn += n;
        nm += tiles_[s];
        mm += tiles_[s] * tiles_[s] / n;
        ny += values[s];
        my += tiles_[s] * values[s] / n;
    }
    Fit fit;
    if (nn == 0) return fit;
    const double determinant = nn * mm - nm * nm;
    const bool both = used_.size() > 8 && determinant > 1e-9 * nn * mm;
    fit.per_fragment = both ? (ny * mm - my * nm) / determinant : ny / nn;
    fit.per_tile = both ? (nn * my - nm * ny) / determinant : 0;
    std::vector<double> residual;
    for (const std::size_t s : used_)
        residual.push_back(values[s] - fit.per_fragment * fragments_[s] - fit.per_tile * tiles_[s]);
    double second = 0, fourth = 0;
    for (std::size_t i = 0; i < used_.size(); ++i) {
        const double n = fragments_[used_[i]];
        double near_residual = 0, near_fragments = 0;
        for (const std::size_t j : near_[i]) {
            if (j == i) continue;
            near_residual += residual[j];
            near_fragments += fragments_[used_[j]];
        }
        if (near_fragments == 0) continue;
        // Residuals' variances grow as the fragments: that of the difference is larger than a square's own.
        const double d = residual[i] - near_residual / near_fragments * n;
        const double own = d * d / (1 + n / near_fragments);
        second += own;
        fourth += own * own;
    }
    fit.variance = second / sampled_partitions();
    fit.degrees = fourth > 0 ? second * second / fourth : static_cast<double>(used_.size());
    return fit;
}

double SampleSquares::expanded(double variance) const {
    const double all = partitions();
    return variance * all * (all - sampled_partitions()) / sampled_partitions();
}

Estimate SampleSquares::total(const std::vector<double>& values) const {
    const Fit f = fit(values);
    double sum = 0;
    for (int p = 0; p < partitions(); ++p) sum += predicted(f, p);
    return Estimate::with_variance(sum, expanded(f.variance), f.degrees);
}

Estimate SampleSquares::total_of_count(double counted) const {
    if (sample_fragments_ == 0) return {};
    const double share = counted / sample_fragments_;
    double squares = 0, fourth = 0;
    for (std::size_t s = 0; s < size(); ++s) {
        if (!sampled(s)) continue;
        const double square = fragments_[s] * fragments_[s];
        squares += square;
        fourth += square * square;
    }
    const double most =
        std::max(1.0, std::ceil(share));  // a fragment, as some are operated in several passes
    const double spread = share * (most - share) * squares / sampled_partitions();
    Estimate e =
        Estimate::with_variance(share * all_fragments_, expanded(spread), squares * squares / fourth);
    e.low = std::max(e.low, counted);
    return e;
}

double SampleSquares::predicted(const Fit& f, int partition) const {
    const auto p = static_cast<std::size_t>(partition);
    return f.per_fragment * partition_fragments_[p] + f.per_tile * partition_tiles_[p];
}

}  // namespace ropsim
