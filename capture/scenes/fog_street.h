// The street of the fog scene: houses, lamps, people, a tree.
#pragma once

#include "capture/geometry/mesh.h"
#include "capture/scene.h"

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

inline constexpr int kStreetLamps = 8;
inline constexpr float kStreetLength = 60;      // metres, along -z
inline constexpr float kStreetHalfWidth = 5.2;  // between the houses

// Where the lamps' flames are, w their strength: the parameters of street_light.glsl.
std::vector<glm::vec4> street_lamps();

// Everything opaque, lit by the lamps.
std::vector<SceneDraw> street_draws(std::uint64_t seed);

// One lamp's panes, about its flame; each lamp has them twice, outside and inside of the glass.
TriangleMesh lantern_panes();

// Where leaves may hang: ends of the tree's twigs.
std::vector<glm::vec3> twig_ends(std::uint64_t seed);

}  // namespace ropsim
