// Planes through depths in integers: fitting, predicting, and which of two a pixel lies on.
#pragma once

#include "memory/block_bits.h"
#include "memory/block_plan.h"

#include <array>
#include <cstdint>

namespace ropsim {

// Depths of a block as ordered integers, and the pixel of each.
struct DepthValues {
    std::uint32_t count = 0;
    std::uint32_t bits = 0;  // of a depth
    std::array<std::uint32_t, kMaxBlockBytes + 2> z;
    std::array<std::uint8_t, kMaxBlockBytes> x;  // of the pixel in its tile
    std::array<std::uint8_t, kMaxBlockBytes> y;
};

// Sets count, x and y of the column's values.
void place_depths(const BlockFormat& format, const Column& column, DepthValues& depths);

inline constexpr std::uint32_t kSlopeFraction = 4;  // bits: a rounded slope errs by 7/32 across a tile
// Slopes: a difference of two depths, its sign, the fraction.
constexpr std::uint32_t slope_bits(std::uint32_t depth_bits) {
    return depth_bits + 1 + kSlopeFraction;
}

// Depth at a pixel of the tile; slopes in units of 1 / 2^kSlopeFraction a pixel.
struct DepthPlane {
    std::uint32_t z0 = 0;  // at pixel (x0, y0), modulo 2^32
    std::int64_t dx = 0;
    std::int64_t dy = 0;
    std::int32_t x0 = 0;
    std::int32_t y0 = 0;
};

// The depths of a plane at the pixels of a tile, by a sum of two shares.
class PlaneDepths {
 public:
    explicit PlaneDepths(const DepthPlane& plane) : z0_(plane.z0) {
        for (std::int32_t i = 0; i < 8; ++i) {
            x_[static_cast<std::size_t>(i)] = plane.dx * (i - plane.x0) + (1 << (kSlopeFraction - 1));
            y_[static_cast<std::size_t>(i)] = plane.dy * (i - plane.y0);
        }
    }
    std::uint32_t at(std::uint32_t x, std::uint32_t y) const {
        return z0_ + static_cast<std::uint32_t>((x_[x] + y_[y]) >> kSlopeFraction);
    }

 private:
    std::uint32_t z0_;
    std::array<std::int64_t, 8> x_;
    std::array<std::int64_t, 8> y_;
};

// One plane, or two with a bit a pixel. Corrections are from 0: planes lie below their pixels.
struct PlaneFit {
    std::array<DepthPlane, 2> plane;
    std::array<std::uint8_t, kMaxBlockBytes> second;  // by value: on plane[1]
    std::uint32_t width = 0;                          // bits of the largest correction
};

// Through the first value, the farthest of its row and the farthest of its column.
PlaneFit fit_one_plane(const DepthValues& depths);
// From the first value, and from the end of a row or column that lies farthest from the first's plane: each
// as far along its row and column as depths stay within a unit of a line.
PlaneFit fit_two_planes(const DepthValues& depths);

}  // namespace ropsim
