// Draws of glass and clear plastic, which colour what is seen through them.
#pragma once

#include "capture/scene.h"
#include "capture/scenery/scene_parts.h"

#include <string>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

struct GlassLook {
    std::string environment;         // shader file with vec3 environment(vec3 direction): what is mirrored
    glm::vec3 to_sun{0, 1, 0};       // unit length
    glm::vec3 sun{0.0f};             // radiance of its mirror image, linear
    float reflectance = 0.04f;       // at normal incidence
    float eta = 1.5f;                // index of refraction recorded for the background's refraction
    float inner_reflections = 0.1f;  // share of the light passed on that comes by inner reflections
    float gloss = 400;               // exponent of the sun's highlight
    bool least_alpha = true;         // of the pairs of shaders/surface.glsl: transmissive(), else covering()
};

// Copies of a mesh; a copy's colour is the transmission of one of its surfaces at normal incidence (each
// above 0), its alpha the coverage. The scene must record materials.
SceneDraw transmissive_draw(const std::string& name, const TriangleMesh& mesh,
                            const std::vector<MeshInstance>& instances, const GlassLook& look);

}  // namespace ropsim
