// Planes through depths in integers.
#include "memory/depth_planes.h"

#include <algorithm>
#include <bit>
#include <cstdlib>

namespace ropsim {
namespace {

constexpr std::uint32_t kTilePixels = 64;
constexpr int kSide = 8;
constexpr int kAbsent = -1;

// Of a pixel in quad order.
constexpr std::uint8_t pixel_x(std::uint32_t pixel) {
    return static_cast<std::uint8_t>(pixel / 4 % 4 * 2 + pixel % 2);
}
constexpr std::uint8_t pixel_y(std::uint32_t pixel) {
    return static_cast<std::uint8_t>(pixel / 16 * 2 + pixel / 2 % 2);
}

// The value at each pixel: the first, where a pixel has several.
class PixelGrid {
 public:
    explicit PixelGrid(const DepthValues& depths) : depths_(depths) {
        for (auto& row : value_) row.fill(kAbsent);
        for (std::uint32_t i = depths.count; i-- > 0;)
            value_[depths.y[i]][depths.x[i]] = static_cast<std::int16_t>(i);
    }
    int value(int x, int y) const {
        return x < 0 || y < 0 || x >= kSide || y >= kSide
                   ? kAbsent
                   : value_[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)];
    }
    std::int64_t depth(int value) const { return depths_.z[static_cast<std::size_t>(value)]; }

    // Slope a step from `from` in direction (sx, sy): to the farthest pixel that has a value.
    std::int64_t whole_slope(int from, int sx, int sy) const {
        const int reach = extent(from, sx, sy);
        return reach == 0 ? 0 : slope(from, sx, sy, reach);
    }
    // To the farthest such that all between lie within a unit of the line.
    std::int64_t line_slope(int from, int sx, int sy) const {
        const int end = extent(from, sx, sy);
        int reach = std::min(end, 1);
        for (int far = 2; far <= end && straight(from, sx, sy, far); ++far) reach = far;
        return reach == 0 ? 0 : slope(from, sx, sy, reach);
    }
    int extent(int from, int sx, int sy) const {
        int steps = 0;
        while (step(from, sx, sy, steps + 1) != kAbsent) ++steps;
        return steps;
    }
    int step(int from, int sx, int sy, int steps) const {
        return value(depths_.x[static_cast<std::size_t>(from)] + sx * steps,
                     depths_.y[static_cast<std::size_t>(from)] + sy * steps);
    }

 private:
    std::int64_t rise(int from, int sx, int sy, int steps) const {
        return depth(step(from, sx, sy, steps)) - depth(from);
    }
    std::int64_t slope(int from, int sx, int sy, int reach) const {
        const std::int64_t twice = rise(from, sx, sy, reach) * (2 << kSlopeFraction);
        return (twice + (twice < 0 ? -reach : reach)) / (std::int64_t{2} * reach) * (sx + sy);
    }
    bool straight(int from, int sx, int sy, int far) const {
        const std::int64_t whole = rise(from, sx, sy, far);
        for (int k = 1; k < far; ++k)
            if (std::abs(far * rise(from, sx, sy, k) - k * whole) > far) return false;
        return true;
    }

    const DepthValues& depths_;
    std::array<std::array<std::int16_t, kSide>, kSide> value_;
};

DepthPlane plane_at(const DepthValues& depths, int value) {
    DepthPlane plane;
    plane.z0 = depths.z[static_cast<std::size_t>(value)];
    plane.x0 = depths.x[static_cast<std::size_t>(value)];
    plane.y0 = depths.y[static_cast<std::size_t>(value)];
    return plane;
}

std::int32_t correction(const DepthValues& depths, const PlaneDepths& plane, std::size_t i) {
    return static_cast<std::int32_t>(depths.z[i] - plane.at(depths.x[i], depths.y[i]));
}

std::uint32_t magnitude(std::int32_t value) {
    return value < 0 ? 0u - static_cast<std::uint32_t>(value) : static_cast<std::uint32_t>(value);
}

DepthPlane line_plane(const DepthValues& depths, const PixelGrid& grid, int from, int sx, int sy) {
    DepthPlane plane = plane_at(depths, from);
    plane.dx = grid.line_slope(from, sx, 0);
    plane.dy = grid.line_slope(from, 0, sy);
    return plane;
}

}  // namespace

