// Views of a floor from straight above, for tests of `ropsim shadow`.
#pragma once

#include "traces/trace.h"

#include <string>

#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {

inline constexpr int kSide = 24;

// A pane of alpha 0.5 at y = 1 over the floor at y = 0, both as large as the views, each seen straight from
// above: by the light in all of x, z in [-1, 1] and by the camera in the middle half of it.
inline TraceHeader seen_from_above(const std::string& view, float half_side) {
    TraceHeader header;
    header.width = header.height = kSide;
    header.scene = "a pane above a floor";
    header.view = view;
    header.draws.resize(1);
    header.camera.emplace();
    header.camera->view = glm::lookAt(glm::vec3(0, 4, 0), glm::vec3(0), glm::vec3(0, 0, -1));
    header.camera->projection = glm::ortho(-half_side, half_side, -half_side, half_side, 2.0f, 6.0f);
    constexpr auto kPixels = static_cast<std::size_t>(kSide) * kSide;
    header.opaque.emplace();
    header.opaque->rgb.assign(3 * kPixels, 1.0f);
    header.opaque->depth.assign(kPixels, 0.5f);
    return header;
}

}  // namespace ropsim
