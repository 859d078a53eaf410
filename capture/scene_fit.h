// Chooses how much of a scene's transparent geometry to draw.
#pragma once

#include "capture/scene.h"

#include <cstdint>
#include <optional>

namespace ropsim {

// The scale at which the scene meets its own minimum, or comes nearest to `fragments` (within 2% unless the
// scene's smallest object is coarser than that). Needs a current GlContext. Throws UserError when no scale
// shows anything.
SceneScale fit_scene(const SceneSource& source, int width, int height, int samples,
                     std::optional<std::uint64_t> fragments);

}  // namespace ropsim
