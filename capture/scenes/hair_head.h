// The bust that long hair grows on: what is seen of it, and what the hair lies on.
#pragma once

#include "capture/geometry/implicit_mesh.h"
#include "capture/scene.h"

#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// The skull is an ellipsoid about kSkullCentre, in decimetres; the face looks along +z.
inline constexpr glm::vec3 kSkullCentre{0.0f, 0.12f, -0.08f};
inline constexpr glm::vec3 kSkullRadii{0.76f, 0.96f, 0.94f};

// A mannequin's head, neck and dressed shoulders.
std::vector<SceneDraw> bust_draws();

// What strands slide off: skull, neck, shoulders and back, and a space kept free before the face.
BlobBody bust_obstacle();

}  // namespace ropsim
