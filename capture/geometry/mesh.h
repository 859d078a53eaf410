// Triangle meshes: read from files, or made from simple shapes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

struct TriangleMesh {
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;      // one a position, unit length
    std::vector<std::uint32_t> indices;  // three a triangle

    std::uint32_t triangles() const { return static_cast<std::uint32_t>(indices.size() / 3); }
};

// Reads any format that Assimp knows (.obj, .3ds, .ply, .stl, .gltf, ...), all its meshes with their node
// transforms. Absent normals are computed. The result is centred on the origin and its longest side is 1; +y
// is up as in the file. Throws UserError when the file is missing, unreadable, or holds no triangles. Assimp
// runs in a process of its own (base/isolated_call.h): call this before there is an OpenGL context.
TriangleMesh load_mesh(const std::string& path);

// Radius 1, about the origin; `rings` >= 2 bands of latitude.
TriangleMesh sphere_mesh(int rings);
// From -1 to 1 along each axis, flat faces.
TriangleMesh box_mesh();

}  // namespace ropsim
