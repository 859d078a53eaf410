// Mesh loading through Assimp, and the simple shapes.
#include "capture/mesh.h"

#include "base/error.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

glm::vec3 to_glm(const aiVector3D& v) {
    return {v.x, v.y, v.z};
}

bool finite(const glm::vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

void append(TriangleMesh& result, const aiMesh& mesh, const std::string& path) {
    const auto base = static_cast<std::uint32_t>(result.positions.size());
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
        const glm::vec3 position = to_glm(mesh.mVertices[i]);
        if (!finite(position)) throw UserError(path, "a vertex is not finite; repair the mesh");
        glm::vec3 normal = mesh.HasNormals() ? to_glm(mesh.mNormals[i]) : glm::vec3(0);
        const float length = glm::length(normal);
        // Degenerate triangles have no normal; any will do.
        normal = length > 0.0f && std::isfinite(length) ? normal / length : glm::vec3(0, 1, 0);
        result.positions.push_back(position);
        result.normals.push_back(normal);
    }
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
        const aiFace& face = mesh.mFaces[i];
        if (face.mNumIndices != 3) continue;
        for (unsigned k = 0; k < 3; ++k) result.indices.push_back(base + face.mIndices[k]);
    }
}

void normalise(TriangleMesh& mesh, const std::string& path) {
    glm::vec3 low(std::numeric_limits<float>::infinity());
    glm::vec3 high = -low;
    for (std::uint32_t index : mesh.indices) {
        low = glm::min(low, mesh.positions[index]);
        high = glm::max(high, mesh.positions[index]);
    }
    const glm::vec3 size = high - low;
    const float longest = std::max({size.x, size.y, size.z});
    if (!(longest > 0.0f) || !std::isfinite(longest)) {
        throw UserError(path, "all triangles lie in one point; nothing can be drawn");
    }
    for (glm::vec3& position : mesh.positions) position = (position - 0.5f * (low + high)) / longest;
}

}  // namespace

TriangleMesh load_mesh(const std::string& path) {
    if (!std::filesystem::exists(path)) {
        throw UserError(path,
                        "no such mesh file (the built-in horse and bunny come with Debian's glmark2-data)");
    }
    Assimp::Importer importer;
    importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    const aiScene* scene = importer.ReadFile(
        path, aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices |
                  aiProcess_JoinIdenticalVertices | aiProcess_GenSmoothNormals);
    if (scene == nullptr) {
        std::string reason = importer.GetErrorString();
        std::replace(reason.begin(), reason.end(), '\n', ' ');
        throw UserError(
            path,
            fmt::format("not a mesh that can be read ({}); give an .obj, .ply, .stl, .3ds or .gltf", reason));
    }
    TriangleMesh result;
    for (unsigned i = 0; i < scene->mNumMeshes; ++i) append(result, *scene->mMeshes[i], path);
    if (result.indices.empty()) throw UserError(path, "holds no triangles; give a mesh with faces");
    normalise(result, path);
    return result;
}

TriangleMesh sphere_mesh(int rings) {
    TriangleMesh mesh;
    const int sectors = 2 * rings;
    for (int ring = 0; ring <= rings; ++ring) {
        const float theta = glm::pi<float>() * static_cast<float>(ring) / static_cast<float>(rings);
        for (int sector = 0; sector <= sectors; ++sector) {
            const float phi = glm::two_pi<float>() * static_cast<float>(sector) / static_cast<float>(sectors);
            mesh.normals.emplace_back(std::sin(theta) * std::cos(phi), std::cos(theta),
                                      std::sin(theta) * std::sin(phi));
        }
    }
    mesh.positions = mesh.normals;
    const auto row = static_cast<std::uint32_t>(sectors + 1);
    for (std::uint32_t ring = 0; ring < static_cast<std::uint32_t>(rings); ++ring) {
        for (std::uint32_t sector = 0; sector + 1 < row; ++sector) {
            const std::uint32_t a = ring * row + sector;
            mesh.indices.insert(mesh.indices.end(), {a, a + 1, a + row, a + 1, a + row + 1, a + row});
        }
    }
    return mesh;
}

TriangleMesh box_mesh() {
    TriangleMesh mesh;
    for (int axis = 0; axis < 3; ++axis) {
        for (float side : {-1.0f, 1.0f}) {
            glm::vec3 normal(0);
            normal[axis] = side;
            glm::vec3 u(0);
            u[(axis + 1) % 3] = 1;
            const glm::vec3 v = glm::cross(normal, u);
            const auto base = static_cast<std::uint32_t>(mesh.positions.size());
            for (const glm::vec3& corner : {normal - u - v, normal + u - v, normal + u + v, normal - u + v}) {
                mesh.positions.push_back(corner);
                mesh.normals.push_back(normal);
            }
            mesh.indices.insert(mesh.indices.end(), {base, base + 1, base + 2, base, base + 2, base + 3});
        }
    }
    return mesh;
}

}  // namespace ropsim
