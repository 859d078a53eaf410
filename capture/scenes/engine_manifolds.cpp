// The engine's manifolds: what brings air and fuel in, and what takes the exhaust out.
#include "capture/geometry/lathe_mesh.h"
#include "capture/geometry/profile.h"
#include "capture/geometry/swept_mesh.h"
#include "capture/scenery/scene_parts.h"
#include "capture/scenes/engine_parts.h"

#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

constexpr EngineFinish kOutlet{"exhaust", {0.62f, 0.25f, 0.08f, 0.26f}};

glm::mat4 at(glm::vec3 position) {
    return glm::translate(glm::mat4(1.0f), position);
}

std::vector<glm::vec3> bezier(glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d, int steps) {
    std::vector<glm::vec3> path;
    for (int i = 0; i <= steps; ++i) {
        const float t = static_cast<float>(i) / static_cast<float>(steps);
        const float u = 1 - t;
        path.push_back(u * u * u * a + 3 * u * u * t * b + 3 * u * t * t * c + t * t * t * d);
    }
    return path;
}

EngineParts inlet() {
    EngineParts parts;
    EnginePart runners;
    for (float radius : {0.0235f, 0.02f})
        append_mesh(runners.mesh, tube_mesh(bezier({0, 0.285f, 0.095f}, {0, 0.29f, 0.2f}, {0, 0.3f, 0.27f},
                                                   {0, 0.385f, 0.225f}, 16),
                                            radius, 24));
    append_mesh(runners.mesh, box_mesh(), placed({0, 0.283f, 0.102f}, {0.035f, 0.03f, 0.004f}));
    for (int i = 0; i < kCylinders; ++i) runners.copies.push_back({at({cylinder_x(i), 0, 0}), kInletFinish});
    EnginePart plenum;
    for (float wall : {0.0f, 0.004f})
        append_mesh(plenum.mesh, lathe_mesh(smooth_profile({{0.0f, wall},
                                                            {0.035f, 0.008f + wall},
                                                            {0.052f - wall, 0.045f},
                                                            {0.053f - wall, 0.2f},
                                                            {0.052f - wall, 0.385f},
                                                            {0.035f, 0.422f - wall},
                                                            {0.0f, 0.43f - wall}},
                                                           6),
                                            36));
    plenum.copies = {{along_x({-0.215f, 0.4f, 0.2f}), kInletFinish}};
    // Throttle body with its plate.
    EnginePart throttle{lathe_mesh({{0.028f, 0},
                                    {0.028f, 0.075f},
                                    {0.024f, 0.075f},
                                    {0.024f, 0.0f},
                                    {0.034f, 0.0f},
                                    {0.034f, 0.006f},
                                    {0.028f, 0.0065f}},
                                   32),
                        {{along_x({-0.285f, 0.4f, 0.2f}), kAccessoryFinish}}};
    EnginePart plate{lathe_mesh({{0, 0}, {0.0235f, 0}, {0.0235f, 0.002f}, {0, 0.002f}}, 28),
                     {{glm::rotate(along_x({-0.25f, 0.4f, 0.2f}), 0.5f, glm::vec3(1, 0, 0)), kBoltFinish}}};
    // Fuel rail and injectors.
    EnginePart rail{lathe_mesh({{0, 0}, {0.009f, 0}, {0.009f, 0.38f}, {0, 0.38f}}, 16),
                    {{along_x({-0.19f, 0.345f, 0.135f}), kFilterFinish}}};
    EnginePart injectors{lathe_mesh({{0, 0},
                                     {0.003f, 0},
                                     {0.004f, 0.02f},
                                     {0.008f, 0.022f},
                                     {0.008f, 0.045f},
                                     {0.005f, 0.047f},
                                     {0.005f, 0.058f},
                                     {0, 0.058f}},
                                    16),
                         {}};
    for (int i = 0; i < kCylinders; ++i)
        injectors.copies.push_back(
            {glm::rotate(at({cylinder_x(i), 0.293f, 0.112f}), 0.42f, glm::vec3(1, 0, 0)), kPlugFinish});
    parts = {std::move(runners), std::move(plenum), std::move(throttle),
             std::move(plate),   std::move(rail),   std::move(injectors)};
    return parts;
}

EngineParts outlet() {
    EngineParts parts;
    for (int i = 0; i < kCylinders; ++i) {
        EnginePart pipe;
        const float x = cylinder_x(i);
        const float gather = 0.02f * (static_cast<float>(i) - 1.5f);
        const auto path = bezier({x, 0.28f, -0.095f}, {x, 0.27f, -0.23f}, {0.1f + 2 * gather, 0.16f, -0.25f},
                                 {0.1f + gather, -0.02f, -0.19f + 0.014f * static_cast<float>(i % 2)}, 20);
        for (float radius : {0.0205f, 0.0185f}) append_mesh(pipe.mesh, tube_mesh(path, radius, 22));
        append_mesh(pipe.mesh, box_mesh(), placed({x, 0.28f, -0.102f}, {0.036f, 0.03f, 0.004f}));
        pipe.copies = {{glm::mat4(1.0f), kOutlet}};
        parts.push_back(std::move(pipe));
    }
    EnginePart collector;
    append_mesh(collector.mesh, lathe_mesh({{0.03f, 0}, {0.045f, 0.08f}, {0.045f, 0.11f}}, 30),
                at({0.1f, -0.115f, -0.185f}));
    for (float radius : {0.03f, 0.027f})
        append_mesh(collector.mesh, tube_mesh(bezier({0.1f, -0.11f, -0.185f}, {0.1f, -0.17f, -0.185f},
                                                     {0.16f, -0.18f, -0.17f}, {0.34f, -0.18f, -0.14f}, 14),
                                              radius, 26));
    collector.copies = {{glm::mat4(1.0f), kOutlet}};
    parts.push_back(std::move(collector));
    return parts;
}

}  // namespace

EngineParts engine_manifolds() {
    return joined({inlet(), outlet()});
}

}  // namespace ropsim
