#include "analysis/volume_light.h"

#include "analysis/shadow_study.h"
#include "base/error.h"

#include <algorithm>
#include <cmath>

namespace ropsim {

VolumeLight::VolumeLight(const Camera& light, double metres_per_unit)
    : far_away_(light.projection[2][3] == 0),
      metres_per_unit_(metres_per_unit),
      nearest_(std::max(1e-6, static_cast<double>(light.near_plane) * metres_per_unit)) {
    const glm::dmat4 to_world = glm::inverse(glm::dmat4(light.view));
    place_ = far_away_ ? glm::normalize(-glm::dvec3(to_world[2])) : glm::dvec3(to_world[3]);
    filter_.side = 1;
}

void VolumeLight::cast_shadows(const std::string& path, const TraceReader& camera, int filter_side,
                               int threads) {
    TraceReader light(path);
    check_light_view(light, camera);
    if (light.header().samples != 1)
        throw UserError(path, fmt::format("has {} spatial samples a pixel; capture the light's view with "
                                          "--samples 1",
                                          light.header().samples));
    map_ = std::make_unique<DeepShadowMap>(light, threads);
    to_light_.emplace(camera.header(), light.header());
    filter_.side = filter_side;
}

glm::dvec3 VolumeLight::direction(const glm::dvec3& position) const {
    if (far_away_) return place_;
    const glm::dvec3 away = position - place_;
    const double length = glm::length(away);
    return length > 0 ? away / length : glm::dvec3(0, 0, 1);
}

double VolumeLight::falloff(const glm::dvec3& position) const {
    if (far_away_) return 1;
    const double metres = std::max(nearest_, glm::length(position - place_) * metres_per_unit_);
    return 1 / (metres * metres);
}

double VolumeLight::visibility(const ViewPoint& point) const {
    if (!map_) return 1;
    const ViewPoint at = (*to_light_)(point);
    if (!inside_view(at, map_->width(), map_->height())) return 1;
    return whole_filter(filter_, map_->width(), map_->height(), at,
                        [&](int x, int y, double z) { return map_->visibility(x, y, z); });
}

}  // namespace ropsim
