// Daylight as shader parameters.
#include "capture/scenery/daylight.h"

#include "capture/scenery/scene_parts.h"

namespace ropsim {

std::vector<glm::vec4> daylight_parameters(const Daylight& daylight) {
    return {glm::vec4(light_direction(), 0), glm::vec4(daylight.haze, daylight.haze_extinction),
            glm::vec4(daylight.sun, 0), glm::vec4(daylight.sky, 0)};
}

}  // namespace ropsim
