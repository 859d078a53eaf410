// What stands behind the panes: pieces of a garden's chess game, a box, a figure with a hand on the glass,
// and the hall around them.
#pragma once

#include "capture/scene.h"
#include "capture/scenery/table_light.h"

#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// Towards the sun.
glm::vec3 hall_sun();

// Everything opaque; `stands` are boxes that hold the panes up: middle of the foot, yaw in w; `light` is what
// the panes leave of the sun on the floor, to which the hall's own things add their shadows.
std::vector<SceneDraw> hall_draws(const std::vector<glm::vec4>& stands, TableLight light);

}  // namespace ropsim
