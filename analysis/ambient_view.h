// What ambient occlusion in screen space works on: a depth buffer, and where in front of the camera its
// texels lie.
#pragma once

#include "traces/trace.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// One window depth a pixel, row-major from the top left; infinite where nothing was drawn, which hardware
// keeps as the far plane's.
struct DepthBuffer {
    int width = 0;
    int height = 0;
    std::vector<float> depth;

    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    }
    bool drawn(int x, int y) const { return std::isfinite(depth[index(x, y)]); }
    float stored(int x, int y) const { return std::min(depth[index(x, y)], 1.0f); }
};

// Camera space in metres: +x right, +y up, and z negative in front of the eye. Double precision.
class AmbientView {
 public:
    // UserError naming `path` where the header has no camera, or one whose matrix or scale nothing can be
    // placed with.
    AmbientView(const TraceHeader& header, const std::string& path);

    // Of a point at window position (x, y) in pixels from the top left, y down, and window depth z. Infinite
    // where a depth buffer's far plane is.
    glm::dvec3 position(double x, double y, double z) const;
    // Of the centre of pixel (x, y).
    glm::dvec3 at_pixel(int x, int y, float z) const {
        return position(x + 0.5, y + 0.5, static_cast<double>(z));
    }
    // How many pixels a metre across the view spans there, horizontally and vertically; of a position in
    // front of the eye.
    glm::dvec2 pixels_per_metre(const glm::dvec3& position) const;

 private:
    glm::dmat4 to_camera_{1.0};  // window to camera, metres
    glm::dvec4 w_{0.0};          // last row of the projection from metres
    glm::dvec2 scale_{0.0};      // pixels a metre at w = 1
};

}  // namespace ropsim
