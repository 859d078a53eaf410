#include "analysis/ambient_blur.h"

#include "base/parallel.h"
#include "rop/transcendental.h"

#include <algorithm>
#include <cmath>

namespace ropsim {

namespace {

// Weights of taps 0 to radius: a bell whose deviation is three quarters of the radius.
std::vector<double> bell(int radius) {
    std::vector<double> weights;
    constexpr double kLog2E = 1.4426950408889634;
    for (int tap = 0; tap <= radius; ++tap) {
        const double at = tap / (0.75 * radius);
        weights.push_back(deterministic_exp2(-0.5 * at * at * kLog2E));
    }
    return weights;
}

struct BlurPass {
    const std::vector<float>& from;
    const DepthBuffer& depth;
    const AmbientView& view;
    const std::vector<double>& weights;
    int dx, dy;

    double z(int x, int y) const { return view.at_pixel(x, y, depth.stored(x, y)).z; }

    double at(int x, int y, std::uint64_t& taps) const {
        const int radius = static_cast<int>(weights.size()) - 1;
        const double here = z(x, y);
        double sum = 0, total = 0;
        for (int tap = -radius; tap <= radius; ++tap) {
            const int column = x + tap * kBlurStride * dx;
            const int row = y + tap * kBlurStride * dy;
            if (column < 0 || row < 0 || column >= depth.width || row >= depth.height) continue;
            ++taps;
            if (!depth.drawn(column, row)) continue;
            const double near = std::max(0.0, 1 - std::abs(z(column, row) - here) / kBlurMetres);
            const double weight = weights[static_cast<std::size_t>(std::abs(tap))] * near;
            sum += weight * static_cast<double>(from[depth.index(column, row)]);
            total += weight;
        }
        // At the end of an infinite view not even the pixel's own distance to itself is a number.
        return total > 0 ? sum / total : static_cast<double>(from[depth.index(x, y)]);
    }
};

}  // namespace

std::uint64_t blur_ambient(std::vector<float>& ambient, const DepthBuffer& depth, const AmbientView& view,
                           int radius, Format format, int threads) {
    if (radius == 0) return 0;
    const std::vector<double> weights = bell(radius);
    std::vector<std::uint64_t> taps(static_cast<std::size_t>(depth.height));
    for (const bool across : {true, false}) {
        std::vector<float> result(ambient.size(), 1.0f);
        const BlurPass pass{ambient, depth, view, weights, across ? 1 : 0, across ? 0 : 1};
        parallel_for(threads, depth.height, [&](int y) {
            for (int x = 0; x < depth.width; ++x)
                if (depth.drawn(x, y))
                    result[depth.index(x, y)] = stored_value(
                        format, static_cast<float>(pass.at(x, y, taps[static_cast<std::size_t>(y)])));
        });
        ambient = std::move(result);
    }
    std::uint64_t total = 0;
    for (const std::uint64_t row : taps) total += row;
    return total;
}

}  // namespace ropsim
