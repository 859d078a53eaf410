// How much light reaches points inside a cloud of thin, translucent matter.
#pragma once

#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// A grid of kCells cells a side over a box. Matter is deposited as optical area; light falls off
// exponentially with the matter it crosses on the way from a distant source.
class LightVolume {
 public:
    static constexpr int kCells = 56;

    LightVolume(glm::vec3 low, glm::vec3 high);
    // `area` in square scene units: opacity times the size of the thing. Outside the box: ignored.
    void deposit(glm::vec3 position, float area);
    // Sums the matter towards the light; `to_light` is a unit vector. Deposits afterwards do not count.
    void illuminate(glm::vec3 to_light);
    // Fraction of the light that arrives at `position`, trilinear between cells. `scale` multiplies the
    // matter.
    float transmittance(glm::vec3 position, float scale) const;

 private:
    std::size_t cell(int x, int y, int z) const;
    float sample(const std::vector<float>& grid, glm::vec3 at) const;

    glm::vec3 low_;
    glm::vec3 cell_size_;
    std::vector<float> matter_;  // optical area over cell volume: extinction per scene unit
    std::vector<float> depth_;   // optical depth towards the light
};

}  // namespace ropsim
