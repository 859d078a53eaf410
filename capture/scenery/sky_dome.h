// The sky as a glowing dome.
#pragma once

#include "capture/scenery/scenery_mesh.h"

namespace ropsim {

// A sphere of `radius` metres about the origin, `daylight.haze` at the horizon and below, `zenith` above,
// with thin clouds that `seed` shapes. Glows: no light falls on it.
SceneryMesh sky_dome(const Daylight& daylight, glm::vec3 zenith, float radius, std::uint64_t seed);

}  // namespace ropsim
