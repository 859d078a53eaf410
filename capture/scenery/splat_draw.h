// Draws 3D Gaussian splats: elliptical weighted average splatting, one quad a splat.
#pragma once

#include "capture/files/splat_file.h"
#include "capture/scene.h"

#include <string>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// Draws of all splats in their order (more than one where a GPU buffer does not hold all), named `name`, as
// "3D Gaussian splatting" (Kerbl et al. 2023, section 4, and its reference rasteriser) draws them: the
// covariance through the projection's Jacobian, 0.3 square pixels added to both of its diagonal elements, the
// quad as large as alpha reaches 1/255, alpha = min(0.99, opacity * exp(-d / 2)) with d the squared
// Mahalanobis distance, nothing below 1/255. Every fragment has the depth of the splat's centre. Deviations:
// colours, which training found for blending display-referred values, are made linear, as everything that a
// trace blends; and nothing is sorted. Colours are those seen from `eye` (in the splats' world).
std::vector<SceneDraw> splat_draws(const std::string& name, const SplatFile& splats, glm::vec3 eye);

// Linear colour of a splat in direction `direction` (unit length, from the eye to the splat); `harmonics`
// points to its coefficients. At least 0, above 1 where it is brighter than white.
glm::vec3 splat_color(const glm::vec3* harmonics, int degree, glm::vec3 direction);

// The splats of `source`, about `count` times as many: a seeded choice of them, or with clones, which stand
// off their originals by up to half a standard deviation.
SplatFile thinned_or_cloned(const SplatFile& source, double count, std::uint64_t seed);

}  // namespace ropsim
