// Percentage-closer filtering: which texels a look-up reads, and how the depth bias grows with their
// distance.
#pragma once

#include "base/random.h"
#include "rop/shadow/light_space.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>

namespace ropsim {

// How a square's texels count: alike; by a tent, (side + 1)/2 - |i| along each axis; alike where their centre
// lies in the disc of diameter `side`, else not at all.
enum class FilterShape : std::uint8_t { kSquare, kTent, kDisc };

// A square of texels around the one that a point falls into. Texels outside the map let all light through.
struct ShadowFilter {
    static constexpr int kMaxSide = 63;

    int side = 3;  // texels, odd, 1 to kMaxSide
    FilterShape shape = FilterShape::kSquare;
    int taps = 0;  // texels drawn at random from the square, with replacement; 0: every texel of it, once
    // A texel's samples count as nearer than the point only if they are by more than
    // bias + slope_bias * (the distance from the point to the texel's centre, the larger of x and y, in
    // texels).
    double bias = 0;        // window depth
    double slope_bias = 0;  // window depth a texel

    // Weight of the texel (dx, dy) from the middle one, |dx| and |dy| at most side / 2; not normalised.
    int weight(int dx, int dy) const {
        const int half = side / 2 + 1;
        if (shape == FilterShape::kTent) return (half - std::abs(dx)) * (half - std::abs(dy));
        if (shape == FilterShape::kDisc) return 4 * (dx * dx + dy * dy) <= side * side ? 1 : 0;
        return 1;
    }
};

// Whether a point lies in what the light's view shows; elsewhere nothing is known and it counts as lit.
inline bool inside_view(const ViewPoint& point, int width, int height) {
    return point.x >= 0 && point.x < width && point.y >= 0 && point.y < height && point.z >= 0 &&
           point.z <= 1;
}

// Depth that texel (x, y) is asked about: the point's, brought nearer by the bias.
inline double asked_depth(const ShadowFilter& filter, const ViewPoint& point, int x, int y) {
    const double away = std::max(std::abs(point.x - (x + 0.5)), std::abs(point.y - (y + 0.5)));
    return point.z - filter.bias - filter.slope_bias * away;
}

// Calls visit(weight, x, y, z) for every texel of the square that counts, inside the map or not, and returns
// the sum of the weights. The point must be inside_view().
template <typename Visit>
double for_each_filtered(const ShadowFilter& filter, const ViewPoint& point, const Visit& visit) {
    const int half = filter.side / 2;
    double weights = 0;
    for (int dy = -half; dy <= half; ++dy)
        for (int dx = -half; dx <= half; ++dx) {
            const int weight = filter.weight(dx, dy);
            if (weight == 0) continue;
            const int x = static_cast<int>(point.x) + dx;
            const int y = static_cast<int>(point.y) + dy;
            visit(static_cast<double>(weight), x, y, asked_depth(filter, point, x, y));
            weights += weight;
        }
    return weights;
}

inline bool inside_map(int x, int y, int width, int height) {
    return x >= 0 && y >= 0 && x < width && y < height;
}

// Weighted mean of visibility_of(x, y, z) over every texel of the square that counts, whatever `taps` says:
// what random taps estimate. The point must be inside_view().
template <typename VisibilityOf>
double whole_filter(const ShadowFilter& filter, int width, int height, const ViewPoint& point,
                    const VisibilityOf& visibility_of) {
    double sum = 0;
    const double weights = for_each_filtered(filter, point, [&](double weight, int x, int y, double z) {
        sum += weight * (inside_map(x, y, width, height) ? visibility_of(x, y, z) : 1.0);
    });
    return sum / weights;
}

// The same over the texels that a look-up reads. `key` stands for the fragment: the taps are a pure function
// of it, and for squares only.
template <typename VisibilityOf>
double filtered(const ShadowFilter& filter, int width, int height, const ViewPoint& point, std::uint64_t key,
                const VisibilityOf& visibility_of) {
    if (filter.taps == 0) return whole_filter(filter, width, height, point, visibility_of);
    const int left = static_cast<int>(point.x) - filter.side / 2;
    const int top = static_cast<int>(point.y) - filter.side / 2;
    const auto texels = static_cast<std::uint64_t>(filter.side) * static_cast<std::uint64_t>(filter.side);
    double sum = 0;
    for (int tap = 0; tap < filter.taps; ++tap) {
        const auto texel = static_cast<int>(random_bits(key, static_cast<std::uint32_t>(tap)) * texels >> 32);
        const int x = left + texel % filter.side;
        const int y = top + texel / filter.side;
        sum += inside_map(x, y, width, height) ? visibility_of(x, y, asked_depth(filter, point, x, y)) : 1.0;
    }
    return sum / filter.taps;
}

}  // namespace ropsim
