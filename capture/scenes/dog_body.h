// A standing dog modelled from blobs, in decimetres: +x is forward, the paws stand on y = 0.
#pragma once

#include "capture/geometry/implicit_mesh.h"
#include "capture/scene.h"

#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// A piece of the body and how the fur on it grows.
struct DogPart {
    Blob blob;
    float fur = 0.3f;              // length, decimetres
    glm::vec3 flow{-1, -0.5f, 0};  // which way the hair is smoothed
};

const std::vector<DogPart>& dog_parts();
// All parts as one body.
BlobBody dog_body();
// The middle of the collar, and the way through it along the neck.
inline constexpr glm::vec3 kCollarCentre{2.98f, 5.5f, 0.0f};
inline constexpr glm::vec3 kCollarAxis{0.6f, 0.8f, 0.0f};

// Linear colour of skin and hair at a place of the body; `noise` in [-1, 1] frays the patches' edges.
glm::vec3 dog_color(glm::vec3 position, float noise);

// Eyes, nose, tongue and collar.
std::vector<SceneDraw> dog_details();

}  // namespace ropsim
