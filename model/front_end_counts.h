// What passed through the front end: depth decisions, quads, warps and texture fetches.
#pragma once

#include "memory/rop_cache.h"
#include "model/quad_operation.h"

#include <bit>
#include <cstdint>

namespace ropsim {

// Whether a quad goes on to a partition: what is known to be behind, or covers nothing, does not; what the
// partition itself must test does.
constexpr bool reaches_partition(const QuadOperation& q) {
    return q.kind != QuadKind::kCulled || (q.depth_tested() && q.depth_lines == 0);
}

struct FrontEndCounts {
    std::uint64_t hierarchical_depth_bytes = 0;  // on chip
    // Quads of the draws, by what the depth ranges say of them; those of draws that are not tested besides.
    std::uint64_t quads = 0;
    std::uint64_t rejected = 0;
    std::uint64_t accepted = 0;
    std::uint64_t tested = 0;
    std::uint64_t untested = 0;
    std::uint64_t depth_bytes_saved = 0;  // that the rejected and the accepted would have read
    std::uint64_t early_culled = 0;       // tested before shading and found to be behind
    std::uint64_t tiles = 0;              // of primitives, visited by the rasteriser
    RopCacheStatistics depth_cache;       // of all depth units
    // Shading.
    std::uint64_t warps = 0;
    std::uint64_t shaded_quads = 0;
    std::uint64_t warp_quad_places = 0;  // that the warps had
    std::uint64_t covered_lanes = 0;     // with a fragment; the quads' others are helpers
    std::uint64_t quad_fetches = 0;      // texture fetches of whole quads
    RopCacheStatistics texture_cache;    // of all cores

    std::uint64_t helper_lanes() const { return 4 * shaded_quads - covered_lanes; }
    std::uint64_t empty_lanes() const { return 4 * (warp_quad_places - shaded_quads); }

    // A quad has been rasterised. `depth_bytes`: of a quad's depths.
    void rasterise(const QuadOperation& q, std::uint64_t depth_bytes) {
        if (!q.is_shaded()) return;
        ++quads;
        tiles += q.new_tile ? 1 : 0;
        if (q.depth == 0) {
            ++untested;
        } else if (q.depth_tested()) {
            ++tested;
            early_culled += q.kind == QuadKind::kCulled && q.depth_lines != 0 ? 1 : 0;
        } else {
            (q.rejected() ? rejected : accepted) += 1;
            depth_bytes_saved += depth_bytes;
        }
    }
    void shade(const QuadOperation& q) {
        ++shaded_quads;
        quad_fetches += q.texture_fetches;
        // Of four lanes: a nibble for each mask.
        covered_lanes += 0x4332322132212110ull >> (4 * q.covered) & 0xF;
    }
};

}  // namespace ropsim
