// GLSL to optimised SPIR-V, as a driver's compiler would begin.
#pragma once

#include "capture/shader_cost/spirv_module.h"

#include <string>

namespace ropsim {

// Compiles a fragment shader ("#version 450 core" and all) with glslang and optimises it with SPIRV-Tools'
// performance passes: inlining, unrolling of loops with constant trip counts, scalar replacement, removal of
// dead and repeated code. A pure function of the text. `label` is for the log: a shader that does not compile
// is our own mistake (CHECK).
SpirvWords compile_fragment_shader(const std::string& label, const std::string& glsl);

// "glslang 12.0.0, SPIRV-Tools v2023.1", as linked.
std::string shader_compiler_version();

}  // namespace ropsim
