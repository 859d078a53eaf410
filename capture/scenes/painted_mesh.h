// Opaque meshes with a colour and a shadow of their own at every vertex.
#pragma once

#include "capture/geometry/mesh.h"
#include "capture/scene.h"

#include <functional>
#include <string>

#include <glm/glm.hpp>

namespace ropsim {

// What is painted at a point: linear colour, and in w the share of the sunlight that arrives.
using Paint = std::function<glm::vec4(glm::vec3 position, glm::vec3 normal)>;

SceneDraw painted_draw(const std::string& name, const TriangleMesh& mesh, const Paint& paint);

// A height field over [-extent, extent] in x and z about `centre`, `cells` squares a side, facing up.
TriangleMesh terrain_mesh(glm::vec2 centre, float extent, int cells,
                          const std::function<float(glm::vec2)>& height);

}  // namespace ropsim
