// Pieces that scenes share: instanced meshes, materials, the camera.
#pragma once

#include "capture/geometry/mesh.h"
#include "capture/scene.h"

#include <string>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// Where a copy of a mesh stands. `color` is linear; its alpha is the material's: opacity of glass, side of a
// checker square for matte (0: plain).
struct MeshInstance {
    glm::mat4 model{1.0f};  // rotation, scale per axis, translation
    glm::vec4 color{1.0f};
};

// Direction towards the light, unit length, the same in every scene.
glm::vec3 light_direction();

// Opaque copies of a mesh, diffuse.
SceneDraw matte_draw(const std::string& name, const TriangleMesh& mesh,
                     const std::vector<MeshInstance>& instances);
// Translucent copies of a mesh: a coloured film, denser and shinier where seen edge-on.
SceneDraw glass_draw(const std::string& name, const TriangleMesh& mesh,
                     const std::vector<MeshInstance>& instances);

// A perspective camera at `eye` looking at `target`, which sees at least `fovy_degrees` from top to bottom
// and `min_aspect` times as much from side to side.
Camera look_at(glm::vec3 eye, glm::vec3 target, float fovy_degrees, double aspect, double min_aspect,
               float near_plane, float far_plane);

// The view of a distant light in direction `to_light` (unit length) on the ball of `radius` about `centre`:
// orthographic, square (fovy_degrees 0), with the ball between its near and far planes.
Camera light_camera(glm::vec3 to_light, glm::vec3 centre, float radius);

glm::mat4 placed(glm::vec3 position, glm::vec3 scale, float yaw = 0, float pitch = 0);

}  // namespace ropsim
