// 3D Gaussian splats: what a trained capture consists of, and the .ply files that hold one.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

namespace ropsim {

// Anisotropic Gaussians as in "3D Gaussian splatting" (Kerbl et al. 2023). All vectors have one element a
// splat, `harmonics` has harmonics_a_splat() of them.
struct SplatFile {
    int degree = 0;                    // of the spherical harmonics, 0 to 3
    std::vector<glm::vec3> positions;  // centres, scene units
    std::vector<glm::vec3> scales;     // standard deviations along the splat's own axes, scene units
    std::vector<glm::quat> rotations;  // unit length, own axes to world
    std::vector<float> opacities;      // at the centre, 0 to 1
    // Coefficients of the display-referred (sRGB) colour less 0.5, in the basis and order of the reference
    // code.
    std::vector<glm::vec3> harmonics;

    std::size_t size() const { return positions.size(); }
    std::size_t harmonics_a_splat() const {
        return static_cast<std::size_t>(degree + 1) * static_cast<std::size_t>(degree + 1);
    }
};

// Reads what the reference implementation writes: binary_little_endian PLY whose first element, `vertex`, has
// the properties x, y, z, f_dc_0..2, f_rest_* (0, 9, 24 or 45 of them: red's, then green's, then blue's),
// opacity (logit), scale_0..2 (logarithm) and rot_0..3 (w, x, y, z; any length but 0), as float or double, in
// any order, among any others of scalar type. `name` is the file's, for messages. Throws UserError, naming
// the line, or the splat and the property, for everything else; allocates nothing that the bytes do not hold.
SplatFile parse_splats(std::span<const std::uint8_t> bytes, const std::string& name);

// parse_splats() of a file. Throws UserError also when it cannot be read.
SplatFile load_splats(const std::string& path);

// Whether the file is a PLY whose header names f_dc_0 and scale_0, as no mesh does. False when unreadable.
bool is_splat_ply(const std::string& path);

}  // namespace ropsim
