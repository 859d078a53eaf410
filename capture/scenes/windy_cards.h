// Cards of grass, flowers and leaves for the windy hill.
#pragma once

#include "capture/scene.h"

#include <cstdint>
#include <string>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

inline constexpr int kCardColumns = 4;  // of the atlas: two of grass, one with flowers, one of leaves

struct PlantCard {
    glm::vec3 base{0.0f};
    float width = 1;
    float yaw = 0;
    float height = 1;
    float bend = 0;  // how far the upper edge leans with the wind, of the height
    int column = 0;
    glm::vec4 tint{1.0f};  // linear; w: share of the sunlight that arrives
};

// The atlas: straight colour and alpha, kCardColumns pictures side by side, feet at the bottom.
SceneTexture plant_atlas(std::uint64_t seed);

// The cards in their order, six triangles each; `wind` is a unit vector.
SceneDraw plant_card_draw(const std::string& name, const std::vector<PlantCard>& cards,
                          const SceneTexture& atlas, glm::vec3 wind);

}  // namespace ropsim
