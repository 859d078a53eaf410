// Depth ranges of the opaque layer's tiles: what lies behind all of a tile is rejected, what lies before all
// of it accepted, without reading a depth.
#pragma once

#include "model/front_end_config.h"
#include "model/quad_operation.h"
#include "traces/trace.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace ropsim {

// Built once from the finished opaque layer: transparent fragments do not change it. The ranges hold all
// spatial samples of a tile and are rounded outwards, so that they never contradict OpaqueDepthTest.
class HierarchicalDepth {
 public:
    // `header` has an opaque layer. `scale`: of a pass at lower resolution, whose tiles have ranges of the
    // depths at its samples.
    HierarchicalDepth(const TraceHeader& header, const HierarchicalDepthConfig& config, int scale);

    // A bit of QuadOperation::depth, for a fragment (at the pass's resolution) of a draw that is tested.
    std::uint8_t decide(const Fragment& f, const DepthSlope& slope) const {
        const Range& range = ranges_[static_cast<std::size_t>(f.y / kTileSize) * across_ +
                                     static_cast<std::size_t>(f.x / kTileSize)];
        float nearest = f.z;
        float farthest = f.z;
        if (sloped_) {
            // In the steps of sample_depth(), so that no rounding puts a sample outside.
            const float dx = std::abs(slope.dx) * 0.5f;
            const float dy = std::abs(slope.dy) * 0.5f;
            nearest = std::clamp(f.z - dx - dy, 0.0f, 1.0f);
            farthest = std::clamp(f.z + dx + dy, 0.0f, 1.0f);
        }
        return nearest >= range.farthest  ? kDepthBehind
               : farthest < range.nearest ? kDepthInFront
                                          : kDepthUndecided;
    }
    // On-chip bytes that the ranges take.
    std::uint64_t bytes() const { return bytes_; }

 private:
    struct Range {
        float nearest;
        float farthest;
    };
    std::vector<Range> ranges_;  // by tile
    std::size_t across_;
    bool sloped_;
    std::uint64_t bytes_ = 0;
};

}  // namespace ropsim
