// Trees and bushes: solid wood, and cards for their twigs.
#pragma once

#include "capture/scenery/card_draw.h"
#include "capture/scenery/light_volume.h"
#include "capture/scenery/scenery_mesh.h"

#include <cstdint>
#include <vector>

namespace ropsim {

struct TreeForm {
    float height = 8;            // metres
    float trunk_radius = 0.16f;  // at the foot; 0: a bush, no wood at all
    float crown_from = 0.3f;     // where the crown begins, share of the height
    float crown_radius = 2.2f;
    int branches = 14;
    bool conifer = false;    // branches in a cone, drooping, instead of clumps in a ball
    int cards = 300;         // twigs
    float card_size = 0.5f;  // half side of a twig's card
    glm::vec3 bark{0.16f, 0.11f, 0.08f};
};

// Grows one tree with its foot at `foot`: its wood is added to `wood`, its twigs to `twigs` in order of
// growth. A pure function of (form, foot, seed), and the first n twigs are the same for every number.
void grow_tree(const TreeForm& form, glm::vec3 foot, std::uint64_t seed, SceneryMesh& wood,
               std::vector<Card>& twigs);

// What cards are to sunlight: as much matter as `cover` of their area.
void deposit_cards(const std::vector<Card>& cards, float cover, LightVolume& volume);
// Light that arrives at each card, and how it faces the sun.
void illuminate_cards(std::vector<Card>& cards, const LightVolume& volume, float strength);

}  // namespace ropsim
