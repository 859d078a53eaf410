// A procedural garden: a table with a potted plant on a patio, lawn, hedges, trees and a house, in splats.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// One Gaussian on a surface of the garden. Metres, +y up; colours linear.
struct GardenSplat {
    glm::vec3 position{0.0f};
    glm::vec3 normal{0, 1, 0};   // unit length
    glm::vec3 tangent{1, 0, 0};  // unit length, across the normal
    glm::vec2 spread{0.01f};     // standard deviations along the tangent and across it
    float thickness = 0.1f;      // standard deviation along the normal, as a fraction of the smaller spread
    float opacity = 0.9f;
    glm::vec3 albedo{0.5f};
    float gloss = 0.0f;         // how much brighter towards the mirror image of the sun
    float translucence = 0.0f;  // share of the light that comes through from behind: leaves
    float occlusion = 0.0f;     // share of the light kept away by matter about it
};

// Splat `index` of a part of the garden, as large as `count` of them need; `key` is its own random key,
// `seed` the garden's.
using GardenSampler = GardenSplat (*)(std::uint64_t key, std::uint32_t index, std::uint32_t count,
                                      std::uint64_t seed);

struct GardenPart {
    double share;  // of all splats
    GardenSampler sample;
};

// Table, vase, patio, house, ground and sky; and what grows. Shares of both lists sum to 1.
std::vector<GardenPart> garden_surfaces();
std::vector<GardenPart> garden_plants();

// Where the patio ends and the lawn begins: half its side.
inline constexpr float kPatioHalf = 2.6f;

// A random number in [0, 1) for every cell.
float garden_lattice(glm::ivec3 cell);

// Smooth noise in [0, 1]; one unit is about the size of its features.
float garden_noise(glm::vec3 at);

// Two low-discrepancy coordinates in [0, 1) (the additive sequence of the plastic number).
glm::vec2 even_point(std::uint32_t index);

// A random unit vector from draws `draw` and `draw` + 1.
glm::vec3 random_direction(std::uint64_t key, std::uint32_t draw);

// Standard normal, from draws `draw` and `draw` + 1.
float random_normal(std::uint64_t key, std::uint32_t draw);

// What training gives splats of a surface whose centres are `spacing` apart: log-normal sizes, elongated,
// most of them opaque, some large and faint. Fills spread, opacity and a turned tangent from draws 40 and up.
void dress_surface(GardenSplat& splat, std::uint64_t key, float spacing);

// The same for a leaf of about `size`: about twice as long as wide, lit through.
void dress_leaf(GardenSplat& splat, std::uint64_t key, float size);

// Any unit vector across `normal`.
glm::vec3 across(glm::vec3 normal);

}  // namespace ropsim
