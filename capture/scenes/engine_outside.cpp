// The engine's outside: gears, belts and pulleys, accessories and bolts.
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

constexpr EngineFinish kGear{"gears", {0.5f, 0.36f, 0.08f, 0.4f}};
constexpr EngineFinish kBelt{"belts", {0.05f, 0.05f, 0.06f, 0.5f}};
constexpr EngineFinish kPulley{"pulleys", {0.12f, 0.22f, 0.5f, 0.4f}};

constexpr float kTimingX = -0.25f;
constexpr float kBeltX = -0.3f;

glm::mat4 at(glm::vec3 position) {
    return glm::translate(glm::mat4(1.0f), position);
}

// Pulleys of the belt that drives the accessories: y, z, radius.
constexpr glm::vec3 kAlternator(0.19f, 0.17f, 0.03f);
constexpr glm::vec3 kCompressor(-0.02f, 0.16f, 0.045f);
constexpr glm::vec3 kWaterPump(0.13f, -0.02f, 0.042f);
constexpr glm::vec3 kSteering(0.17f, -0.15f, 0.045f);
constexpr glm::vec3 kCrankPulley(0.0f, 0.0f, 0.06f);

float turn(glm::vec2 a, glm::vec2 b, glm::vec2 c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// A belt round the outside of all wheels (y, z, radius), `width` wide about x.
TriangleMesh belt_mesh(const std::vector<glm::vec3>& wheels, float x, float width) {
    std::vector<glm::vec2> points;
    for (const glm::vec3& wheel : wheels)
        for (const glm::vec2& p : circle_outline(wheel.z + 0.003f, 64))
            points.push_back(p + glm::vec2(wheel));
    // The convex hull, by Andrew's monotone chain.
    std::sort(points.begin(), points.end(),
              [](glm::vec2 a, glm::vec2 b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
    std::vector<glm::vec2> hull;
    for (int side = 0; side < 2; ++side) {
        const std::size_t start = hull.size();
        for (const glm::vec2& p : points) {
            while (hull.size() >= start + 2 && turn(hull[hull.size() - 2], hull.back(), p) <= 0)
                hull.pop_back();
            hull.push_back(p);
        }
        hull.pop_back();
        std::reverse(points.begin(), points.end());
    }
    SweptProfile sweep;
    for (const glm::vec2& p : hull) sweep.path.emplace_back(x, p.x, p.y);
    sweep.outline = {{-0.0025f, -0.5f * width},
                     {0.0025f, -0.5f * width},
                     {0.0025f, 0.5f * width},
                     {-0.0025f, 0.5f * width}};
    sweep.closed = true;
    sweep.up = {1, 0, 0};
    return swept_mesh(sweep);
}

EngineParts belts() {
    const std::vector<glm::vec3> timing = {{kCamHeight, kCamAside, 0.044f},
                                           {kCamHeight, -kCamAside, 0.044f},
                                           {0, 0, 0.03f},
                                           {0.15f, -0.06f, 0.028f}};
    EngineParts parts;
    parts.push_back({belt_mesh(timing, kTimingX, 0.02f), {{glm::mat4(1.0f), kBelt}}});
    parts.push_back({belt_mesh({kAlternator, kCompressor, kCrankPulley, kSteering}, kBeltX, 0.022f),
                     {{glm::mat4(1.0f), kBelt}}});
    return parts;
}

EngineParts gears() {
    EngineParts parts;
    EnginePart cams{extruded_mesh(gear_outline(0.0405f, 0.0445f, 36), 0.009f), {}};
    for (float side : {-1.0f, 1.0f})
        cams.copies.push_back({across_x({kTimingX, kCamHeight, side * kCamAside}), kGear});
    parts.push_back(std::move(cams));
    parts.push_back(
        {extruded_mesh(gear_outline(0.026f, 0.03f, 22), 0.009f), {{across_x({kTimingX, 0, 0}), kGear}}});
    parts.push_back({lathe_mesh({{0, -0.01f}, {0.025f, -0.01f}, {0.025f, 0.01f}, {0, 0.01f}}, 28),
                     {{along_x({kTimingX, 0.15f, -0.06f}), kGear}}});
    // Flywheel with its ring gear, and the starter's pinion.
    parts.push_back(
        {extruded_mesh(gear_outline(0.118f, 0.124f, 96), 0.006f), {{across_x({0.275f, 0, 0}), kGear}}});
    parts.push_back(
        {lathe_mesh(
             {{0.02f, 0}, {0.113f, 0}, {0.113f, 0.012f}, {0.085f, 0.014f}, {0.08f, 0.008f}, {0.02f, 0.008f}},
             48),
         {{along_x({0.282f, 0, 0}), kGear}}});
    parts.push_back({extruded_mesh(gear_outline(0.015f, 0.021f, 11), 0.012f),
                     {{across_x({0.275f, 0.03f, 0.137f}), kGear}}});
    return parts;
}

EngineParts pulleys() {
    EngineParts parts;
    for (const glm::vec3& wheel : {kAlternator, kCompressor, kWaterPump, kSteering, kCrankPulley}) {
        // Five grooves under the belt, a dished web, a hub.
        const float r = wheel.z;
        Outline profile{{0.3f * r, -0.012f}, {0.45f * r, -0.012f},  {0.45f * r, -0.003f}, {0.8f * r, -0.003f},
                        {0.8f * r, -0.012f}, {r + 0.003f, -0.012f}, {r + 0.003f, -0.01f}};
        for (int groove = 0; groove < 5; ++groove) {
            const float y = -0.009f + 0.0036f * static_cast<float>(groove);
            profile.insert(profile.end(), {{r, y}, {r - 0.003f, y + 0.0018f}});
        }
        profile.insert(profile.end(), {{r, 0.009f},
                                       {r + 0.003f, 0.01f},
                                       {r + 0.003f, 0.012f},
                                       {0.8f * r, 0.012f},
                                       {0.8f * r, 0.003f},
                                       {0.3f * r, 0.003f},
                                       {0.3f * r, -0.012f}});
        parts.push_back({lathe_mesh(profile, 40, 20), {{along_x({kBeltX, wheel.x, wheel.y}), kPulley}}});
    }
    return parts;
}

EngineParts accessories() {
    EngineParts parts;
    // The alternator: a finned body, its rotor and stator.
    EnginePart alternator;
    Outline body{{0.012f, 0}, {0.04f, 0}, {0.052f, 0.012f}};
    for (int fin = 0; fin < 7; ++fin) {
        const float y = 0.018f + 0.011f * static_cast<float>(fin);
        body.insert(body.end(),
                    {{0.052f, y}, {0.056f, y + 0.001f}, {0.056f, y + 0.005f}, {0.052f, y + 0.006f}});
    }
    body.insert(body.end(), {{0.052f, 0.105f}, {0.035f, 0.115f}, {0.012f, 0.115f}});
    append_mesh(alternator.mesh, lathe_mesh(body, 36));
    append_mesh(alternator.mesh,
                lathe_mesh({{0.036f, 0.02f}, {0.048f, 0.02f}, {0.048f, 0.09f}, {0.036f, 0.09f}}, 30));
    append_mesh(
        alternator.mesh,
        lathe_mesh(
            {{0, -0.03f}, {0.008f, -0.03f}, {0.008f, 0.02f}, {0.033f, 0.022f}, {0.033f, 0.085f}, {0, 0.085f}},
            30));
    alternator.copies = {{along_x({kBeltX + 0.02f, kAlternator.x, kAlternator.y}), kAccessoryFinish}};
    const TriangleMesh drum = lathe_mesh({{0, -0.02f},
                                          {0.009f, -0.02f},
                                          {0.009f, 0},
                                          {0.038f, 0},
                                          {0.048f, 0.01f},
                                          {0.048f, 0.045f},
                                          {0.052f, 0.046f},
                                          {0.052f, 0.056f},
                                          {0.048f, 0.057f},
                                          {0.048f, 0.115f},
                                          {0.03f, 0.125f},
                                          {0, 0.125f}},
                                         36);
    EnginePart drums{drum, {}};
    for (const glm::vec3& place : {kCompressor, kSteering})
        drums.copies.push_back({along_x({kBeltX + 0.02f, place.x, place.y}), kAccessoryFinish});
    EnginePart pump{
        lathe_mesh(
            {{0, -0.02f}, {0.01f, -0.02f}, {0.01f, 0.0f}, {0.038f, 0.012f}, {0.042f, 0.035f}, {0.03f, 0.05f}},
            32),
        {{along_x({kBeltX + 0.02f, kWaterPump.x, kWaterPump.y}), kInletFinish}}};
    EnginePart starter{lathe_mesh({{0, -0.03f},
                                   {0.01f, -0.03f},
                                   {0.01f, 0.0f},
                                   {0.034f, 0.004f},
                                   {0.034f, 0.12f},
                                   {0.03f, 0.13f},
                                   {0, 0.13f}},
                                  32),
                       {{along_x({0.12f, 0.03f, 0.137f}), kPulley}}};
    EnginePart filter{
        lathe_mesh({{0.03f, 0}, {0.037f, 0.003f}, {0.037f, 0.085f}, {0.03f, 0.095f}, {0, 0.097f}}, 32),
        {{glm::rotate(at({0.03f, 0.03f, 0.095f}), glm::half_pi<float>(), glm::vec3(1, 0, 0)),
          kFilterFinish}}};
    EnginePart cap{lathe_mesh({{0, 0}, {0.028f, 0}, {0.028f, 0.016f}, {0.022f, 0.02f}, {0, 0.02f}}, 12),
                   {{at({-0.12f, 0.4f, -0.045f}), kBelt}}};
    EnginePart plugs{lathe_mesh({{0, -0.02f},
                                 {0.004f, -0.02f},
                                 {0.007f, 0},
                                 {0.007f, 0.025f},
                                 {0.011f, 0.026f},
                                 {0.011f, 0.036f},
                                 {0.006f, 0.038f},
                                 {0.0045f, 0.07f},
                                 {0, 0.072f}},
                                16),
                     {}};
    EnginePart coils{
        lathe_mesh({{0.012f, 0.0f}, {0.012f, 0.12f}, {0.02f, 0.121f}, {0.02f, 0.15f}, {0, 0.152f}}, 20), {}};
    for (int i = 0; i < kCylinders; ++i) {
        plugs.copies.push_back({at({cylinder_x(i), kDeck + 0.04f, 0}), kPlugFinish});
        coils.copies.push_back({at({cylinder_x(i), kDeck + 0.065f, 0}), kBelt});
    }
    parts = {std::move(alternator), std::move(drums), std::move(pump),  std::move(starter),
             std::move(filter),     std::move(cap),   std::move(plugs), std::move(coils)};
    return parts;
}

EngineParts bolts() {
    // A hexagonal head with a flange, its shank below.
    TriangleMesh bolt = lathe_mesh(
        {{0, -0.03f}, {0.0032f, -0.03f}, {0.0032f, 0}, {0.0085f, 0}, {0.0085f, 0.0012f}, {0.006f, 0.0014f}},
        14);
    append_mesh(bolt, lathe_mesh({{0.0068f, 0.0012f}, {0.0068f, 0.0065f}, {0.0f, 0.0065f}}, 6));
    EnginePart part{std::move(bolt), {}};
    const auto add = [&](glm::vec3 place, glm::vec3 away) {
        // Turns +y to `away`, which is along an axis.
        glm::mat4 model = at(place);
        if (away.z != 0) model = glm::rotate(model, away.z * glm::half_pi<float>(), glm::vec3(1, 0, 0));
        if (away.x != 0) model = glm::rotate(model, -away.x * glm::half_pi<float>(), glm::vec3(0, 0, 1));
        if (away.y < 0) model = glm::rotate(model, glm::pi<float>(), glm::vec3(1, 0, 0));
        part.copies.push_back({model, kBoltFinish});
    };
    for (int i = 0; i <= 8; ++i) {
        const float x = kBlockHalfLength * (0.22f * static_cast<float>(i) - 0.88f);
        for (float side : {-1.0f, 1.0f}) {
            add({x, 0.372f, side * 0.096f}, {0, 1, 0});
            add({x, -0.048f, side * 0.074f}, {0, -1, 0});
            add({x, 0.21f, side * 0.076f}, {0, 0, side});
        }
    }
    for (int i = 0; i < kCylinders; ++i)
        for (float aside : {-0.028f, 0.028f})
            for (float side : {-1.0f, 1.0f}) {
                add({cylinder_x(i) + aside, 0.283f + 0.022f * (aside < 0 ? -1.0f : 1.0f), side * 0.107f},
                    {0, 0, side});
                add({cylinder_x(i) + 1.7f * aside, kHeadTop - 0.004f, side * 0.022f}, {0, 1, 0});
            }
    for (int i = 0; i < 8; ++i) {
        const float angle = glm::two_pi<float>() * static_cast<float>(i) / 8;
        add({0.291f, 0.034f * std::cos(angle), 0.034f * std::sin(angle)}, {1, 0, 0});
        if (i % 2 == 0) add({kBeltX - 0.004f, 0.02f * std::cos(angle), 0.02f * std::sin(angle)}, {-1, 0, 0});
    }
    return {std::move(part)};
}

}  // namespace

EngineParts engine_outside() {
    return joined({pulleys(), belts(), bolts(), gears(), accessories()});
}

}  // namespace ropsim
