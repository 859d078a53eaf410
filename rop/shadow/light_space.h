// From a captured fragment to the light: where a point of one view lies in another view of the same scene.
#pragma once

#include "base/error.h"
#include "traces/trace.h"

#include <cmath>
#include <limits>

#include <glm/glm.hpp>

namespace ropsim {

// A point of a view: x and y in pixels from the image's top left corner, y down (the centre of pixel (i, j)
// is (i + 0.5, j + 0.5)), and window depth, 0 to 1 within the view's depth range.
struct ViewPoint {
    double x = 0;
    double y = 0;
    double z = 0;
};

// Maps points of one trace's view into another's by their cameras (OpenGL conventions, double precision).
class LightSpace {
 public:
    // Both views must have a camera (CHECK).
    LightSpace(const TraceHeader& from, const TraceHeader& light)
        : matrix_(to_pixels(light) * glm::inverse(to_pixels(from))) {}

    // Window coordinates of a world position, before the division by w.
    static glm::dmat4 to_pixels(const TraceHeader& view) {
        CHECK(view.camera, "a view without a camera");
        const double half_width = 0.5 * view.width;
        const double half_height = 0.5 * view.height;
        const glm::dmat4 window{{half_width, 0, 0, 0},
                                {0, -half_height, 0, 0},
                                {0, 0, 0.5, 0},
                                {half_width, half_height, 0.5, 1}};
        return window * glm::dmat4(view.camera->projection) * glm::dmat4(view.camera->view);
    }
    // World position of a point of `view`.
    static glm::dvec3 world(const TraceHeader& view, const ViewPoint& point) {
        const glm::dvec4 at = glm::inverse(to_pixels(view)) * glm::dvec4(point.x, point.y, point.z, 1);
        return glm::dvec3(at) / at.w;
    }

    // Where a point that the first view sees lies in the light's; all NaN behind a perspective light's eye.
    ViewPoint operator()(const ViewPoint& point) const {
        const glm::dvec4 at = matrix_ * glm::dvec4(point.x, point.y, point.z, 1);
        if (!(at.w > 0)) return {kNowhere, kNowhere, kNowhere};
        return {at.x / at.w, at.y / at.w, at.z / at.w};
    }

    // False where a camera's matrices cannot be inverted, as files may have them.
    bool valid() const {
        for (int c = 0; c < 4; ++c)
            for (int r = 0; r < 4; ++r)
                if (!std::isfinite(matrix_[c][r])) return false;
        return glm::determinant(matrix_) != 0;
    }

 private:
    static constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();

    glm::dmat4 matrix_;
};

}  // namespace ropsim
