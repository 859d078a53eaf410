// Counts what a fragment shader makes a GPU do, from its optimised SPIR-V.
#pragma once

#include "capture/shader_cost/spirv_module.h"
#include "traces/trace.h"

#include <vector>

namespace ropsim {

// Times that a loop's body is counted where its trip count is not a constant.
inline constexpr std::uint32_t kAssumedTrips = 8;

struct SpirvCost {
    ShaderCost cost;
    std::uint32_t assumed_loops = 0;  // loops counted kAssumedTrips times
};

// ALU instructions are scalar operations, as GPUs issue them: an operation on n components whose results are
// used counts n; dot products, multiply-adds and special functions by the table in
// capture/shader_cost/spirv_cost_table.h. A sum of a product that nothing else uses is one fused
// multiply-add. Free: sign and absolute value (source modifiers), moves, swizzles, construction, loads of
// varyings, uniforms and buffers, branches and discard themselves. Both sides of a branch count, since
// neighbouring fragments that disagree execute both, and so does a selection where they meet.
//
// A texture fetch reads 4 texels where its level is a constant (bilinear, texelFetch reads 1), else 8
// (trilinear), of bytes_a_texel[binding] bytes each; a shader that reads a texture beyond that list is our
// own mistake (CHECK), as is a call that was not inlined.
SpirvCost count_spirv_cost(const SpirvModule& module, const std::vector<std::uint32_t>& bytes_a_texel);

}  // namespace ropsim
