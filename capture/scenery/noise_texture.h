// A texture of smooth random values.
#pragma once

#include "capture/scene.h"

#include <cstdint>

namespace ropsim {

// Repeating noise in [0, 1], 64 x 64, one channel: two octaves of seeded lattice values, 8 and 16 cells
// across.
SceneTexture noise_texture(std::uint64_t seed);

}  // namespace ropsim
