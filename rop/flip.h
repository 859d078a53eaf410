// FLIP: the difference that a viewer sees when flipping between two images.
#pragma once

#include "rop/plane.h"

#include <array>

namespace ropsim {

using ColorPlanes = std::array<Plane<float>, 3>;  // R, G, B, linear (sRGB primaries), in [0, 1]

// Mean of LDR-FLIP (Andersson et al. 2020) in [0, 1], 67 pixels per degree of visual angle. Both images have
// the same size, at least one pixel.
double mean_flip(const ColorPlanes& image, const ColorPlanes& reference);

}  // namespace ropsim
