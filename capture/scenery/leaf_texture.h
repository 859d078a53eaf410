// Painted cut-outs of plants: colour and coverage, with smooth edges.
#pragma once

#include "capture/scene.h"

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// Straight linear colour and coverage on a square; what is not painted is clear.
class LeafPainting {
 public:
    // `side`: texels, a power of two; `ground` is the colour that clear texels have for the filter.
    LeafPainting(int side, glm::vec3 ground);
    // One leaf or blade over what is there: from `base` along `direction` (both in units of the square, y
    // up), `width` at its widest, which it reaches `belly` of the way along; `bend` turns it sideways towards
    // the tip, radians. `vein`: how much lighter the middle is.
    struct Blade {
        glm::vec2 base;
        glm::vec2 direction;
        float width;
        float belly = 0.4f;
        float bend = 0;
        float vein = 0.25f;
        glm::vec3 color{0.1f, 0.2f, 0.04f};
    };
    void paint(const Blade& blade);
    SceneTexture texture() const;

 private:
    int side_;
    std::vector<glm::vec4> texels_;  // straight colour, coverage
};

// A leafy twig, growing upwards from the middle of the lower edge.
SceneTexture twig_texture(std::uint64_t seed, glm::vec3 color);
// A needled spray of a conifer.
SceneTexture spray_texture(std::uint64_t seed, glm::vec3 color);
// A frond of fern.
SceneTexture fern_texture(std::uint64_t seed, glm::vec3 color);
// A tuft of grass, as wide as high.
SceneTexture grass_texture(std::uint64_t seed, glm::vec3 color);

}  // namespace ropsim
