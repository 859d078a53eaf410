// What one SPIR-V instruction costs in scalar ALU instructions.
#pragma once

#include "capture/shader_cost/spirv_module.h"

#include <cstdint>

namespace ropsim {

// Whether component i of the result depends only on component i of each operand (or on a scalar operand).
bool componentwise(const SpirvModule& module, const SpirvInstruction& instruction);

// Scalar ALU instructions of `instruction`, of whose result `used` components are wanted (> 0). 0 for
// everything that is no arithmetic, texture reads included.
std::uint32_t alu_cost(const SpirvModule& module, const SpirvInstruction& instruction, std::uint32_t used);

}  // namespace ropsim
