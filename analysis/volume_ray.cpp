#include "analysis/volume_ray.h"

#include "base/error.h"

#include <cmath>
#include <limits>

namespace ropsim {
namespace {

bool finite(const glm::dvec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace

double PixelRay::distance(double depth) const {
    const double ndc = 2 * depth - 1;
    const double reached = (clip_z - ndc * clip_w) / (ndc * clip_w_step - clip_z_step);
    // Past a depth range without end the quotient turns negative; the eye's side of depth 0 does so too.
    const bool beyond = std::isnan(reached) || (reached < 0 && depth > 0.5);
    return beyond ? std::numeric_limits<double>::infinity() : reached;
}

PixelRays::PixelRays(const TraceHeader& view)
    : width_(view.width), height_(view.height), metres_per_unit_(0), valid_(false) {
    CHECK(view.camera, "a view without a camera");
    projection_ = view.camera->projection;
    from_clip_ = glm::inverse(projection_);
    to_world_ = glm::inverse(glm::dmat4(view.camera->view));
    metres_per_unit_ = static_cast<double>(view.camera->metres_per_unit);
    const PixelRay corner = (*this)(0, 0), middle = (*this)(view.width / 2, view.height / 2);
    valid_ = metres_per_unit_ > 0 && std::isfinite(metres_per_unit_);
    for (const PixelRay& ray : {corner, middle})
        valid_ = valid_ && finite(ray.origin) && finite(ray.direction) && ray.to_eye.z > 0 &&
                 ray.distance(0) >= 0 && ray.distance(0) < ray.distance(1);
}

PixelRay PixelRays::operator()(int x, int y) const {
    const double ndc_x = 2 * (x + 0.5) / width_ - 1, ndc_y = 1 - 2 * (y + 0.5) / height_;
    const auto camera_space = [&](double ndc_z) {
        const glm::dvec4 point = from_clip_ * glm::dvec4(ndc_x, ndc_y, ndc_z, 1);
        return glm::dvec3(point) / point.w;
    };
    const glm::dvec3 near = camera_space(-1);
    const glm::dvec3 forwards = glm::normalize(camera_space(0) - near);
    const glm::dvec3 start = near - forwards * (near.z / forwards.z);
    const glm::dvec3 step = forwards / metres_per_unit_;
    const glm::dvec4 clip = projection_ * glm::dvec4(start, 1), clip_step = projection_ * glm::dvec4(step, 0);
    PixelRay ray;
    ray.origin = glm::dvec3(to_world_ * glm::dvec4(start, 1));
    ray.direction = glm::dvec3(to_world_ * glm::dvec4(step, 0));
    ray.to_eye = -forwards;
    ray.clip_z = clip.z;
    ray.clip_z_step = clip_step.z;
    ray.clip_w = clip.w;
    ray.clip_w_step = clip_step.w;
    return ray;
}

}  // namespace ropsim
