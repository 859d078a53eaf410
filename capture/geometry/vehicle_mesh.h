// Cars and vans: an opaque body and glass windows.
#pragma once

#include "capture/scenery/scenery_mesh.h"

#include <glm/glm.hpp>

namespace ropsim {

// Stands on y = 0 about the origin, its front towards +x; metres.
struct Vehicle {
    SceneryMesh body;
    SceneryMesh glass;
};

Vehicle make_car(glm::vec3 color);
Vehicle make_van(glm::vec3 color);

}  // namespace ropsim
