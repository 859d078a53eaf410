// Grooms fur onto the dog.
#pragma once

#include "capture/geometry/mesh.h"
#include "capture/scenes/hair_draw.h"

#include <cstdint>
#include <vector>

namespace ropsim {

// `count` hairs over the whole skin, evenly by area, in groups by how they are modelled: short fur, coat and
// feathering. A hair is a pure function of (seed, index).
std::vector<StrandGroup> groom_dog(const TriangleMesh& skin, std::uint32_t count, std::uint64_t seed);

// Frays patches of colour: smooth noise in [-1, 1] over the body.
float dog_noise(glm::vec3 position);

}  // namespace ropsim
