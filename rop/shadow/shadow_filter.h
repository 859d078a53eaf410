// Percentage-closer filtering: which texels a look-up reads, and how the depth bias grows with their
// distance.
#pragma once

#include "base/random.h"
#include "rop/shadow/light_space.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace ropsim {

// A square of texels around the one that a point falls into. Texels outside the map let all light through.
struct ShadowFilter {
    static constexpr int kMaxSide = 63;

    int side = 3;  // texels, odd, 1 to kMaxSide
    int taps = 0;  // texels drawn at random from the square, with replacement; 0: every texel of it, once
    // A texel's samples count as nearer than the point only if they are by more than
    // bias + slope_bias * (the distance from the point to the texel's centre, the larger of x and y, in
    // texels).
    double bias = 0;        // window depth
    double slope_bias = 0;  // window depth a texel
};

namespace detail {

// visibility_of(x, y, z) of one texel, z brought nearer by the bias.
template <typename VisibilityOf>
double texel_visibility(const ShadowFilter& filter, int width, int height, const ViewPoint& point, int x,
                        int y, const VisibilityOf& visibility_of) {
    if (x < 0 || y < 0 || x >= width || y >= height) return 1;
    const double away = std::max(std::abs(point.x - (x + 0.5)), std::abs(point.y - (y + 0.5)));
    return visibility_of(x, y, point.z - filter.bias - filter.slope_bias * away);
}

}  // namespace detail

// Whether a point lies in what the light's view shows; elsewhere nothing is known and it counts as lit.
inline bool inside_view(const ViewPoint& point, int width, int height) {
    return point.x >= 0 && point.x < width && point.y >= 0 && point.y < height && point.z >= 0 &&
           point.z <= 1;
}

// Mean of visibility_of(x, y, z) over every texel of the square, whatever `taps` says: what random taps
// estimate. The point must be inside_view().
template <typename VisibilityOf>
double whole_filter(const ShadowFilter& filter, int width, int height, const ViewPoint& point,
                    const VisibilityOf& visibility_of) {
    const int left = static_cast<int>(point.x) - filter.side / 2;
    const int top = static_cast<int>(point.y) - filter.side / 2;
    double sum = 0;
    for (int y = top; y < top + filter.side; ++y)
        for (int x = left; x < left + filter.side; ++x)
            sum += detail::texel_visibility(filter, width, height, point, x, y, visibility_of);
    return sum / (filter.side * filter.side);
}

// The same over the texels that a look-up reads. `key` stands for the fragment: the taps are a pure function
// of it.
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
        sum += detail::texel_visibility(filter, width, height, point, left + texel % filter.side,
                                        top + texel / filter.side, visibility_of);
    }
    return sum / filter.taps;
}

}  // namespace ropsim
