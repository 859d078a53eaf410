// What of the sun's light arrives on a table under things of glass: coloured shadows with bright middles.
#pragma once

#include "capture/scene.h"

#include <functional>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// An upright body of revolution on the table.
struct GlassBody {
    glm::vec2 place;                     // x and z of its axis
    float height = 0;                    // scene units
    std::function<float(float)> radius;  // at a height above the table; 0: nothing there
    glm::vec3 transmission{1.0f};        // of one wall
};

// A square of the plane y = 0.
class TableLight {
 public:
    // From (low.x, low.y) in x and z, `side` scene units long; `to_sun` is a unit vector above the plane.
    TableLight(glm::vec2 low, float side, glm::vec3 to_sun);
    // Multiplies by a function of (x, z).
    void filter(const std::function<glm::vec3(glm::vec2)>& transmission);
    // Glass gathers light in the middle of its shadow and sends it away from the rim.
    void shadow(const GlassBody& body);
    // Half of the light that is left, 4 channels (alpha 1), clamped to the edge.
    SceneTexture texture() const;
    // For the shader: low x, low z, one over the side twice.
    glm::vec4 rectangle() const { return {low_, 1 / side_, 1 / side_}; }

 private:
    static constexpr int kTexels = 512;  // a side
    glm::vec2 middle(int x, int y) const;

    glm::vec2 low_;
    float side_;
    glm::vec3 to_sun_;
    std::vector<glm::vec3> light_;
};

}  // namespace ropsim
