// Shadows of glass on a table, as a texture.
#include "capture/scenery/table_light.h"

#include "base/error.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ropsim {

TableLight::TableLight(glm::vec2 low, float side, glm::vec3 to_sun)
    : low_(low), side_(side), to_sun_(to_sun), light_(std::size_t{kTexels} * kTexels, glm::vec3(1.0f)) {
    CHECK(side > 0 && to_sun.y > 0, "a square of {}, the sun at height {}", side, to_sun.y);
}

glm::vec2 TableLight::middle(int x, int y) const {
    return low_ + (side_ / kTexels) * glm::vec2(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
}

void TableLight::filter(const std::function<glm::vec3(glm::vec2)>& transmission) {
    for (int y = 0; y < kTexels; ++y)
        for (int x = 0; x < kTexels; ++x)
            light_[static_cast<std::size_t>(y * kTexels + x)] *= transmission(middle(x, y));
}

void TableLight::shadow(const GlassBody& body) {
    // The body's shadow is that of a stack of discs.
    constexpr int kDiscs = 72;
    const glm::vec2 slide = -glm::vec2(to_sun_.x, to_sun_.z) / to_sun_.y;
    std::array<glm::vec3, kDiscs> discs{};  // centre, radius
    glm::vec2 low(1e9f);
    glm::vec2 high(-1e9f);
    for (std::size_t i = 0; i < kDiscs; ++i) {
        const float height = body.height * (static_cast<float>(i) + 0.5f) / kDiscs;
        const float radius = body.radius(height);
        const glm::vec2 centre = body.place + height * slide;
        discs[i] = glm::vec3(centre, radius);
        if (radius <= 0) continue;
        low = glm::min(low, centre - 1.2f * radius);
        high = glm::max(high, centre + 1.2f * radius);
    }
    const auto texel = [&](float position, int axis) {
        const float at = (position - low_[axis]) / side_ * kTexels;
        return static_cast<int>(std::clamp(at, 0.0f, static_cast<float>(kTexels - 1)));
    };
    const glm::vec3 color = body.transmission;
    for (int y = texel(low.y, 1); y <= texel(high.y, 1); ++y)
        for (int x = texel(low.x, 0); x <= texel(high.x, 0); ++x) {
            float nearest = 2;
            for (const glm::vec3& disc : discs)
                if (disc.z > 0)
                    nearest = std::min(nearest, glm::distance(middle(x, y), glm::vec2(disc)) / disc.z);
            const glm::vec3 inside =
                glm::mix(1.5f * color, 0.3f * color * color, glm::smoothstep(0.1f, 0.8f, nearest));
            light_[static_cast<std::size_t>(y * kTexels + x)] *=
                glm::mix(inside, glm::vec3(1.0f), glm::smoothstep(0.95f, 1.15f, nearest));
        }
}

SceneTexture TableLight::texture() const {
    SceneTexture texture{kTexels, kTexels, 4, false, {}};
    texture.values.reserve(light_.size() * 4);
    for (const glm::vec3& l : light_)
        texture.values.insert(texture.values.end(), {0.5f * l.x, 0.5f * l.y, 0.5f * l.z, 1.0f});
    return texture;
}

}  // namespace ropsim
