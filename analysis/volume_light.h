// The light of a participating medium: what arrives at a point, from where, and past which shadows.
#pragma once

#include "rop/shadow/deep_shadow_map.h"
#include "rop/shadow/light_space.h"
#include "rop/shadow/shadow_filter.h"
#include "traces/trace.h"

#include <memory>
#include <optional>
#include <string>

#include <glm/glm.hpp>

namespace ropsim {

class VolumeLight {
 public:
    // `light` must be the trace's light, `metres_per_unit` the scene's.
    VolumeLight(const Camera& light, double metres_per_unit);

    // Dims the light by what `path`, the light's view of the scene that `camera` shows, holds between the
    // two: transmittance of its fragments, none behind its opaque layer. Points that it does not show stay
    // lit. Throws UserError where the two do not belong together.
    void cast_shadows(const std::string& path, const TraceReader& camera, int filter_side, int threads);

    bool far_away() const { return far_away_; }  // an orthographic light: parallel rays
    // Unit length, along the light that reaches a world position.
    glm::dvec3 direction(const glm::dvec3& position) const;
    // Irradiance over that of an orthographic light, or of a perspective one at a metre, without shadows:
    // falls with the square of the distance from its near plane on.
    double falloff(const glm::dvec3& position) const;
    // Share that shadows leave at a point of the camera's view.
    double visibility(const ViewPoint& point) const;

 private:
    bool far_away_;
    glm::dvec3 place_;  // world: of the light, or the direction of its rays
    double metres_per_unit_;
    double nearest_;  // metres
    std::unique_ptr<DeepShadowMap> map_;
    std::optional<LightSpace> to_light_;
    ShadowFilter filter_;
};

}  // namespace ropsim
