// Rays from points to the sun against boxes and balls.
#include "capture/scenery/sun_shadow.h"

#include "capture/scenery/scene_parts.h"

#include <algorithm>
#include <cmath>

namespace ropsim {
namespace {

constexpr int kRays = 8;
constexpr float kSunRadius = 0.02f;  // radians; larger than the real one, as if through haze

bool hits_box(glm::vec3 origin, glm::vec3 direction) {
    float enter = 0;
    float leave = 1e30f;
    for (int axis = 0; axis < 3; ++axis) {
        const float slope = std::abs(direction[axis]) > 1e-9f ? direction[axis] : 1e-9f;
        const float first = (-1 - origin[axis]) / slope;
        const float second = (1 - origin[axis]) / slope;
        enter = std::max(enter, std::min(first, second));
        leave = std::min(leave, std::max(first, second));
    }
    return enter < leave;
}

bool hits_ball(glm::vec3 origin, glm::vec3 direction) {
    const float a = glm::dot(direction, direction);
    const float b = glm::dot(origin, direction);
    const float c = glm::dot(origin, origin) - 1;
    if (c > 0 && b > 0) return false;
    return b * b - a * c > 0;
}

}  // namespace

void SunShadow::add_box(glm::vec3 centre, glm::vec3 half, float yaw, float opacity) {
    casters_.push_back({glm::inverse(glm::mat3(placed(glm::vec3(0), half, yaw))), centre, opacity, false});
}

void SunShadow::add_ball(glm::vec3 centre, glm::vec3 radii, float opacity) {
    casters_.push_back({glm::mat3(placed(glm::vec3(0), 1.0f / radii)), centre, opacity, true});
}

float SunShadow::light(glm::vec3 position) const {
    const glm::vec3 sun = light_direction();
    const glm::vec3 across = glm::normalize(glm::cross(sun, glm::vec3(0, 1, 0)));
    const glm::vec3 up = glm::cross(across, sun);
    float sum = 0;
    for (int ray = 0; ray < kRays; ++ray) {
        const float angle = 2.4f * static_cast<float>(ray);
        const float out = kSunRadius * std::sqrt((static_cast<float>(ray) + 0.5f) / kRays);
        const glm::vec3 direction = sun + out * (std::cos(angle) * across + std::sin(angle) * up);
        float light = 1;
        for (const Caster& caster : casters_) {
            const glm::vec3 origin = caster.to_unit * (position - caster.centre);
            const glm::vec3 local = caster.to_unit * direction;
            if (caster.round ? hits_ball(origin, local) : hits_box(origin, local))
                light *= 1 - caster.opacity;
        }
        sum += light;
    }
    return sum / kRays;
}

}  // namespace ropsim