void place_depths(const BlockFormat& format, const Column& column, DepthValues& depths) {
    depths.count = column.count;
    const std::uint32_t samples = format.planar || format.elements == 0 ? 1 : format.elements;
    std::uint32_t pixel = column.first / samples;
    std::uint32_t sample = column.first % samples;
    for (std::uint32_t i = 0; i < column.count; ++i) {
        depths.x[i] = pixel_x(pixel % kTilePixels);
        depths.y[i] = pixel_y(pixel % kTilePixels);
        if (++sample == samples) {
            sample = 0;
            ++pixel;
        }
    }
}

PlaneFit fit_one_plane(const DepthValues& depths) {
    PlaneFit fit;
    if (depths.count == 0) return fit;
    const PixelGrid grid(depths);
    DepthPlane& plane = fit.plane[0];
    plane = plane_at(depths, 0);
    plane.dx = grid.whole_slope(0, 1, 0);
    plane.dy = grid.whole_slope(0, 0, 1);
    const PlaneDepths on(plane);
    std::int32_t least = 0;
    std::int32_t largest = 0;
    for (std::uint32_t i = 0; i < depths.count; ++i) {
        const std::int32_t c = correction(depths, on, i);
        least = std::min(least, c);
        largest = std::max(largest, c);
    }
    plane.z0 += static_cast<std::uint32_t>(least);
    fit.width = static_cast<std::uint32_t>(
        std::bit_width(static_cast<std::uint32_t>(largest) - static_cast<std::uint32_t>(least)));
    return fit;
}

PlaneFit fit_two_planes(const DepthValues& depths) {
    PlaneFit fit;
    if (depths.count == 0) return fit;
    const PixelGrid grid(depths);
    const int across = grid.extent(0, 1, 0);
    const int down = grid.extent(0, 0, 1);
    fit.plane[0] = line_plane(depths, grid, 0, 1, 1);
    // The other ends of the first value's row and column, and of both.
    const int right = grid.step(0, 1, 0, across);
    const int below = grid.step(0, 0, 1, down);
    const int opposite = std::max(grid.value(depths.x[0] + across, depths.y[0] + down), 0);
    const PlaneDepths on_first(fit.plane[0]);
    const auto off = [&](int value) {
        return magnitude(correction(depths, on_first, static_cast<std::size_t>(value)));
    };
    int from = opposite;
    if (off(right) > off(from)) from = right;
    if (off(below) > off(from)) from = below;
    fit.plane[1] = line_plane(depths, grid, from, from == below ? 1 : -1, from == right ? 1 : -1);
    const PlaneDepths on_second(fit.plane[1]);
    std::array<std::int32_t, 2> least{0, 0};
    std::array<std::int32_t, 2> largest{0, 0};
    for (std::uint32_t i = 0; i < depths.count; ++i) {
        const std::array<std::int32_t, 2> c{correction(depths, on_first, i),
                                            correction(depths, on_second, i)};
        const std::size_t chosen = magnitude(c[1]) < magnitude(c[0]) ? 1 : 0;
        fit.second[i] = static_cast<std::uint8_t>(chosen);
        least[chosen] = std::min(least[chosen], c[chosen]);
        largest[chosen] = std::max(largest[chosen], c[chosen]);
    }
    for (std::size_t p = 0; p < 2; ++p) {
        fit.plane[p].z0 += static_cast<std::uint32_t>(least[p]);
        const std::uint32_t span =
            static_cast<std::uint32_t>(largest[p]) - static_cast<std::uint32_t>(least[p]);
        fit.width = std::max(fit.width, static_cast<std::uint32_t>(std::bit_width(span)));
    }
    return fit;
}

}  // namespace ropsim
