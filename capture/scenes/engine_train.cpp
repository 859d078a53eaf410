// The engine's moving parts: crankshaft, rods and pistons, camshafts, valves and springs.
#include "capture/geometry/lathe_mesh.h"
#include "capture/geometry/profile.h"
#include "capture/geometry/swept_mesh.h"
#include "capture/scenes/engine_parts.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

using Outline = std::vector<glm::vec2>;

constexpr float kThrow = 0.045f;     // of the crank, half the stroke
constexpr float kRod = 0.14f;        // from pin to pin
constexpr float kCrankAngle = 0.7f;  // radians; where the engine was stopped
constexpr float kValveTilt = 0.33f;  // radians

constexpr EngineFinish kCrank{"crankshaft", {0.75f, 0.42f, 0.07f, 0.5f}};
constexpr EngineFinish kRods{"rods", {0.14f, 0.42f, 0.2f, 0.45f}};
constexpr EngineFinish kPiston{"pistons", {0.7f, 0.62f, 0.16f, 0.4f}};
constexpr EngineFinish kCam{"camshafts", {0.62f, 0.12f, 0.3f, 0.5f}};
constexpr EngineFinish kValve{"valves", {0.22f, 0.25f, 0.62f, 0.5f}};
constexpr EngineFinish kSpring{"springs", {0.05f, 0.45f, 0.5f, 0.5f}};
constexpr EngineFinish kBearing{"bearings", {0.5f, 0.56f, 0.36f, 0.2f}};

float crank_angle(int cylinder) {
    return kCrankAngle + (cylinder == 0 || cylinder == 3 ? 0.0f : glm::pi<float>());
}

// Of the crank pin about the crankshaft, y and z.
glm::vec2 pin(int cylinder) {
    return kThrow * glm::vec2(std::cos(crank_angle(cylinder)), std::sin(crank_angle(cylinder)));
}

// Height of the piston's pin.
float piston_height(int cylinder) {
    const glm::vec2 at = pin(cylinder);
    return at.x + std::sqrt(kRod * kRod - at.y * at.y);
}

glm::mat4 at(glm::vec3 position) {
    return glm::translate(glm::mat4(1.0f), position);
}

EngineParts crankshaft() {
    EngineParts parts;
    const TriangleMesh journal = lathe_mesh({{0, 0}, {0.026f, 0}, {0.026f, 1}, {0, 1}}, 28);
    EnginePart journals{journal, {}};
    const auto shaft = [&](float from, float to, glm::vec2 place, float size) {
        journals.copies.push_back({along_x({from, place.x, place.y}) *
                                       glm::scale(glm::mat4(1.0f), glm::vec3(size, to - from, size)),
                                   kCrank});
    };
    for (int i = 0; i <= kCylinders; ++i) {
        const float middle = cylinder_x(i) - 0.5f * kBorePitch;
        shaft(middle - 0.02f, middle + 0.02f, {0, 0}, 1);
    }
    for (int i = 0; i < kCylinders; ++i) shaft(cylinder_x(i) - 0.018f, cylinder_x(i) + 0.018f, pin(i), 0.85f);
    shaft(-0.33f, -0.21f, {0, 0}, 0.62f);
    shaft(0.22f, 0.27f, {0, 0}, 1.3f);
    parts.push_back(std::move(journals));
    // Webs: a narrow end about the pin, a counterweight beyond the shaft. The pin is at +y.
    Outline web;
    for (int i = 0; i <= 10; ++i) {
        const float angle = glm::pi<float>() * static_cast<float>(i) / 10;
        web.push_back(glm::vec2(0, kThrow) + 0.03f * glm::vec2(std::cos(angle), std::sin(angle)));
    }
    for (int i = 0; i <= 16; ++i) {
        const float angle = glm::pi<float>() * (1.08f + 0.84f * static_cast<float>(i) / 16);
        web.push_back(0.068f * glm::vec2(std::cos(angle), std::sin(angle)));
    }
    EnginePart webs{extruded_mesh(web, 0.007f), {}};
    for (int i = 0; i < kCylinders; ++i)
        for (float side : {-0.025f, 0.025f})
            webs.copies.push_back(
                {glm::rotate(at({cylinder_x(i) + side, 0, 0}), crank_angle(i), glm::vec3(1, 0, 0)) *
                     across_x({0, 0, 0}),
                 kCrank});
    parts.push_back(std::move(webs));
    return parts;
}

