// What inferred ambient occlusion adds to a fragment's shader: Listing 2 of McGuire and Mara 2017, counted
// like the shaders of captured scenes (capture/shader_cost/spirv_cost.h).
#pragma once

#include "analysis/ambient_inference.h"
#include "traces/trace.h"

#include <cstdint>

namespace ropsim {

// Scalar operations of the listing in GLSL after optimisation, its loops unrolled: multiply-adds fused where
// a sum takes one product, quotients as reciprocal and product, signs and absolute values free, conversions
// and clamps one a component. They are constants, so that results do not depend on the compiler; a test
// counts them.
struct ListingOperations {
    // 2 for the position, 2 to make it whole, 2 to clamp it, 3 for z, 4 for the weight, 3 for the sums.
    static constexpr std::uint32_t kTap = 16;
    // Gradient, length and comparison 6, direction 3, floor, quotient and clamp 4, less 3 that the first tap,
    // at the fragment itself with sums still 0, does not take.
    static constexpr std::uint32_t kLine = 10;
    // Gradient, length and comparison 6, floor, quotient and clamp 4, less 2 sums of the first tap.
    static constexpr std::uint32_t kBox = 8;
    // Of both sides, where fragments that execute together disagree; with 2 selections where they meet.
    static constexpr std::uint32_t kBoth = 10;
};

// Of one fragment that is inferred along a line or from a square, and of one that executes both: what it adds
// to the shader. A tap reads a texel of depth, 4 bytes, and one of the ambient buffer.
ShaderCost line_cost(const InferenceSettings& settings, std::uint32_t ambient_bytes);
ShaderCost box_cost(const InferenceSettings& settings, std::uint32_t ambient_bytes);
ShaderCost divergent_cost(const InferenceSettings& settings, std::uint32_t ambient_bytes);
// Of a whole fragment, which reads the ambient buffer at its pixel.
ShaderCost solid_cost(std::uint32_t ambient_bytes);

inline constexpr std::uint32_t kDepthBytes = 4;

}  // namespace ropsim
