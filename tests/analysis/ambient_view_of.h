// Views and depth buffers of surfaces with known shapes, for the tests of ambient occlusion.
#pragma once

#include "analysis/ambient_view.h"

#include <limits>

#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {

inline TraceHeader header_of(int width, int height, const glm::mat4& projection, float metres_per_unit = 1) {
    TraceHeader header;
    header.width = width;
    header.height = height;
    header.scene = "test";
    header.camera.emplace();
    header.camera->projection = projection;
    header.camera->metres_per_unit = metres_per_unit;
    return header;
}

// Looks straight down on `across` x `down` scene units about the origin, from 5 above, at heights from -5
// to 5.
inline glm::mat4 from_above(float across, float down) {
    return glm::ortho(-across / 2, across / 2, -down / 2, down / 2, 0.0f, 10.0f);
}

// Of the heights that `height_at(x, y)` gives at pixels' centres, in the units and directions of
// from_above(); rows go down as y does up.
template <typename Height>
DepthBuffer heights(int width, int height, double across, double down, const Height& height_at) {
    DepthBuffer buffer{width, height, {}};
    for (int row = 0; row < height; ++row)
        for (int column = 0; column < width; ++column)
            buffer.depth.push_back(static_cast<float>((5 - height_at(((column + 0.5) / width - 0.5) * across,
                                                                     (0.5 - (row + 0.5) / height) * down)) /
                                                      10));
    return buffer;
}

}  // namespace ropsim
