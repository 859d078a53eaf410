// Packs painted meshes, and makes terrain.
#include "capture/scenes/painted_mesh.h"

#include "base/parallel.h"
#include "capture/scenery/scene_parts.h"
#include "capture/shader_sources.h"

#include <algorithm>

namespace ropsim {

SceneDraw painted_draw(const std::string& name, const TriangleMesh& mesh, const Paint& paint) {
    SceneDraw draw;
    draw.state.name = name;
    draw.vertex = shader_source("painted_vertex");
    draw.shading = shader_source("painted_shading");
    draw.primitives = mesh.triangles();
    draw.indices = mesh.indices;
    SceneBuffer vertices{1, std::vector<float>(12 * mesh.positions.size())};
    constexpr std::size_t kBatch = 1024;
    const auto batches = static_cast<int>((mesh.positions.size() + kBatch - 1) / kBatch);
    parallel_for(default_threads(), batches, [&](int batch) {
        const std::size_t first = static_cast<std::size_t>(batch) * kBatch;
        for (std::size_t i = first; i < std::min(first + kBatch, mesh.positions.size()); ++i) {
            const glm::vec3& p = mesh.positions[i];
            const glm::vec3& n = mesh.normals[i];
            const glm::vec4 c = paint(p, n);
            const float values[] = {p.x, p.y, p.z, c.w, n.x, n.y, n.z, 0, c.r, c.g, c.b, 1};
            std::copy(std::begin(values), std::end(values), &vertices.values[12 * i]);
        }
    });
    draw.buffers = {std::move(vertices)};
    draw.parameters = {glm::vec4(light_direction(), 0)};
    return draw;
}

TriangleMesh terrain_mesh(glm::vec2 centre, float extent, int cells,
                          const std::function<float(glm::vec2)>& height) {
    TriangleMesh mesh;
    const float step = 2 * extent / static_cast<float>(cells);
    for (int j = 0; j <= cells; ++j) {
        for (int i = 0; i <= cells; ++i) {
            const glm::vec2 at = centre - extent + step * glm::vec2(i, j);
            const float slope_x = height(at + glm::vec2(step, 0)) - height(at - glm::vec2(step, 0));
            const float slope_z = height(at + glm::vec2(0, step)) - height(at - glm::vec2(0, step));
            mesh.positions.emplace_back(at.x, height(at), at.y);
            mesh.normals.push_back(glm::normalize(glm::vec3(-slope_x, 2 * step, -slope_z)));
        }
    }
    const auto row = static_cast<std::uint32_t>(cells + 1);
    for (std::uint32_t j = 0; j + 1 < row; ++j) {
        for (std::uint32_t i = 0; i + 1 < row; ++i) {
            const std::uint32_t a = j * row + i;
            mesh.indices.insert(mesh.indices.end(), {a, a + row, a + 1, a + 1, a + row, a + row + 1});
        }
    }
    return mesh;
}

}  // namespace ropsim
