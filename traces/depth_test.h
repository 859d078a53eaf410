// The depth test of transparent fragments against the opaque layer, sample by sample.
#pragma once

#include "traces/sample_positions.h"
#include "traces/trace.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace ropsim {

// Window depth of the fragment's plane at a sample; the plane ends at the ends of the depth range.
inline float sample_depth(const Fragment& fragment, const DepthSlope& slope, SamplePosition position) {
    return std::clamp(fragment.z + slope.dx * position.x() + slope.dy * position.y(), 0.0f, 1.0f);
}

// GL_LESS, for draws that ask for it; everything passes where there is no opaque layer. `header` must outlive
// it.
class OpaqueDepthTest {
 public:
    explicit OpaqueDepthTest(const TraceHeader& header)
        : header_(&header), positions_(sample_positions(header.samples)), all_((1u << header.samples) - 1u) {}

    // Those of the fragment's covered samples that lie in front of the opaque layer.
    std::uint32_t visible_samples(const Fragment& f, const DepthSlope& slope) const {
        const std::uint32_t covered = f.coverage & all_;
        if (!header_->opaque || !header_->draws[f.draw].depth_test) return covered;
        const auto samples = static_cast<std::size_t>(header_->samples);
        const std::size_t pixel =
            static_cast<std::size_t>(f.y) * static_cast<std::size_t>(header_->width) + f.x;
        const float* opaque = &header_->opaque->depth[pixel * samples];
        if (samples == 1) return f.z < opaque[0] ? covered : 0;
        std::uint32_t visible = 0;
        for (std::size_t m = 0; m < samples; ++m)
            if (((covered >> m) & 1u) != 0 && sample_depth(f, slope, positions_[m]) < opaque[m])
                visible |= 1u << m;
        return visible;
    }

 private:
    const TraceHeader* header_;
    std::span<const SamplePosition> positions_;
    std::uint32_t all_;
};

}  // namespace ropsim
