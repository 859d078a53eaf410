// Smoke that rises from a fire, as puffs on cards.
#pragma once

#include "capture/geometry/turbulence.h"
#include "capture/scenery/card_draw.h"
#include "capture/scenery/light_volume.h"

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

struct SmokeColumn {
    glm::vec3 source;
    glm::vec3 drift;    // from the source to where the column ends, metres
    float bend = 1.7f;  // how late the wind takes hold: exponent of the sideways way
    float from_radius;  // of the column at its source and its end
    float to_radius;
    float crowding = 1;  // of puffs at the source: exponent of their way along the column
    float puff = 0.5f;   // radius of a puff at the column's middle
    int billows = 60;    // clumps of puffs
    double puffs = 500;  // at scale 1
    float alpha = 0.1f;  // of a puff's middle
    glm::vec3 color{0.5f};
};

// `count` puffs of the column, camera-facing (`across` and `up`: the camera's axes); the first n are the same
// for every count.
std::vector<Card> make_puffs(const SmokeColumn& column, std::uint32_t count, const Turbulence& turbulence,
                             glm::vec3 across, glm::vec3 up, std::uint64_t seed);

// Puffs' matter, each `share` of its own (where more or fewer puffs than at scale 1 make the same smoke).
void deposit_puffs(const std::vector<Card>& puffs, float share, LightVolume& volume);

// Density of a puff: billowing noise that fades to nothing at a circle.
SceneTexture puff_texture(std::uint64_t seed);

}  // namespace ropsim
