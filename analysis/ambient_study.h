// Ambient occlusion put onto a captured trace: in screen space for what is in the depth buffer, inferred for
// the edges of cut-outs (McGuire and Mara 2017, section 6).
#pragma once

#include "analysis/ambient_edges.h"
#include "analysis/ambient_obscurance.h"

#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

struct AmbientOptions {
    std::string trace;
    std::string directory;
    std::vector<std::string> solid;  // names of draws that are cut-outs
    double solid_alpha = 0.999;      // a fragment of theirs of at least this alpha is whole
    HelperLanes helpers = HelperLanes::kTwin;
    ObscuranceSettings obscurance;
    int blur = 4;  // radius in taps of the filter over the ambient buffer, 0: none
    InferenceSettings inference;
    bool infer = true;   // else edges receive no ambient occlusion
    double share = 0.5;  // of every colour that is ambient light: colour * (1 - share (1 - AO))
    int threads = 1;
};

// By draw, or in all.
struct AmbientCounts {
    std::uint64_t fragments = 0;
    std::uint64_t hidden = 0, other = 0, solid = 0, line = 0, box = 0;  // as AmbientKind
    std::uint64_t in_front = 0;  // of the opaque layer: what a machine operates, hidden or not
    double solid_ambient = 0, inferred_ambient = 0;  // sums of AO
    float largest_alpha = 0;                         // of a solid draw

    std::uint64_t inferred() const { return line + box; }
    void add(const AmbientCounts& other);
};

struct AmbientStudy {
    AmbientOptions options;
    std::string trace_hash;
    int width = 0, height = 0;
    std::vector<std::string> draw_names;
    std::vector<AmbientCounts> draws;
    std::vector<ShaderCost> shaders_before, shaders_after;  // by draw, of the whole shader
    Obscurance obscurance;
    std::uint64_t blur_taps = 0;
    InferenceCounts inference;
    EdgeStep edges;
    std::uint64_t opaque_pixels = 0;  // that receive ambient occlusion
    double opaque_ambient = 0;        // sum of theirs
    double host_seconds = 0;          // without pictures
};

// Writes ambient.trace, ao.exr, ao.png, before.png and after.png (both composited exactly) into the
// directory, created if need be; an ambient.json from before is taken away first. In ambient.trace colours
// are dimmed, and each solid draw's shader cost has grown by the mean over its fragments in front of the
// opaque layer, which are those that a machine operates. Fragments that are not shaded, hidden by the opaque
// layer or a whole fragment, keep their colour. Values that are not finite are brought into range. UserError:
// more than one spatial sample a pixel, no camera, an unknown or untested draw in `solid`, an empty depth
// buffer, or a damaged trace.
AmbientStudy study_ambient(const AmbientOptions& options);

// The text of ambient.json. Same inputs, same text, `host` apart.
std::string ambient_json(const AmbientStudy& study);

}  // namespace ropsim
