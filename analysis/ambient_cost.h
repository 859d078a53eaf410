// What inferred ambient occlusion adds to a fragment's shader: Listing 2 of McGuire and Mara 2017, counted
// like the shaders of captured scenes (capture/shader_cost/spirv_cost.h).
#pragma once

#include "analysis/ambient_inference.h"
#include "traces/trace.h"

#include <cstdint>

namespace ropsim {

// Scalar operations of the listing in GLSL after optimisation, loops unrolled: multiply-adds fused, quotients
// as reciprocal and product, signs and absolute values free, conversions and clamps one a component. The
// numbers are constants, so that results do not depend on the compiler; a test counts them.
struct ListingOperations {
    static constexpr std::uint32_t kLineTap = 14;
    static constexpr std::uint32_t kBoxTap = 14;
    static constexpr std::uint32_t kDecision = 5;   // gradient and its length
    static constexpr std::uint32_t kDirection = 3;  // of the line
    static constexpr std::uint32_t kQuotient = 4;   // with floor and clamp
};

// Of one fragment that is inferred along a line or from a square: what it adds to the shader. A tap reads a
// texel of depth, 4 bytes, and one of the ambient buffer.
ShaderCost line_cost(const InferenceSettings& settings, std::uint32_t ambient_bytes);
ShaderCost box_cost(const InferenceSettings& settings, std::uint32_t ambient_bytes);
// Of a whole fragment, which reads the ambient buffer at its pixel.
ShaderCost solid_cost(std::uint32_t ambient_bytes);

inline constexpr std::uint32_t kDepthBytes = 4;

}  // namespace ropsim
