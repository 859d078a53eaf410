// The ray of a pixel into the scene: distances along it in metres, and the window depths that belong to them.
#pragma once

#include "traces/trace.h"

#include <glm/glm.hpp>

namespace ropsim {

// Distances count from the eye (perspective) or from the plane through it (orthographic), along the ray.
struct PixelRay {
    glm::dvec3 origin;     // world, at distance 0
    glm::dvec3 direction;  // world units a metre
    glm::dvec3 to_eye;     // camera space, unit length: against the ray
    double clip_z = 0, clip_z_step = 0, clip_w = 0, clip_w_step = 0;  // clip space is linear in the distance

    glm::dvec3 at(double distance) const { return origin + direction * distance; }
    // Window depth of a point; in [0, 1] from the near plane to the far plane.
    double depth(double distance) const {
        return 0.5 + 0.5 * (clip_z + clip_z_step * distance) / (clip_w + clip_w_step * distance);
    }
    // Where the ray reaches a window depth; +infinity where it never does (a far plane at infinity).
    double distance(double depth) const;
};

// The rays of a view's pixels, through their centres (OpenGL conventions, double precision).
class PixelRays {
 public:
    // The view must have a camera (CHECK).
    explicit PixelRays(const TraceHeader& view);

    // False where the camera's matrices have no inverse or do not look along -z, as files may have them.
    bool valid() const { return valid_; }
    PixelRay operator()(int x, int y) const;

 private:
    glm::dmat4 projection_, from_clip_, to_world_;
    double width_, height_, metres_per_unit_;
    bool valid_;
};

}  // namespace ropsim