EngineParts rods() {
    EngineParts parts;
    Outline shank;
    // From the big end about the origin to the small end at y = kRod.
    for (int i = 0; i <= 18; ++i) {
        const float angle = glm::pi<float>() * (0.68f + 1.64f * static_cast<float>(i) / 18);
        shank.push_back(0.034f * glm::vec2(std::cos(angle), std::sin(angle)));
    }
    for (int i = 0; i <= 12; ++i) {
        const float angle = glm::pi<float>() * (-0.25f + 1.5f * static_cast<float>(i) / 12);
        shank.push_back(glm::vec2(0, kRod) + 0.018f * glm::vec2(std::cos(angle), std::sin(angle)));
    }
    EnginePart rod{extruded_mesh(shank, 0.009f), {}};
    EnginePart web{
        extruded_mesh({{-0.006f, 0.04f}, {0.006f, 0.04f}, {0.0045f, 0.118f}, {-0.0045f, 0.118f}}, 0.0125f),
        {}};
    for (int i = 0; i < kCylinders; ++i) {
        const glm::vec2 foot = pin(i);
        const float lean = std::asin(-foot.y / kRod);
        const glm::mat4 place =
            glm::rotate(at({cylinder_x(i), foot.x, foot.y}), lean, glm::vec3(1, 0, 0)) * across_x({0, 0, 0});
        rod.copies.push_back({place, kRods});
        web.copies.push_back({place, kRods});
    }
    parts = {std::move(rod), std::move(web)};
    return parts;
}

EngineParts pistons() {
    EngineParts parts;
    Outline profile = {{0.037f, -0.022f}, {0.0415f, -0.022f}};
    for (float y : {0.004f, 0.011f, 0.018f})
        profile.insert(profile.end(),
                       {{0.0418f, y}, {0.039f, y}, {0.039f, y + 0.003f}, {0.0418f, y + 0.003f}});
    profile.insert(profile.end(), {{0.0418f, 0.0285f}, {0.03f, 0.0285f}, {0.024f, 0.026f}, {0.0f, 0.026f}});
    EnginePart crowns{lathe_mesh(profile, 40), {}};
    EnginePart insides{lathe_mesh({{0.0f, 0.02f}, {0.035f, 0.02f}, {0.037f, 0.014f}, {0.037f, -0.022f}}, 32),
                       {}};
    EnginePart rings{lathe_mesh({{0.0395f, 0.0f}, {0.0428f, 0.0f}, {0.0428f, 0.002f}, {0.0395f, 0.002f}}, 40),
                     {}};
    EnginePart pins{
        lathe_mesh({{0.006f, 0.068f}, {0.006f, 0}, {0.0095f, 0}, {0.0095f, 0.068f}, {0.006f, 0.068f}}, 20),
        {}};
    for (int i = 0; i < kCylinders; ++i) {
        const glm::vec3 place(cylinder_x(i), piston_height(i), 0);
        crowns.copies.push_back({at(place), kPiston});
        insides.copies.push_back({at(place), kPiston});
        for (float y : {0.0045f, 0.0115f, 0.0185f})
            rings.copies.push_back({at(place + glm::vec3(0, y, 0)), kRods});
        pins.copies.push_back({along_x(place - glm::vec3(0.034f, 0, 0)), kCrank});
    }
    parts = {std::move(crowns), std::move(insides), std::move(rings), std::move(pins)};
    return parts;
}

// Where a valve stands: its head at the origin, its stem along y.
std::vector<glm::mat4> valve_places() {
    std::vector<glm::mat4> places;
    for (int i = 0; i < kCylinders; ++i)
        for (float side : {-1.0f, 1.0f})
            for (float aside : {-0.019f, 0.019f}) {
                const glm::mat4 foot = at({cylinder_x(i) + aside, kDeck + 0.012f, side * 0.019f});
                places.push_back(glm::rotate(foot, side * kValveTilt, glm::vec3(1, 0, 0)));
            }
    return places;
}

