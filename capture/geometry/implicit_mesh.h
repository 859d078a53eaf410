// Bodies made of blobs that melt into each other: a distance field, and triangles on its surface.
#pragma once

#include "capture/geometry/mesh.h"

#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// A round cone from `a` (radius `radius_a`) to `b`; a ball where both are the same. `stretch` scales it along
// the axes about `a`: an ellipsoid. `blend` is how far it melts into what came before it; `carved` ones are
// taken away instead of added.
struct Blob {
    glm::vec3 a{0.0f};
    glm::vec3 b{0.0f};
    float radius_a = 1;
    float radius_b = 1;
    float blend = 0.05f;
    glm::vec3 stretch{1.0f};
    bool carved = false;
};

// A ball stretched to `radii` about `centre`.
Blob ellipsoid(glm::vec3 centre, glm::vec3 radii, float blend);
// From `a` to `b`, with a radius at either end.
Blob limb(glm::vec3 a, glm::vec3 b, float radius_a, float radius_b, float blend);

// Blobs joined in order by smooth minima (the polynomial of Quilez).
class BlobBody {
 public:
    explicit BlobBody(std::vector<Blob> blobs);

    // Signed, negative inside; at most the true distance, near enough to it to walk to the surface with.
    float distance(glm::vec3 position) const;
    // Unit length, away from the body.
    glm::vec3 normal(glm::vec3 position) const;
    // The surface in the box, as a mesh of cells of `cell` on a side, each wound counterclockwise from
    // outside. The box must contain the body.
    TriangleMesh mesh(glm::vec3 low, glm::vec3 high, float cell) const;

 private:
    struct Ball {
        glm::vec3 centre;
        float radius;
    };
    std::vector<Blob> blobs_;
    std::vector<Ball> bounds_;  // around each blob
};

}  // namespace ropsim
