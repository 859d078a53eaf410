// What stands on the windy hill: a woman in a long dress with a scarf, a tree, rocks.
#pragma once

#include "capture/geometry/implicit_mesh.h"
#include "capture/scene.h"
#include "capture/scenery/light_volume.h"

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// Decimetres, in the space of the bust of hair_head.h: its feet are at kFeet.
inline constexpr float kFeet = -15.2f;
inline constexpr glm::vec3 kWind{0.906f, 0.0f, -0.423f};

// Height of the ground.
float hill_height(glm::vec2 at);

// Dress, arms and legs below the bust.
BlobBody figure_dress();
// The tree's trunk and branches; leaves grow around `crowns`: centres, and in w the radius.
BlobBody tree_wood();
std::vector<glm::vec4> tree_crowns();

// Woman, tree and rocks.
std::vector<SceneDraw> hill_models();

// A scarf of sheer woven cloth, two tails of it in the wind.
struct Scarf {
    std::vector<glm::vec3> points;  // rows of `across` points from the neck to the end
    std::uint32_t across = 0;
    std::uint32_t rows = 0;
};
Scarf scarf_tail(int tail);
SceneDraw scarf_draw(const std::string& name, const Scarf& scarf, const LightVolume& shadows);

}  // namespace ropsim