EngineParts valves() {
    EngineParts parts;
    Outline profile{{0, 0}, {0.0165f, 0}, {0.0165f, 0.0015f}};
    const Outline flare = smooth_profile({{0.0165f, 0.0015f}, {0.008f, 0.006f}, {0.003f, 0.018f}}, 5);
    profile.insert(profile.end(), flare.begin() + 1, flare.end());
    profile.insert(profile.end(), {{0.003f, 0.104f}, {0.0f, 0.104f}});
    EnginePart valve{lathe_mesh(profile, 20), {}};
    EnginePart retainer{
        lathe_mesh({{0.003f, 0.096f}, {0.014f, 0.098f}, {0.014f, 0.1f}, {0.003f, 0.103f}}, 20), {}};
    EnginePart tappet{
        lathe_mesh({{0.0145f, 0.085f}, {0.0155f, 0.085f}, {0.0155f, 0.107f}, {0.0f, 0.107f}}, 24), {}};
    EnginePart guide{lathe_mesh({{0.0035f, 0.04f}, {0.006f, 0.04f}, {0.006f, 0.072f}, {0.0035f, 0.072f}}, 16),
                     {}};
    for (const glm::mat4& place : valve_places())
        for (EnginePart* part : {&valve, &retainer, &tappet, &guide})
            part->copies.push_back({place, part == &tappet ? kCam : kValve});
    parts = {std::move(valve), std::move(retainer), std::move(tappet), std::move(guide)};
    return parts;
}

EngineParts springs() {
    constexpr int kTurns = 6;
    constexpr int kSteps = 18;  // a turn
    std::vector<glm::vec3> path;
    for (int i = 0; i <= kTurns * kSteps; ++i) {
        const float angle = glm::two_pi<float>() * static_cast<float>(i) / kSteps;
        path.emplace_back(0.0115f * std::cos(angle),
                          0.062f + 0.036f * static_cast<float>(i) / (kTurns * kSteps),
                          0.0115f * std::sin(angle));
    }
    EnginePart part{tube_mesh(path, 0.0017f, 8), {}};
    for (const glm::mat4& place : valve_places()) part.copies.push_back({place, kSpring});
    return {std::move(part)};
}

EngineParts camshafts() {
    EngineParts parts;
    EnginePart shafts{lathe_mesh({{0, 0}, {0.011f, 0}, {0.011f, 0.52f}, {0, 0.52f}}, 24), {}};
    Outline egg;
    for (int i = 0; i < 28; ++i) {
        const float angle = glm::two_pi<float>() * static_cast<float>(i) / 28;
        const float lift = std::pow(std::max(std::cos(angle), 0.0f), 3.0f);
        egg.push_back((0.0155f + 0.009f * lift) * glm::vec2(std::cos(angle), std::sin(angle)));
    }
    EnginePart lobes{extruded_mesh(egg, 0.006f), {}};
    EnginePart bearings{lathe_mesh({{0.0112f, 0}, {0.017f, 0}, {0.017f, 0.014f}, {0.0112f, 0.014f}}, 24), {}};
    for (float side : {-1.0f, 1.0f}) {
        shafts.copies.push_back({along_x({-0.29f, kCamHeight, side * kCamAside}), kCam});
        for (int i = 0; i < kCylinders; ++i) {
            const float turn =
                0.5f * crank_angle(i) + side * 0.95f + (i % 2 == 0 ? 0.0f : glm::half_pi<float>());
            for (float aside : {-0.019f, 0.019f})
                lobes.copies.push_back({glm::rotate(at({cylinder_x(i) + aside, kCamHeight, side * kCamAside}),
                                                    turn, glm::vec3(1, 0, 0)) *
                                            across_x({0, 0, 0}),
                                        kCam});
        }
        for (int i = 0; i <= kCylinders; ++i)
            bearings.copies.push_back(
                {along_x({cylinder_x(i) - 0.5f * kBorePitch - 0.007f, kCamHeight, side * kCamAside}),
                 kBearing});
    }
    parts = {std::move(shafts), std::move(lobes), std::move(bearings)};
    return parts;
}

}  // namespace

EngineParts engine_train() {
    return joined({camshafts(), pistons(), springs(), crankshaft(), valves(), rods()});
}

}  // namespace ropsim
