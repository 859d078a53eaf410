// The parts of a four-cylinder car engine with two overhead camshafts, as meshes with their places.
#pragma once

#include "capture/geometry/mesh.h"

#include <vector>

#include <glm/glm.hpp>

namespace ropsim {

// A group of parts as a CAD program colours them; all parts of a finish are one draw.
struct EngineFinish {
    const char* name = "";
    glm::vec4 color{1.0f};  // linear; alpha is the coverage
};

struct EnginePlace {
    glm::mat4 model{1.0f};
    EngineFinish finish;
};

// Copies of one mesh.
struct EnginePart {
    TriangleMesh mesh;
    std::vector<EnginePlace> copies;
};
using EngineParts = std::vector<EnginePart>;

// Finishes that several files use.
inline constexpr EngineFinish kInletFinish{"intake", {0.1f, 0.32f, 0.6f, 0.22f}};
inline constexpr EngineFinish kAccessoryFinish{"accessories", {0.55f, 0.58f, 0.6f, 0.3f}};
inline constexpr EngineFinish kFilterFinish{"fuel and oil", {0.75f, 0.35f, 0.05f, 0.35f}};
inline constexpr EngineFinish kBoltFinish{"bolts", {0.2f, 0.2f, 0.22f, 0.55f}};
inline constexpr EngineFinish kPlugFinish{"plugs", {0.75f, 0.75f, 0.7f, 0.5f}};

// Metres; the crankshaft turns about the x axis, its front end (pulleys, belts) at -x, inlet at +z, outlet at
// -z, +y up. About 0.7 long, 0.6 high and 0.6 deep.
EngineParts engine_castings();   // block, head with covers, cylinder liners
EngineParts engine_train();      // crankshaft, rods, pistons, camshafts, valves, springs
EngineParts engine_manifolds();  // inlet with fuel rail and throttle, exhaust
EngineParts engine_outside();    // belts, pulleys, gears, accessories, bolts

// One list of all.
EngineParts joined(std::vector<EngineParts> lists);

// Dimensions that they share, metres.
inline constexpr int kCylinders = 4;
inline constexpr float kBorePitch = 0.1f;
inline constexpr float kDeck = 0.215f;       // height of the block's top above the crankshaft
inline constexpr float kHeadTop = 0.31f;     // and of the head's
inline constexpr float kCamHeight = 0.352f;  // of the camshafts' axes
inline constexpr float kCamAside = 0.05f;    // their distance from the middle plane
inline constexpr float kBlockHalfLength = 0.225f;

// Middle of a cylinder, x.
constexpr float cylinder_x(int cylinder) {
    return kBorePitch * (static_cast<float>(cylinder) - 0.5f * static_cast<float>(kCylinders - 1));
}

// Turns a mesh about the y axis into one about the x axis, its foot at `position` and its top towards +x.
glm::mat4 along_x(glm::vec3 position);
// Turns a prism about the x-y plane into one along x; the outline's x becomes -z.
glm::mat4 across_x(glm::vec3 position);
// A toothed wheel's outline; teeth are as wide as their gaps at half height.
std::vector<glm::vec2> gear_outline(float root, float tip, int teeth);

}  // namespace ropsim
