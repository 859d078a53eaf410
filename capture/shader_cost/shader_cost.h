// What a draw's fragment shader costs, measured from its GLSL.
#pragma once

#include "capture/scene.h"
#include "traces/trace.h"

#include <string>

namespace ropsim {

struct ShaderCosts {
    ShaderCost full;     // colour premultiplied by alpha, and alpha; with `materials` the material too
    ShaderCost alpha;    // what of it remains when only alpha is wanted; discard stays
    std::string source;  // one line, for Draw::cost_source
};

// Compiles both variants of `draw`'s fragment shader and counts (capture/shader_cost/spirv_cost.h). A pure
// function of the draw's shading, its textures' channels and `materials`; shaders seen before in this process
// are not compiled again. The first call of a process costs about 50 ms (the compiler reads its own
// declarations), others 2 to 5 ms.
ShaderCosts measure_shader_cost(const SceneDraw& draw, bool materials);

}  // namespace ropsim
