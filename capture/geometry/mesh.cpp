// Mesh loading through Assimp, and the simple shapes.
#include "capture/geometry/mesh.h"

#include "base/error.h"
#include "base/isolated_call.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string_view>

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
        for (unsigned k = 0; k < 3; ++k) {
            if (face.mIndices[k] >= mesh.mNumVertices)
                throw UserError(path,
                                "a triangle refers to a vertex that the mesh does not have; repair the mesh");
            result.indices.push_back(base + face.mIndices[k]);
        }
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

TriangleMesh read_with_assimp(const std::string& path) {
    Assimp::Importer importer;
    importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    const aiScene* scene = importer.ReadFile(
        path, aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices |
                  aiProcess_JoinIdenticalVertices | aiProcess_GenSmoothNormals);
    if (scene == nullptr) {
        throw UserError(
            path, fmt::format("not a mesh that can be read ({}); give an .obj, .ply, .stl, .3ds or .gltf",
                              importer.GetErrorString()));
    }
    TriangleMesh result;
    for (unsigned i = 0; i < scene->mNumMeshes; ++i) append(result, *scene->mMeshes[i], path);
    if (result.indices.empty()) throw UserError(path, "holds no triangles; give a mesh with faces");
    normalise(result, path);
    return result;
}

// Assimp 5.2 reads a .ply without the end of its header for ever.
void expect_whole_ply_header(const std::string& path) {
    constexpr std::size_t kLongestHeader = 65536;
    std::ifstream file(path, std::ios::binary);
    std::string start(kLongestHeader, '\0');
    file.read(start.data(), static_cast<std::streamsize>(start.size()));
    start.resize(static_cast<std::size_t>(file.gcount()));
    if (start.starts_with("ply") && start.find("end_header") == std::string::npos)
        throw UserError(
            path, "not a mesh that can be read (its .ply header has no end_header); the file is cut short");
}

template <typename T>
void put(std::string& bytes, const std::vector<T>& values) {
    const std::uint64_t count = values.size();
    bytes.append(reinterpret_cast<const char*>(&count), sizeof count);
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

template <typename T>
bool take(std::string_view& bytes, std::vector<T>& values) {
    std::uint64_t count = 0;
    if (bytes.size() < sizeof count) return false;
    std::memcpy(&count, bytes.data(), sizeof count);
    bytes.remove_prefix(sizeof count);
    if (count > bytes.size() / sizeof(T)) return false;
    values.resize(count);
    if (count > 0) std::memcpy(values.data(), bytes.data(), count * sizeof(T));
    bytes.remove_prefix(count * sizeof(T));
    return true;
}

// Whether the mesh is what load_mesh() promises: a reader that a malformed file led astray may have spoilt it
// before it was sent.
bool sound(const TriangleMesh& mesh) {
    const auto inside = [&](std::uint32_t index) { return index < mesh.positions.size(); };
    const auto bounded = [](const glm::vec3& v) { return finite(v) && glm::length(v) < 2.0f; };
    return !mesh.indices.empty() && mesh.indices.size() % 3 == 0 &&
           mesh.normals.size() == mesh.positions.size() &&
           std::all_of(mesh.indices.begin(), mesh.indices.end(), inside) &&
           std::all_of(mesh.normals.begin(), mesh.normals.end(), bounded) &&
           std::all_of(mesh.positions.begin(), mesh.positions.end(), finite);
}

}  // namespace

TriangleMesh load_mesh(const std::string& path) {
    if (!std::filesystem::exists(path)) {
        throw UserError(path,
                        "no such mesh file (the built-in horse and bunny come with Debian's glmark2-data)");
    }
    if (!std::filesystem::is_regular_file(path))
        throw UserError(path, "is not a regular file; a mesh is wanted");
    expect_whole_ply_header(path);
    IsolationLimits limits;
    // Assimp reads some 10 MiB a second.
    limits.cpu_seconds = 5 + static_cast<int>(std::filesystem::file_size(path) >> 20);
    limits.wait_seconds = 60 + 10 * limits.cpu_seconds;
    const std::string sent = call_isolated(path, limits, [&path] {
        const TriangleMesh mesh = read_with_assimp(path);
        std::string bytes;
        put(bytes, mesh.positions);
        put(bytes, mesh.normals);
        put(bytes, mesh.indices);
        return bytes;
    });
    std::string_view bytes = sent;
    TriangleMesh mesh;
    const bool whole = take(bytes, mesh.positions) && take(bytes, mesh.normals) &&
                       take(bytes, mesh.indices) && bytes.empty();
    if (!whole || !sound(mesh)) throw UserError(path, "its reader failed; the file is malformed");
    return mesh;
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
