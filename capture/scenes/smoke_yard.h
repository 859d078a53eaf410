// The yard of the smoke scene: everything but the smoke.
#pragma once

#include "capture/scenery/card_draw.h"
#include "capture/scenery/scenery_mesh.h"
#include "capture/scenery/sun_shadow.h"

#include <cstdint>
#include <vector>

namespace ropsim {

struct SmokeYard {
    SceneryMesh ground;
    SceneryMesh solids;  // buildings, bodies of vehicles, posts, trunks
    SceneryMesh car_glass;
    SceneryMesh house_glass;
    std::vector<Card> fence;
    std::vector<Card> twigs;
    SunShadow shadow;
};

// Where the fires burn, metres.
inline constexpr glm::vec3 kCarFire{-2.2f, 1.0f, -2.6f};
inline constexpr glm::vec3 kBarrelFire{2.3f, 0.9f, 0.25f};
inline constexpr glm::vec3 kFarFire{9.0f, 0.5f, -11.5f};

// `foliage` multiplies the number of twigs.
SmokeYard make_smoke_yard(double foliage, std::uint64_t seed);

// One mesh of chain-link, as wide as high.
SceneTexture wire_texture();

}  // namespace ropsim
