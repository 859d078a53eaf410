// Which components of a shader's values anything depends on.
#pragma once

#include "capture/shader_cost/spirv_module.h"

#include <cstdint>
#include <unordered_map>

namespace ropsim {

// Id to a mask of the components (bit i: component i; 1 for what has none, such as a pointer) that an output,
// a write, a branch or a discard depends on; ids that nothing depends on are absent. SPIRV-Tools removes
// whole dead values only: of vec4 texel * colour whose alpha alone is wanted, one product in four is live.
std::unordered_map<std::uint32_t, std::uint32_t> live_components(const SpirvModule& module);

}  // namespace ropsim
