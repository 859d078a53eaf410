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
    float opaque_depth;  // window depth of the opaque layer at its pixel, +infinity where there is none
};

// Of a technique's shader, for each fragment, besides what the scene's own shader costs.
struct AddedShading {
    int alu_instructions = 0;
    int opaque_depth_fetches = 0;  // of a texel each
};

}  // namespace ropsim
