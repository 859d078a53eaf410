#include "analysis/ambient_view.h"

#include "base/error.h"

#include <cmath>

namespace ropsim {

AmbientView::AmbientView(const TraceHeader& header, const std::string& path) {
    if (!header.camera)
        throw UserError(path,
                        "has no camera, so that no depth has a distance; capture the scene, or give the "
                        "trace a camera");
    const double metres = static_cast<double>(header.camera->metres_per_unit);
    const glm::dmat4 projection(header.camera->projection);
    const glm::dvec2 half(0.5 * header.width, 0.5 * header.height);
    const glm::dmat4 window{{half.x, 0, 0, 0}, {0, -half.y, 0, 0}, {0, 0, 0.5, 0}, {half.x, half.y, 0.5, 1}};
    to_camera_ = glm::inverse(window * projection);
    bool valid = metres > 0 && std::isfinite(metres) && glm::determinant(projection) != 0;
    for (int column = 0; column < 4; ++column) {
        for (int row = 0; row < 4; ++row) valid = valid && std::isfinite(to_camera_[column][row]);
        for (int row = 0; row < 3; ++row) to_camera_[column][row] *= metres;
        w_[column] = projection[column][3] / (column < 3 ? metres : 1.0);
    }
    if (!valid)
        throw UserError(path,
                        "has a camera whose projection cannot be inverted, or no positive "
                        "metres_per_unit; give the trace a proper camera");
    scale_ =
        half * glm::dvec2(std::abs(projection[0][0]), std::abs(projection[1][1])) * glm::dvec2(1 / metres);
}

glm::dvec3 AmbientView::position(double x, double y, double z) const {
    const glm::dvec4 at = to_camera_ * glm::dvec4(x, y, z, 1);
    return glm::dvec3(at) / at.w;
}

glm::dvec2 AmbientView::pixels_per_metre(const glm::dvec3& position) const {
    return scale_ / std::abs(glm::dot(w_, glm::dvec4(position, 1)));
}

}  // namespace ropsim
