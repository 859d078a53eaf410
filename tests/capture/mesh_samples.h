// A tetrahedron as a file of each mesh format, enough to go through all of its reader.
#pragma once

#include <cstdint>
#include <string>

#include <fmt/format.h>

namespace ropsim::testing {

template <typename T>
inline void put(std::string& bytes, T value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// Corners and faces of a tetrahedron.
inline constexpr float kCorners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
inline constexpr std::uint16_t kFaces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};

inline std::string obj_file() {
    std::string text = "o tetrahedron\n";
    for (const auto& c : kCorners) text += fmt::format("v {} {} {}\n", c[0], c[1], c[2]);
    text += "vn 0 0 1\nvt 0.5 0.5\n";
    for (const auto& f : kFaces)
        text += fmt::format("f {}/1/1 {}/1/1 {}/1/1\n", f[0] + 1, f[1] + 1, f[2] + 1);
    return text;
}

inline std::string ply_file() {
    std::string bytes =
        "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
        "property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n";
    for (const auto& c : kCorners)
        for (float value : c) put(bytes, value);
    for (const auto& f : kFaces) {
        put(bytes, std::uint8_t{3});
        for (std::uint16_t index : f) put(bytes, std::int32_t{index});
    }
    return bytes;
}

inline std::string stl_file() {
    std::string bytes(80, ' ');
    put(bytes, std::uint32_t{4});
    for (const auto& f : kFaces) {
        for (int i = 0; i < 3; ++i) put(bytes, 0.0f);
        for (std::uint16_t index : f)
            for (float value : kCorners[index]) put(bytes, value);
        put(bytes, std::uint16_t{0});
    }
    return bytes;
}

inline std::string chunk(std::uint16_t id, const std::string& content) {
    std::string bytes;
    put(bytes, id);
    put(bytes, static_cast<std::uint32_t>(content.size() + 6));
    return bytes + content;
}

inline std::string three_ds_file() {
    std::string vertices;
    put(vertices, std::uint16_t{4});
    for (const auto& c : kCorners)
        for (float value : c) put(vertices, value);
    std::string faces;
    put(faces, std::uint16_t{4});
    for (const auto& f : kFaces) {
        for (std::uint16_t index : f) put(faces, index);
        put(faces, std::uint16_t{0});
    }
    const std::string mesh = chunk(0x4100, chunk(0x4110, vertices) + chunk(0x4120, faces));
    const std::string object = chunk(0x4000, std::string("tetra\0", 6) + mesh);
    return chunk(0x4D4D, chunk(0x3D3D, object));
}

}  // namespace ropsim::testing
