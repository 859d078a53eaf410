// Turns transparent draws into fragments: the GPU appends them to a buffer, piece by piece.
#pragma once

#include "capture/scene.h"
#include "traces/fragment.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace ropsim {

struct FragmentCaptureLimits {
    std::size_t fragments_a_piece = 0;  // records; 0: as many as the driver allows, at most
                                        // kMaxPieceFragments; at least 64 (M + 1 with M > 1)
    int threads = 0;                    // for ordering; 0: the machine's
};
inline constexpr std::size_t kMaxPieceFragments = std::size_t{1} << 18;

struct FragmentCaptureCounts {
    std::uint64_t fragments = 0;
    std::uint64_t pieces = 0;   // that went to the sink
    std::uint64_t retries = 0;  // pieces drawn that overflowed the buffer and were split
};

using FragmentSink = std::function<void(const FragmentChunk&)>;

// Draws every transparent draw without depth test or blending and hands its fragments to `sink` in canonical
// order: draw, instance, primitive, tile, quad, pixel; with slopes where there are several samples, with
// materials where the scene has them. Needs a current GlContext. Memory is bounded by a piece. Every piece is
// checked against the driver's own count of samples; a difference is a UserError (the driver lost fragments).
//
// Several spatial samples do not need the driver's multisampling, whose rates and positions differ from one
// to the next: the geometry is drawn once with its pixels' centres and once with each of sample_positions()
// moved onto them (FragmentOrder puts the passes together). Sample positions are exact to the rasteriser's
// own grid, 1/256 pixel.
FragmentCaptureCounts capture_fragments(const Scene& scene, int width, int height, int samples,
                                        const FragmentCaptureLimits& limits, const FragmentSink& sink);

}  // namespace ropsim
