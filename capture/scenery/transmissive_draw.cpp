// Glass and clear plastic: the shading is an environment and the laws of reflection.
#include "capture/scenery/transmissive_draw.h"

#include "capture/shader_sources.h"

namespace ropsim {

SceneDraw transmissive_draw(const std::string& name, const TriangleMesh& mesh,
                            const std::vector<MeshInstance>& instances, const GlassLook& look) {
    SceneDraw draw = matte_draw(name, mesh, instances);
    draw.shading =
        std::string(look.least_alpha ? "#define SURFACE transmissive\n" : "#define SURFACE covering\n") +
        std::string(shader_source(look.environment)) + std::string(shader_source("transmissive_shading"));
    draw.parameters = {glm::vec4(look.to_sun, 0), glm::vec4(look.sun, 0),
                       glm::vec4(look.reflectance, look.eta, look.inner_reflections, look.gloss)};
    return draw;
}

}  // namespace ropsim
