#include "analysis/shadow_receiver_plane.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace ropsim {

namespace {

glm::dvec3 place(const glm::dmat4& to_world, double x, double y, double z) {
    const glm::dvec4 at = to_world * glm::dvec4(x, y, z, 1);
    return glm::dvec3(at) / at.w;
}

bool usable(double value) {
    return std::isfinite(value) && value > 0;
}

}  // namespace

ReceiverPlanes::ReceiverPlanes(const TraceHeader& camera, const TraceHeader& light)
    : camera_(camera),
      camera_pixels_to_world_(glm::inverse(LightSpace::to_pixels(camera))),
      light_pixels_to_world_(glm::inverse(LightSpace::to_pixels(light))),
      to_world_(glm::inverse(glm::dmat3(camera.camera->view))) {}

ReceiverPlane ReceiverPlanes::of_material(const Material& material, const ViewPoint& at) const {
    const glm::dvec3 normal(material.normal[0], material.normal[1], material.normal[2]);
    return of_normal(to_world_ * normal, at);
}

ReceiverPlane ReceiverPlanes::of_opaque(std::size_t sample, const ViewPoint& point,
                                        const ViewPoint& at) const {
    const std::vector<float>& depth = camera_.opaque->depth;
    const auto samples = static_cast<std::size_t>(camera_.samples);
    const auto width = static_cast<std::size_t>(camera_.width);
    const std::size_t column = sample / samples % width;
    const std::size_t row = sample / samples / width;
    // Difference of depth to the next pixel along an axis; nothing without a neighbour that shows a surface.
    const auto slope = [&](bool before, bool after, std::size_t step) {
        std::optional<double> least;
        const auto consider = [&](std::size_t there, double sign) {
            if (!std::isfinite(depth[there])) return;
            const double found =
                sign * (static_cast<double>(depth[there]) - static_cast<double>(depth[sample]));
            if (!least || std::abs(found) < std::abs(*least)) least = found;
        };
        if (before) consider(sample - step, -1);
        if (after) consider(sample + step, 1);
        return least;
    };
    const auto across = slope(column > 0, column + 1 < width, samples);
    const auto down = slope(row > 0, row + 1 < static_cast<std::size_t>(camera_.height), samples * width);
    if (!across || !down) return {};
    const glm::dvec3 here = place(camera_pixels_to_world_, point.x, point.y, point.z);
    return of_normal(
        glm::cross(place(camera_pixels_to_world_, point.x + 1, point.y, point.z + *across) - here,
                   place(camera_pixels_to_world_, point.x, point.y + 1, point.z + *down) - here),
        at);
}

ReceiverPlane ReceiverPlanes::of_normal(const glm::dvec3& normal, const ViewPoint& at) const {
    const glm::dvec3 ray =
        place(light_pixels_to_world_, at.x, at.y, 1) - place(light_pixels_to_world_, at.x, at.y, 0);
    const double length = glm::length(normal);
    const double ray_length = glm::length(ray);
    if (!usable(length) || !usable(ray_length)) return {};
    const glm::dvec3 towards = ray / ray_length;
    glm::dvec3 n = normal / length;
    const double cosine = glm::dot(n, towards);
    if (std::abs(cosine) < kLeastCosine) {
        const glm::dvec3 along = glm::normalize(n - cosine * towards);
        n = std::sqrt(1 - kLeastCosine * kLeastCosine) * along +
            std::copysign(kLeastCosine, cosine) * towards;
    }
    // Planes go from the world into the light's pixels by the transpose of the way back.
    const glm::dvec3 here = place(light_pixels_to_world_, at.x, at.y, at.z);
    const glm::dvec4 plane = glm::dvec4(n, -glm::dot(n, here)) * light_pixels_to_world_;
    return {-plane.x / plane.z, -plane.y / plane.z};
}

}  // namespace ropsim
