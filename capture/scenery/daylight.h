// Sun, sky and haze of an outdoor scene.
#pragma once

#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// Linear light; the sun stands in light_direction() of scene_parts.h.
struct Daylight {
    glm::vec3 sun{1.05f, 0.96f, 0.82f};
    glm::vec3 sky{0.22f, 0.27f, 0.34f};
    glm::vec3 haze{0.6f, 0.68f, 0.78f};  // what infinitely distant things look like
    float haze_extinction = 0.003f;      // a metre
};

// u_parameters 0 to 3 of capture/shaders/daylight.glsl.
std::vector<glm::vec4> daylight_parameters(const Daylight& daylight);

}  // namespace ropsim
