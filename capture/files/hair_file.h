// Reads strands of hair from Cem Yuksel's .hair files ("HAIR model files",
// cemyuksel.com/research/hairmodels).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// All strands of a file, with its defaults filled in where it has no array. The points of strand i are
// first_points[i] up to first_points[i + 1]; each strand has at least two.
struct HairFile {
    std::vector<std::size_t> first_points;  // one more than strands
    std::vector<glm::vec3> points;          // as in the file: Yuksel's models have +z up, in no given unit
    std::vector<float> thickness;           // one a point, >= 0, units of the points
    std::vector<float> transparency;        // one a point, 0 (opaque) to 1
    std::vector<glm::vec3> colors;          // one a point, 0 to 1, linear
    std::string info;                       // the file's own words about itself

    std::size_t strands() const { return first_points.empty() ? 0 : first_points.size() - 1; }
};

// Parses a file's bytes; `name` is for messages. Strands of a single point (0 segments) are left out.
// Throws UserError, saying which field or which byte: not a .hair file, counts that do not agree with each
// other or with the number of bytes, values that are not finite or out of range, no strand to draw. Memory
// is bounded by a small multiple of the bytes given.
HairFile parse_hair(std::span<const std::uint8_t> bytes, const std::string& name);

// The same from a file; also throws when it cannot be read.
HairFile load_hair(const std::string& path);

}  // namespace ropsim
