// Shadows of simple solids in the sun, soft at the edges.
#pragma once

#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

class SunShadow {
 public:
    // An upright box of these half sizes, turned by `yaw` radians.
    void add_box(glm::vec3 centre, glm::vec3 half, float yaw = 0, float opacity = 1);
    // An ellipsoid with axes along x, y and z; foliage lets some light through.
    void add_ball(glm::vec3 centre, glm::vec3 radii, float opacity);

    // Share of the sunlight, from light_direction(), that reaches `position`: the mean over a few points of
    // the sun's disc.
    float light(glm::vec3 position) const;

 private:
    struct Caster {
        glm::mat3 to_unit;  // world directions to those in which the caster has size 1
        glm::vec3 centre;
        float opacity;
        bool round;
    };
    std::vector<Caster> casters_;
};

}  // namespace ropsim
