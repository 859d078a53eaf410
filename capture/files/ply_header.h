// The header of a binary PLY file whose vertices consist of scalars.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace ropsim {

enum class PlyScalar { kFloat, kDouble, kOther };

struct PlyProperty {
    std::string name;
    std::size_t offset = 0;  // in the vertex, bytes
    PlyScalar scalar = PlyScalar::kOther;
};

struct PlyHeader {
    std::uint64_t count = 0;  // vertices
    std::size_t stride = 0;   // bytes a vertex
    std::size_t bytes = 0;    // of the header itself
    bool more_after = false;  // other elements follow the vertices
    std::vector<PlyProperty> properties;
};

// Longer headers are refused.
inline constexpr std::size_t kMaxPlyHeaderBytes = 65536;

// Reads the header at the beginning of `text`; the first element must be `vertex`, with scalar properties of
// different names. Others are not looked into. `name` is the file's, for messages. Throws UserError, naming
// the line.
PlyHeader parse_ply_header(std::string_view text, const std::string& name);

}  // namespace ropsim
