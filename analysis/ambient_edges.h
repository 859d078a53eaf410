// Which ambient occlusion each fragment of a cut-out receives: the buffer's where it is whole, an inferred
// one at its edges; and how far edges then differ from what they are the edges of.
#pragma once

#include "analysis/ambient_cutouts.h"
#include "analysis/ambient_inference.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace ropsim {

// What a derivative takes for the alpha of a lane whose fragment the primitive did not send. On a GPU a
// helper lane runs the shader there, but a trace holds no helper lanes.
enum class HelperLanes {
    kTwin,  // what the other primitive of its pair (number xor 1) has there: a card is two triangles with one
            // texture. Else 0: captures leave out what is clear
    kZero,  // 0
    kOwn,   // the fragment's own, so that there is no difference
};

struct InferenceCounts {
    std::uint64_t lanes_own = 0;     // neighbours that derivatives looked at: sent by the primitive itself,
    std::uint64_t lanes_twin = 0;    // by the other of its pair,
    std::uint64_t lanes_absent = 0;  // by neither
    std::uint64_t taps = 0;
    std::uint64_t faint = 0;      // fragments whose weights sum to less than the listing's 0.01
    std::uint64_t unmatched = 0;  // whose taps all weigh less than a half: none lies on their surface
    std::uint64_t texels = 0;     // distinct ones of each buffer that any tap read
};

// Sets the kind of every cut-out fragment, and of the visible ones `ambient[arrival]`: 1 at edges where
// `infer` is false. `ambient` has an element for every fragment of the trace. `buffer` is the ambient buffer
// of cutouts.depth. Does not depend on `threads`.
InferenceCounts infer_ambient(Cutouts& cutouts, const CutoutSettings& settings, HelperLanes helpers,
                              const AmbientInference& inference, std::span<const float> buffer, bool infer,
                              int threads, std::vector<float>& ambient);

// How much brighter the edges of cut-outs are than what they are the edges of: over all pairs of an edge and
// a whole fragment of one primitive in one quad, both visible, the mean luminance of the first over that of
// the second, less 1. The texture's own colours make it differ from 0 without ambient occlusion.
struct EdgeStep {
    std::uint64_t pairs = 0;
    // Absent where the whole fragments have no light.
    std::optional<double> without;     // ambient occlusion
    std::optional<double> solid_only;  // applied to whole fragments alone
    std::optional<double> inferred;    // and to edges, by what `ambient` holds
    // Mean of |AO of edge - AO of whole|, where errors of opposite sign do not cancel.
    double difference_solid_only = 0;
    double difference_inferred = 0;
};
// `share`: of the light that is ambient. Nothing is measured without pairs.
EdgeStep edge_step(const Cutouts& cutouts, const std::vector<float>& ambient, double share);

}  // namespace ropsim
