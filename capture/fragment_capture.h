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
    std::size_t fragments_a_piece =
        0;            // 0: as many as the driver allows, at most kMaxPieceFragments; at least 64
    int threads = 0;  // for ordering; 0: the machine's
};
inline constexpr std::size_t kMaxPieceFragments = std::size_t{1} << 18;

struct FragmentCaptureCounts {
    std::uint64_t fragments = 0;
    std::uint64_t pieces = 0;   // that went to the sink
    std::uint64_t retries = 0;  // pieces drawn that overflowed the buffer and were split
};

using FragmentSink = std::function<void(const std::vector<Fragment>&)>;

// Draws every transparent draw without depth test or blending and hands its fragments to `sink` in canonical
// order: draw, instance, primitive, tile, quad, pixel. Needs a current GlContext. Memory is bounded by a
// piece. Every piece is checked against the driver's own count of samples; a difference is a UserError (the
// driver lost fragments).
FragmentCaptureCounts capture_fragments(const Scene& scene, int width, int height,
                                        const FragmentCaptureLimits& limits, const FragmentSink& sink);

}  // namespace ropsim
