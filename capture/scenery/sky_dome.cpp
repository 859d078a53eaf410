// A painted sphere seen from inside.
#include "capture/scenery/sky_dome.h"

#include "capture/geometry/turbulence.h"
#include "capture/scenery/scene_parts.h"

#include <algorithm>
#include <cmath>

namespace ropsim {

SceneryMesh sky_dome(const Daylight& daylight, glm::vec3 zenith, float radius, std::uint64_t seed) {
    const Turbulence turbulence(seed ^ 0x536B79u);
    SceneryMesh dome;
    dome.add(sphere_mesh(72), placed(glm::vec3(0), glm::vec3(radius)), glm::vec4(1.0f), Finish::kGlowing);
    for (SceneryVertex& vertex : dome.vertices) {
        const float height = std::max(vertex.normal.y, 0.0f);
        const glm::vec3 clear = glm::mix(daylight.haze, zenith, 1 - std::exp(-3.5f * height));
        // Clouds hang on a plane overhead; towards the horizon they crowd into the haze.
        const glm::vec3 at = vertex.normal * (1.6f / (height + 0.12f));
        const float cloud = turbulence({at.x, 0.0f, 1.7f * at.z}).x;
        const float cover =
            0.55f * glm::smoothstep(0.05f, 0.9f, cloud) * glm::smoothstep(0.02f, 0.25f, height);
        vertex.color = glm::vec4(glm::mix(clear, glm::vec3(0.86f, 0.87f, 0.88f), cover), 1);
    }
    return dome;
}

}  // namespace ropsim
