// Figure 10 of Salvi et al. 2011 drawn again: bytes over fragments a pixel, with and without 4 spatial
// samples, by the paper's model and on the pins.
#pragma once

#include "analysis/claims/claims.h"
#include "analysis/claims/runs.h"

#include <array>
#include <cstddef>
#include <vector>

namespace ropsim::adaptive_figure {

// Its curves: VRB, AT8, ST16.
inline constexpr std::size_t kCurves = 3;
inline constexpr std::array<int, 2> kSamples{1, 4};

struct Point {
    int layers = 0;
    double fragments = 0;  // a pixel, and so the rest
    double model = 0, touched = 0, pins = 0;
};
using Figure = std::array<std::array<std::vector<Point>, kCurves>, kSamples.size()>;

// Bytes of a fragment when nothing is cached, as declared.
double model_bytes(std::size_t curve, int spatial_samples);

Figure figure_of(ClaimRuns& runs);
ClaimTable table_of(const Figure& figure);
ClaimPlot plot_of(const Figure& figure);

}  // namespace ropsim::adaptive_figure
