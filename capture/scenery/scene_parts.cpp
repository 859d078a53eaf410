// Pieces that scenes share.
#include "capture/scenery/scene_parts.h"

#include "capture/shader_sources.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

SceneDraw mesh_draw(const std::string& name, const TriangleMesh& mesh,
                    const std::vector<MeshInstance>& instances) {
    SceneDraw draw;
    draw.state.name = name;
    draw.vertex = shader_source("mesh_vertex");
    draw.primitives = mesh.triangles();
    draw.instances = static_cast<std::uint32_t>(instances.size());
    draw.indices = mesh.indices;
    SceneBuffer vertices{1, {}};
    vertices.values.reserve(mesh.positions.size() * 8);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        const glm::vec3& p = mesh.positions[i];
        const glm::vec3& n = mesh.normals[i];
        vertices.values.insert(vertices.values.end(), {p.x, p.y, p.z, 1.0f, n.x, n.y, n.z, 0.0f});
    }
    SceneBuffer placements{2, {}};
    for (const MeshInstance& instance : instances) {
        for (int column = 0; column < 4; ++column) {
            const glm::vec4& v = instance.model[column];
            placements.values.insert(placements.values.end(), {v.x, v.y, v.z, v.w});
        }
        const glm::vec4& c = instance.color;
        placements.values.insert(placements.values.end(), {c.x, c.y, c.z, c.w});
    }
    draw.buffers = {std::move(vertices), std::move(placements)};
    draw.parameters = {glm::vec4(light_direction(), 0)};
    return draw;
}

}  // namespace

glm::vec3 light_direction() {
    return glm::normalize(glm::vec3(0.5f, 0.8f, 0.45f));
}

SceneDraw matte_draw(const std::string& name, const TriangleMesh& mesh,
                     const std::vector<MeshInstance>& instances) {
    SceneDraw draw = mesh_draw(name, mesh, instances);
    draw.shading = shader_source("matte_shading");
    return draw;
}

SceneDraw glass_draw(const std::string& name, const TriangleMesh& mesh,
                     const std::vector<MeshInstance>& instances) {
    SceneDraw draw = mesh_draw(name, mesh, instances);
    draw.shading = shader_source("glass_shading");
    return draw;
}

Camera look_at(glm::vec3 eye, glm::vec3 target, float fovy_degrees, double aspect, double min_aspect,
               float near_plane, float far_plane) {
    Camera camera;
    const double half =
        std::tan(glm::radians(static_cast<double>(fovy_degrees)) / 2) * std::max(1.0, min_aspect / aspect);
    const auto fovy = static_cast<float>(2 * std::atan(half));
    camera.view = glm::lookAt(eye, target, glm::vec3(0, 1, 0));
    camera.projection = glm::perspective(fovy, static_cast<float>(aspect), near_plane, far_plane);
    camera.near_plane = near_plane;
    camera.far_plane = far_plane;
    camera.fovy_degrees = glm::degrees(fovy);
    return camera;
}

Camera light_camera(glm::vec3 to_light, glm::vec3 centre, float radius) {
    Camera camera;
    const glm::vec3 up = std::abs(to_light.y) > 0.99f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
    camera.near_plane = radius;
    camera.far_plane = 3 * radius;
    camera.view = glm::lookAt(centre + 2 * radius * to_light, centre, up);
    camera.projection = glm::ortho(-radius, radius, -radius, radius, camera.near_plane, camera.far_plane);
    return camera;
}

glm::mat4 placed(glm::vec3 position, glm::vec3 scale, float yaw, float pitch) {
    glm::mat4 model = glm::translate(glm::mat4(1.0f), position);
    model = glm::rotate(model, yaw, glm::vec3(0, 1, 0));
    model = glm::rotate(model, pitch, glm::vec3(0, 0, 1));
    return glm::scale(model, scale);
}

}  // namespace ropsim
