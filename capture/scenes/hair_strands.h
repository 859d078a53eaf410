// Grows strands of hair on a head, as points in space.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

inline constexpr int kStrandPoints = 30;

// The head that the hair grows on: an ellipsoid about kSkullCentre, in decimetres; the face looks along +z.
inline constexpr glm::vec3 kSkullCentre{0.0f, 0.12f, -0.08f};
inline constexpr glm::vec3 kSkullRadii{0.78f, 0.98f, 0.96f};

struct HairStrands {
    std::vector<glm::vec3> points;     // kStrandPoints a strand, root first
    std::vector<std::uint32_t> locks;  // which lock each strand belongs to
};

// `count` long strands in a pure function of (seed, index): the first n strands are the same for every count.
HairStrands grow_hair(std::uint32_t count, std::uint64_t seed);

}  // namespace ropsim
