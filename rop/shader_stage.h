// What a technique has the fragment shader compute for it, and from what.
#pragma once

#include "traces/trace.h"

#include <array>
#include <cstddef>

namespace ropsim {

inline constexpr std::size_t kMaxExports = 10;
using Exports = std::array<float, kMaxExports>;

// A fragment as its shader sees it.
struct ShadedFragment {
    const Fragment& fragment;
    const Material& material;
    int x, y;            // its pixel of the image, also where it is drawn at a lower resolution
    float opaque_depth;  // window depth of the opaque layer at its pixel, +infinity where there is none
};

// Whether two fragments, one drawn right before the other, share the registers of one shader invocation where
// their draw says that it joins them. What the opaque layer hides is not shaded.
inline bool joins(const Fragment& before, const Fragment& f) {
    return before.x == f.x && before.y == f.y && before.draw == f.draw && before.coverage != 0;
}

// Of a technique's shader, for each fragment, besides what the scene's own shader costs.
struct AddedShading {
    int alu_instructions = 0;
    int opaque_depth_fetches = 0;  // of a texel each, by surfaces that scatter
};

}  // namespace ropsim
