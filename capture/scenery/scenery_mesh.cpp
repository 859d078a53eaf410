// Painted meshes: putting together, lighting, draws.
#include "capture/scenery/scenery_mesh.h"

#include "base/parallel.h"
#include "capture/scenery/noise_texture.h"
#include "capture/scenery/scene_parts.h"
#include "capture/shader_sources.h"

#include <algorithm>
#include <cstring>

namespace ropsim {
namespace {

SceneDraw mesh_draw(const std::string& name, const SceneryMesh& mesh, const Daylight& daylight,
                    const char* shading) {
    SceneDraw draw;
    draw.state.name = name;
    draw.vertex = shader_source("scenery_vertex");
    draw.shading = std::string(shader_source("daylight")) + std::string(shader_source(shading));
    draw.primitives = mesh.triangles();
    draw.indices = mesh.indices;
    draw.parameters = daylight_parameters(daylight);
    SceneBuffer buffer{1, std::vector<float>(12 * mesh.vertices.size())};
    if (!mesh.vertices.empty())
        std::memcpy(buffer.values.data(), mesh.vertices.data(), mesh.vertices.size() * sizeof(SceneryVertex));
    draw.buffers.push_back(std::move(buffer));
    return draw;
}

}  // namespace

void SceneryMesh::add(const TriangleMesh& mesh, const glm::mat4& model, glm::vec4 color, Finish finish) {
    const auto base = static_cast<std::uint32_t>(vertices.size());
    const glm::mat3 turn = glm::transpose(glm::inverse(glm::mat3(model)));
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
        vertices.push_back({glm::vec3(model * glm::vec4(mesh.positions[i], 1.0f)), 1.0f,
                            glm::normalize(turn * mesh.normals[i]), static_cast<float>(finish), color});
    }
    for (std::uint32_t index : mesh.indices) indices.push_back(base + index);
}

void SceneryMesh::add_quad(glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d, glm::vec4 color, Finish finish,
                           int columns, int rows) {
    const auto base = static_cast<std::uint32_t>(vertices.size());
    const glm::vec3 normal = glm::normalize(glm::cross(c - a, d - b));
    for (int row = 0; row <= rows; ++row) {
        for (int column = 0; column <= columns; ++column) {
            const float u = static_cast<float>(column) / static_cast<float>(columns);
            const float v = static_cast<float>(row) / static_cast<float>(rows);
            const glm::vec3 position = glm::mix(glm::mix(a, b, u), glm::mix(d, c, u), v);
            vertices.push_back({position, 1.0f, normal, static_cast<float>(finish), color});
        }
    }
    const auto stride = static_cast<std::uint32_t>(columns + 1);
    for (std::uint32_t row = 0; row < static_cast<std::uint32_t>(rows); ++row) {
        for (std::uint32_t column = 0; column + 1 < stride; ++column) {
            const std::uint32_t v = base + row * stride + column;
            indices.insert(indices.end(), {v, v + 1, v + stride, v + 1, v + stride + 1, v + stride});
        }
    }
}

void SceneryMesh::add_box(glm::vec3 centre, glm::vec3 half, glm::vec4 color, Finish finish, float yaw) {
    static const TriangleMesh box = box_mesh();
    add(box, placed(centre, half, yaw), color, finish);
}

void SceneryMesh::add(const SceneryMesh& other, const glm::mat4& model) {
    const auto base = static_cast<std::uint32_t>(vertices.size());
    for (SceneryVertex vertex : other.vertices) {
        vertex.position = glm::vec3(model * glm::vec4(vertex.position, 1.0f));
        vertex.normal = glm::normalize(glm::mat3(model) * vertex.normal);
        vertices.push_back(vertex);
    }
    for (std::uint32_t index : other.indices) indices.push_back(base + index);
}

void SceneryMesh::illuminate(const std::function<float(glm::vec3, glm::vec3)>& light) {
    constexpr std::size_t kBatch = 1024;
    const auto batches = static_cast<int>((vertices.size() + kBatch - 1) / kBatch);
    parallel_for(default_threads(), batches, [&](int batch) {
        const std::size_t first = static_cast<std::size_t>(batch) * kBatch;
        for (std::size_t i = first; i < std::min(first + kBatch, vertices.size()); ++i)
            vertices[i].light = light(vertices[i].position, vertices[i].normal);
    });
}

SceneDraw scenery_draw(const std::string& name, const SceneryMesh& mesh, const Daylight& daylight,
                       std::uint64_t seed) {
    SceneDraw draw = mesh_draw(name, mesh, daylight, "scenery_shading");
    draw.textures.push_back(noise_texture(seed));
    return draw;
}

SceneDraw film_draw(const std::string& name, const SceneryMesh& mesh, const Daylight& daylight) {
    return mesh_draw(name, mesh, daylight, "scenery_film_shading");
}

}  // namespace ropsim
