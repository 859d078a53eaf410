// What the shader of a ray-marched medium costs, counted from its GLSL.
#pragma once

#include "traces/trace.h"

#include <string>

namespace ropsim {

// What decides the shader's text.
struct VolumeShader {
    bool falloff = false;      // of the extinction with height
    bool light = false;        // else ambient light alone
    bool point_light = false;  // a perspective light
    int shadow_texels = 0;     // side of the square that a step reads; 0: no shadows
    bool jitter = false;
    int steps = 1;
};

struct VolumeCost {
    ShaderCost full, alpha;  // a fragment: its step, and its even share (rounded) of what a pixel does once
    std::string source;      // one line, for Draw::cost_source
};

VolumeCost measure_volume_cost(const VolumeShader& shader);

}  // namespace ropsim
