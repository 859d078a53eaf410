// Surfaces of revolution: a profile turned about the y axis.
#pragma once

#include "capture/geometry/mesh.h"

#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// The surface that `profile` sweeps in one turn. Points are (distance from the axis >= 0, height), at least
// two, no two neighbours equal. Walking along them, matter is on the left: upwards for an outer wall,
// downwards for an inner one. A bend of more than `crease_degrees` stays a sharp edge, others are smooth.
// `sectors` >= 3 steps about the axis. Open profiles give open surfaces. Broken preconditions are a CHECK.
TriangleMesh lathe_mesh(const std::vector<glm::vec2>& profile, int sectors, float crease_degrees = 35);

}  // namespace ropsim
