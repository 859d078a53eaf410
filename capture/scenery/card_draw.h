// Textured rectangles: leaf cards, wire fence, puffs of smoke.
#pragma once

#include "capture/scene.h"
#include "capture/scenery/daylight.h"

#include <cstdint>
#include <string>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

struct Card {
    glm::vec3 centre;
    float light = 1;    // share of the sunlight that arrives
    glm::vec3 right;    // from the centre to the middle of the right edge
    float columns = 1;  // how often the texture repeats across; negative: mirrored
    glm::vec3 up;       // from the centre to the middle of the upper edge
    float rows = 1;
    glm::vec4 color{1.0f};  // times the texture's; linear, straight
};
static_assert(sizeof(Card) == 16 * sizeof(float));

// Colour and coverage from a texture of four channels; coverage below 1/255 is no fragment. `fades`: cards
// seen edge-on vanish, as leaves should, instead of blurring into streaks.
SceneDraw cutout_draw(const std::string& name, const std::vector<Card>& cards, SceneTexture texture,
                      const Daylight& daylight, bool fades);
// Puffs: density from a texture of one channel; below 1/512 is no fragment. `roundness` in [0, 1]: how much
// lighter the side towards the sun is.
SceneDraw smoke_draw(const std::string& name, const std::vector<Card>& cards, SceneTexture texture,
                     const Daylight& daylight, float roundness);

// The same cards in a random order that `seed` decides.
void shuffle_cards(std::vector<Card>& cards, std::uint64_t seed);

}  // namespace ropsim
