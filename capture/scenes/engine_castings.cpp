// The engine's castings: block, cylinder liners, head, covers; and how parts are placed.
#include "capture/geometry/lathe_mesh.h"
#include "capture/geometry/profile.h"
#include "capture/geometry/swept_mesh.h"
#include "capture/scenery/scene_parts.h"
#include "capture/scenes/engine_parts.h"

#include <cmath>
#include <utility>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

using Outline = std::vector<glm::vec2>;

constexpr float kBore = 0.043f;  // radius

constexpr EngineFinish kBlock{"block", {0.42f, 0.5f, 0.58f, 0.16f}};
constexpr EngineFinish kLiner{"liners", {0.16f, 0.5f, 0.62f, 0.22f}};
constexpr EngineFinish kHead{"head", {0.5f, 0.56f, 0.36f, 0.16f}};
constexpr EngineFinish kCover{"cover", {0.55f, 0.14f, 0.1f, 0.2f}};
constexpr EngineFinish kPan{"oil pan", {0.2f, 0.24f, 0.3f, 0.2f}};

std::vector<EnginePlace> per_cylinder(glm::vec3 offset, const EngineFinish& color) {
    std::vector<EnginePlace> copies;
    for (int i = 0; i < kCylinders; ++i)
        copies.push_back({glm::translate(glm::mat4(1.0f), offset + glm::vec3(cylinder_x(i), 0, 0)), color});
    return copies;
}

EngineParts block() {
    EngineParts parts;
    const Outline outer = {{-0.075f, -0.045f}, {0.075f, -0.045f}, {0.09f, -0.02f},  {0.09f, 0.03f},
                           {0.066f, 0.09f},    {0.066f, 0.19f},   {0.075f, 0.2f},   {0.075f, kDeck},
                           {-0.075f, kDeck},   {-0.075f, 0.2f},   {-0.066f, 0.19f}, {-0.066f, 0.09f},
                           {-0.09f, 0.03f},    {-0.09f, -0.02f}};
    parts.push_back({extruded_mesh(outer, kBlockHalfLength), {{across_x({0, 0, 0}), kBlock}}});
    const Outline crankcase = {{-0.067f, -0.044f}, {0.067f, -0.044f}, {0.082f, -0.018f}, {0.08f, 0.03f},
                               {0.055f, 0.078f},   {-0.055f, 0.078f}, {-0.08f, 0.03f},   {-0.082f, -0.018f}};
    EnginePart bays{extruded_mesh(crankcase, 0.036f), {}};
    for (int i = 0; i < kCylinders; ++i) bays.copies.push_back({across_x({cylinder_x(i), 0, 0}), kBlock});
    parts.push_back(std::move(bays));
    // Bearing caps between the bays, ribs along the sides.
    EnginePart caps{
        extruded_mesh({{-0.05f, -0.05f}, {0.05f, -0.05f}, {0.055f, 0.0f}, {-0.055f, 0.0f}}, 0.011f), {}};
    for (int i = 0; i <= kCylinders; ++i)
        caps.copies.push_back({across_x({cylinder_x(i) - 0.5f * kBorePitch, 0, 0}), kBlock});
    parts.push_back(std::move(caps));
    EnginePart ribs{box_mesh(), {}};
    for (int i = 0; i <= 2 * kCylinders; ++i)
        for (float side : {-1.0f, 1.0f})
            ribs.copies.push_back(
                {placed({cylinder_x(0) + 0.05f * static_cast<float>(i - 1), 0.14f, side * 0.07f},
                        {0.003f, 0.05f, 0.006f}),
                 kBlock});
    parts.push_back(std::move(ribs));
    return parts;
}

EngineParts cylinders() {
    EngineParts parts;
    const float foot = 0.075f;
    parts.push_back(
        {lathe_mesh(
             {{kBore, kDeck}, {kBore, foot}, {kBore + 0.004f, foot}, {kBore + 0.004f, kDeck}, {kBore, kDeck}},
             40),
         per_cylinder({0, 0, 0}, kLiner)});
    parts.push_back(
        {lathe_mesh({{kBore + 0.004f, 0.1f}, {0.0485f, 0.105f}, {0.0485f, 0.2f}, {kBore + 0.004f, 0.205f}},
                    40),
         per_cylinder({0, 0, 0}, kLiner)});
    return parts;
}

