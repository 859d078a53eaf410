// Meshes put together from many parts, each vertex with its colour, finish and the sunlight that reaches it.
#pragma once

#include "capture/geometry/mesh.h"
#include "capture/scene.h"
#include "capture/scenery/daylight.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// What a surface is like, as capture/shaders/scenery_shading.glsl numbers it.
enum class Finish { kGlowing = -1, kPlain = 0, kBricks = 1, kGround = 2, kLacquer = 3 };

struct SceneryVertex {
    glm::vec3 position;
    float light = 1;  // share of the sunlight that arrives
    glm::vec3 normal;
    float finish = 0;
    glm::vec4 color;  // linear; alpha is used where the mesh is translucent
};
static_assert(sizeof(SceneryVertex) == 12 * sizeof(float));

struct SceneryMesh {
    std::vector<SceneryVertex> vertices;
    std::vector<std::uint32_t> indices;

    std::uint32_t triangles() const { return static_cast<std::uint32_t>(indices.size() / 3); }
    void add(const TriangleMesh& mesh, const glm::mat4& model, glm::vec4 color,
             Finish finish = Finish::kPlain);
    // Corners in order around, lower left first as seen from where the normal points; cut into
    // columns x rows pieces of two triangles.
    void add_quad(glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d, glm::vec4 color,
                  Finish finish = Finish::kPlain, int columns = 1, int rows = 1);
    // An upright box of these half sizes, turned by `yaw` radians about its middle.
    void add_box(glm::vec3 centre, glm::vec3 half, glm::vec4 color, Finish finish = Finish::kPlain,
                 float yaw = 0);
    // Everything of `other`, moved by a rotation, a uniform scale and a translation.
    void add(const SceneryMesh& other, const glm::mat4& model);
    // Sets every vertex's light to light(position, normal), on all cores.
    void illuminate(const std::function<float(glm::vec3, glm::vec3)>& light);
};

// Opaque; `seed` decides the noise on its surfaces.
SceneDraw scenery_draw(const std::string& name, const SceneryMesh& mesh, const Daylight& daylight,
                       std::uint64_t seed);
// Translucent panes and shells; colour and alpha of the vertices, finish ignored.
SceneDraw film_draw(const std::string& name, const SceneryMesh& mesh, const Daylight& daylight);

}  // namespace ropsim
