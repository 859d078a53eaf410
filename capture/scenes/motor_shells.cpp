// The motor's shells: housing, cowl and gear case.
#include "capture/geometry/profile.h"
#include "capture/geometry/swept_mesh.h"
#include "capture/scenes/motor_parts.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

constexpr float kTau = glm::two_pi<float>();

glm::mat4 moved(glm::vec3 to) {
    return glm::translate(glm::mat4(1.0f), to);
}

}  // namespace

std::vector<glm::vec2> rounded_rectangle(glm::vec2 half, float radius, int steps) {
    std::vector<glm::vec2> outline;
    for (int corner = 0; corner < 4; ++corner) {
        const glm::vec2 sign(corner == 0 || corner == 3 ? 1.0f : -1.0f, corner < 2 ? 1.0f : -1.0f);
        for (int i = 0; i <= steps; ++i) {
            const float angle =
                0.25f * kTau *
                (static_cast<float>(corner) + static_cast<float>(i) / static_cast<float>(steps));
            outline.push_back(sign * (half - radius) + radius * glm::vec2(std::cos(angle), std::sin(angle)));
        }
    }
    return outline;
}

TriangleMesh motor_housing() {
    TriangleMesh mesh;
    append_mesh(mesh, turned_ring({{0.91f, -1.0f}, {0.98f, -1.0f}, {0.98f, 1.05f}, {0.91f, 1.05f}}, 120));
    constexpr int kFins = 44;
    const std::vector<glm::vec2> fin = {{0.97f, -0.016f}, {1.1f, -0.012f}, {1.14f, -0.009f}, {1.15f, 0},
                                        {1.14f, 0.009f},  {1.1f, 0.012f},  {0.97f, 0.016f}};
    for (int i = 0; i < kFins; ++i) {
        const float angle = kTau * (static_cast<float>(i) + 0.5f) / kFins;
        // Feet and terminal box take the place of some.
        if (std::cos(angle) > 0.88f || std::cos(angle) < -0.93f) continue;
        const glm::mat4 place = glm::rotate(glm::mat4(1.0f), angle, glm::vec3(1, 0, 0)) *
                                glm::rotate(moved({0.02f, 0, 0}), 0.25f * kTau, glm::vec3(0, 1, 0)) *
                                glm::rotate(glm::mat4(1.0f), 0.25f * kTau, glm::vec3(0, 0, 1));
        append_mesh(mesh, extruded_mesh(fin, 0.92f), place);
    }
    // The water's spiral channel in the wall.
    std::vector<glm::vec3> spiral;
    constexpr int kSteps = 13 * 56;
    for (int i = 0; i <= kSteps; ++i) {
        const float along = static_cast<float>(i) / kSteps;
        const float angle = 13 * kTau * along;
        spiral.emplace_back(-0.86f + 1.75f * along, 0.945f * std::cos(angle), 0.945f * std::sin(angle));
    }
    append_mesh(mesh, tube_mesh(spiral, 0.026f, 8));
    // End shields, dished, with a seat for the bearing.
    for (const float side : {-1.0f, 1.0f}) {
        const float x = side < 0 ? -1.0f : 1.05f;
        std::vector<glm::vec2> profile = {{0.35f, x - 0.1f * side},
                                          {0.42f, x - 0.1f * side},
                                          {0.44f, x - 0.02f * side},
                                          {0.7f, x + 0.02f * side},
                                          {0.9f, x - 0.04f * side},
                                          {1.06f, x - 0.04f * side},
                                          {1.08f, x},
                                          {1.08f, x + 0.06f * side},
                                          {0.95f, x + 0.09f * side},
                                          {0.7f, x + 0.11f * side},
                                          {0.46f, x + 0.13f * side},
                                          {0.35f, x + 0.13f * side}};
        if (side < 0) std::reverse(profile.begin(), profile.end());
        append_mesh(mesh, turned_ring(profile, 96));
    }
    return mesh;
}

TriangleMesh motor_cowl() {
    TriangleMesh mesh;
    append_mesh(mesh, turned_ring({{0.98f, -1.82f},
                                   {1.0f, -1.84f},
                                   {1.04f, -1.84f},
                                   {1.1f, -1.78f},
                                   {1.12f, -1.7f},
                                   {1.12f, -1.12f},
                                   {1.1f, -1.12f},
                                   {1.1f, -1.7f},
                                   {1.08f, -1.76f}},
                                  96));
    for (int ring = 0; ring < 9; ++ring) {
        const float radius = 0.12f + 0.105f * static_cast<float>(ring);
        append_mesh(mesh, flat_ring(radius - 0.012f, radius + 0.012f, -1.85f, -1.825f, 72));
    }
    for (int spoke = 0; spoke < 12; ++spoke) {
        const float angle = kTau * static_cast<float>(spoke) / 12;
        const glm::vec3 out(0, std::cos(angle), std::sin(angle));
        append_mesh(mesh,
                    tube_mesh({glm::vec3(-1.83f, 0, 0) + 0.1f * out, glm::vec3(-1.83f, 0, 0) + 1.0f * out},
                              0.012f, 8));
    }
    return mesh;
}

TriangleMesh motor_gear_case() {
    TriangleMesh mesh;
    // A shell about the three shafts: an oval wall carried around, a plate in front.
    std::vector<glm::vec3> wall;
    std::vector<glm::vec2> plate;
    constexpr int kSteps = 96;
    for (int i = 0; i < kSteps; ++i) {
        const float angle = kTau * static_cast<float>(i) / kSteps;
        const float bump = 0.08f * std::cos(2 * angle);
        const glm::vec2 at(-0.16f + (0.92f - bump) * std::cos(angle),
                           -0.02f + (1.16f + bump) * std::sin(angle));
        wall.emplace_back(1.72f, at.x, at.y);
        plate.emplace_back(-at.y, at.x);
    }
    SweptProfile sweep;
    sweep.path = wall;
    sweep.outline = rounded_rectangle({0.035f, 0.52f}, 0.03f, 4);
    sweep.closed = true;
    sweep.up = {1, 0, 0};
    append_mesh(mesh, swept_mesh(sweep));
    const glm::mat4 turned = glm::rotate(glm::mat4(1.0f), 0.25f * kTau, glm::vec3(0, 1, 0));
    append_mesh(mesh, extruded_mesh(plate, 0.025f), moved({2.2f, 0, 0}) * turned);
    append_mesh(mesh, extruded_mesh(plate, 0.025f), moved({1.26f, 0, 0}) * turned);
    // Bearing covers.
    append_mesh(mesh, flat_ring(0.14f, 0.38f, 2.23f, 2.34f, 64, {-0.1f, -0.52f}));
    append_mesh(mesh, flat_ring(0.02f, 0.26f, 2.23f, 2.29f, 64, {-0.42f, 0.5f}));
    return mesh;
}

}  // namespace ropsim