EngineParts head() {
    EngineParts parts;
    const Outline outer = {
        {-0.075f, kDeck + 0.001f}, {0.075f, kDeck + 0.001f}, {0.078f, 0.24f}, {0.098f, 0.3f},
        {0.098f, kHeadTop},        {-0.098f, kHeadTop},      {-0.098f, 0.3f}, {-0.078f, 0.24f}};
    parts.push_back({extruded_mesh(outer, kBlockHalfLength), {{across_x({0, 0, 0}), kHead}}});
    // Combustion chambers, and a port either side of each.
    parts.push_back({lathe_mesh(smooth_profile({{0.041f, 0}, {0.03f, 0.016f}, {0.0f, 0.022f}}, 6), 36),
                     per_cylinder({0, kDeck + 0.001f, 0}, kHead)});
    EnginePart ports;
    for (float side : {-1.0f, 1.0f})
        for (float aside : {-0.019f, 0.019f}) {
            std::vector<glm::vec3> path;
            for (int i = 0; i <= 10; ++i) {
                const float t = static_cast<float>(i) / 10;
                path.emplace_back(glm::mix(aside, 0.25f * aside, t),
                                  kDeck + 0.018f + 0.05f * std::sin(1.6f * t),
                                  side * (0.024f + 0.056f * t * t + 0.01f * t));
            }
            append_mesh(ports.mesh, tube_mesh(path, 0.0135f, 20));
        }
    ports.copies = per_cylinder({0, 0, 0}, kHead);
    parts.push_back(std::move(ports));
    const Outline cover = {{-0.095f, kHeadTop}, {0.095f, kHeadTop}, {0.095f, 0.37f},   {0.075f, 0.398f},
                           {0.02f, 0.402f},     {0.016f, 0.388f},   {-0.016f, 0.388f}, {-0.02f, 0.402f},
                           {-0.075f, 0.398f},   {-0.095f, 0.37f}};
    parts.push_back({extruded_mesh(cover, kBlockHalfLength), {{across_x({0, 0, 0}), kCover}}});
    const Outline pan = {{-0.06f, -0.15f}, {0.05f, -0.15f},   {0.075f, -0.12f},
                         {0.08f, -0.046f}, {-0.08f, -0.046f}, {-0.078f, -0.12f}};
    parts.push_back({extruded_mesh(pan, 0.5f * kBlockHalfLength), {{across_x({0.11f, 0, 0}), kPan}}});
    const Outline shallow = {{-0.06f, -0.085f}, {0.06f, -0.085f}, {0.08f, -0.046f}, {-0.08f, -0.046f}};
    parts.push_back({extruded_mesh(shallow, 0.5f * kBlockHalfLength), {{across_x({-0.112f, 0, 0}), kPan}}});
    return parts;
}

}  // namespace

glm::mat4 along_x(glm::vec3 position) {
    return glm::rotate(glm::translate(glm::mat4(1.0f), position), -glm::half_pi<float>(), glm::vec3(0, 0, 1));
}

glm::mat4 across_x(glm::vec3 position) {
    return glm::rotate(glm::translate(glm::mat4(1.0f), position), glm::half_pi<float>(), glm::vec3(0, 1, 0));
}

std::vector<glm::vec2> gear_outline(float root, float tip, int teeth) {
    Outline outline;
    for (int i = 0; i < 4 * teeth; ++i) {
        // Flanks lean, so that teeth narrow outwards.
        const float inner = i % 4 == 0 || i % 4 == 3 ? 1.0f : 0.0f;
        const float lean = i % 4 == 1 ? 0.2f : i % 4 == 2 ? -0.2f : i % 4 == 0 ? -0.1f : 0.1f;
        const float angle =
            glm::two_pi<float>() * (static_cast<float>(i) + lean) / static_cast<float>(4 * teeth);
        outline.push_back(glm::mix(tip, root, inner) * glm::vec2(std::cos(angle), std::sin(angle)));
    }
    return outline;
}

EngineParts joined(std::vector<EngineParts> lists) {
    EngineParts all;
    for (EngineParts& list : lists)
        for (EnginePart& part : list) all.push_back(std::move(part));
    return all;
}

EngineParts engine_castings() {
    return joined({block(), head(), cylinders()});
}

}  // namespace ropsim
