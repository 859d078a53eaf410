// The fragments of cut-outs (leaves, fences), and the depth buffer that their whole parts are drawn into.
#pragma once

#include "analysis/ambient_view.h"
#include "traces/trace.h"

#include <cstdint>
#include <tuple>
#include <vector>

namespace ropsim {

struct CutoutSettings {
    std::vector<bool> solid;     // by draw: a cut-out whose coverage is binary before filtering
    float solid_alpha = 0.999f;  // a fragment of at least this alpha is whole
};

enum class AmbientKind : std::uint8_t {
    kHidden,  // not shaded: behind the opaque layer or a whole fragment
    kOther,   // AO is 1: of other draws, or of alpha 0
    kSolid,   // whole and nearest: AO is the buffer's own
    kLine,    // at an edge, inferred along the gradient of alpha
    kBox,     // at an edge, inferred from a square
};

struct CutoutFragment {
    std::uint32_t primitive;  // number alone
    std::uint16_t draw, x, y;
    bool in_front;  // of the opaque layer
    AmbientKind kind;
    float z, a;
    float luminance;  // Rec. 709, of the colour not multiplied by alpha
    std::uint32_t arrival;

    // Equal for the fragments that two neighbouring primitives, 2i and 2i + 1, have in one 2x2 quad.
    auto quad() const { return std::tuple(draw, primitive >> 1, y >> 1, x >> 1); }
};

struct Cutouts {
    DepthBuffer depth;  // of the opaque layer and the nearest whole fragments
    // Of solid draws, quad by quad; the order does not depend on that of arrival.
    std::vector<CutoutFragment> fragments;
    std::uint64_t trace_fragments = 0;
};

// Reads a trace of one spatial sample a pixel once and leaves it rewound. Memory: 28 bytes a fragment of
// solid draws. UserError on a damaged trace or one of 2^32 fragments and more.
Cutouts read_cutouts(TraceReader& trace, const CutoutSettings& settings);

}  // namespace ropsim
