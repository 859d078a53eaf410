// Grows long hair on the bust of hair_head.h, as points in space.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

inline constexpr int kStrandPoints = 32;

struct HairStrands {
    std::vector<glm::vec3> points;     // kStrandPoints a strand, root first
    std::vector<std::uint32_t> locks;  // which lock each strand belongs to
};

// What makes loose hair fall as it does; lengths in decimetres, turns in radians a decimetre.
struct HairStyle {
    float length = 3.25f;  // of an average strand
    float layer = 0.172f;  // how high the uppermost hair lies
    float weight = 4.2f;   // how fast a strand turns downwards
    float sweep = 6.0f;    // and towards its place before the shoulders
    glm::vec3 wind{0.0f};  // and with the wind
    float gust = 0;        // how far locks sway in the wind, tip to tip
};

// `count` long strands in a pure function of (seed, index): the first n strands are the same for every count.
HairStrands grow_hair(std::uint32_t count, std::uint64_t seed, const HairStyle& style = {});

}  // namespace ropsim
