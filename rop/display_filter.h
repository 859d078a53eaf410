// Linear display filters over the samples of a pixel and its neighbours (Enderton et al. 2011, section 3.5).
#pragma once

#include "rop/declaration.h"
#include "rop/transcendental.h"
#include "traces/sample_positions.h"

#include <vector>

namespace ropsim {

// Pixels around its own that a filter reads, in each direction.
constexpr int filter_footprint(DisplayFilter filter) {
    return filter == DisplayFilter::kGaussian ? 1 : 0;
}

// Weight of a sample `dx`, `dy` pixels away from the pixel and at `position` in its own; weights of a window
// are to be divided by their sum. The 2 x 2 Gaussian is the RenderMan Interface's: exp(-2 r^2) within a
// square 2 pixels wide.
inline double filter_weight(DisplayFilter filter, int dx, int dy, SamplePosition position) {
    if (filter == DisplayFilter::kBox) return dx == 0 && dy == 0 ? 1.0 : 0.0;
    const double x = dx + static_cast<double>(position.x());
    const double y = dy + static_cast<double>(position.y());
    if (x < -1 || x > 1 || y < -1 || y > 1) return 0;
    return deterministic_power(2.718281828459045, -2 * (x * x + y * y));
}

// Normalised weights of the samples around a pixel of `spatial_samples` samples: [pixel of the window, row by
// row][sample], the window 2 * filter_footprint + 1 wide.
inline std::vector<std::vector<double>> filter_weights(DisplayFilter filter, int spatial_samples) {
    const int reach = filter_footprint(filter);
    std::vector<std::vector<double>> weights;
    double sum = 0;
    for (int dy = -reach; dy <= reach; ++dy) {
        for (int dx = -reach; dx <= reach; ++dx) {
            weights.emplace_back();
            for (const SamplePosition position : sample_positions(spatial_samples)) {
                weights.back().push_back(filter_weight(filter, dx, dy, position));
                sum += weights.back().back();
            }
        }
    }
    for (auto& pixel : weights)
        for (double& w : pixel) w /= sum;
    return weights;
}

}  // namespace ropsim
