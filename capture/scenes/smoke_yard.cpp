// A street, a chain-link fence, a yard behind it with cars, trees and houses.
#include "capture/scenes/smoke_yard.h"

#include "base/random.h"
#include "capture/geometry/pipe_mesh.h"
#include "capture/geometry/tree_growth.h"
#include "capture/geometry/vehicle_mesh.h"
#include "capture/scenery/scene_parts.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ropsim {
namespace {

constexpr glm::vec4 kSteel(0.35f, 0.36f, 0.37f, 1);
constexpr glm::vec4 kWindowPane(0.1f, 0.14f, 0.17f, 0.42f);
constexpr glm::vec4 kShelterPane(0.3f, 0.42f, 0.4f, 0.22f);
constexpr float kWireMesh = 0.11f;  // metres from wire to wire
constexpr float kFenceHeight = 2.2f;

void add_bar(SceneryMesh& mesh, glm::vec3 from, glm::vec3 to, float radius, glm::vec4 color) {
    const std::array<glm::vec3, 2> path = {from, to};
    const std::array<float, 2> radii = {radius, radius};
    mesh.add(pipe_mesh(path, radii, {.sides = 10, .capped = true}), glm::mat4(1.0f), color);
}

// A strip of ground from the front edge to the back edge, finely divided where shadows fall.
void add_ground(SceneryMesh& ground, float from_z, float to_z, float y, glm::vec4 color, Finish finish) {
    const auto strip = [&](float from_x, float to_x, int columns, int rows) {
        ground.add_quad({from_x, y, from_z}, {to_x, y, from_z}, {to_x, y, to_z}, {from_x, y, to_z}, color,
                        finish, columns, rows);
    };
    const int rows = std::max(1, static_cast<int>((from_z - to_z) / 0.16f));
    strip(-60, -16, 1, rows);
    strip(-16, 16, 200, rows);
    strip(16, 60, 1, rows);
}

void add_grounds(SmokeYard& yard) {
    const glm::vec4 asphalt(0.085f, 0.085f, 0.09f, 1);
    const glm::vec4 paving(0.3f, 0.29f, 0.27f, 1);
    const glm::vec4 kerb(0.42f, 0.41f, 0.39f, 1);
    const glm::vec4 dirt(0.17f, 0.155f, 0.08f, 1);
    add_ground(yard.ground, 14, 5.2f, -0.12f, asphalt, Finish::kGround);
    add_ground(yard.ground, 5.2f, 5.0f, 0.0f, kerb, Finish::kPlain);
    add_ground(yard.ground, 5.0f, 0.6f, 0.0f, paving, Finish::kPlain);
    add_ground(yard.ground, 0.6f, -18, 0.0f, dirt, Finish::kGround);
    yard.ground.add_quad({-60, -0.12f, 5.2f}, {60, -0.12f, 5.2f}, {60, 0, 5.2f}, {-60, 0, 5.2f}, kerb,
                         Finish::kPlain, 240, 1);
    yard.ground.add_quad({-90, -0.02f, -17}, {90, -0.02f, -17}, {90, -0.02f, -90}, {-90, -0.02f, -90}, dirt,
                         Finish::kGround);
    for (int i = -4; i <= 4; ++i) {
        const float x = 3.4f * static_cast<float>(i);
        yard.ground.add_quad({x, -0.115f, 8.1f}, {x + 1.6f, -0.115f, 8.1f}, {x + 1.6f, -0.115f, 7.97f},
                             {x, -0.115f, 7.97f}, {0.6f, 0.6f, 0.57f, 1}, Finish::kPlain, 10, 1);
    }
}

// Dark behind its windows, whose panes stand a little proud.
void add_house(SmokeYard& yard, glm::vec3 foot, glm::vec3 size, glm::vec3 color, Finish finish, int columns,
               int floors) {
    const glm::vec3 middle = foot + glm::vec3(0, 0.5f * size.y, -0.5f * size.z);
    yard.solids.add_box(middle, 0.5f * size, glm::vec4(color, 1), finish);
    yard.shadow.add_box(middle, 0.5f * size);
    const glm::vec4 stone(0.55f, 0.52f, 0.47f, 1);
    yard.solids.add_box(foot + glm::vec3(0, size.y + 0.1f, -0.5f * size.z),
                        {0.5f * size.x + 0.15f, 0.14f, 0.5f * size.z + 0.15f}, stone);
    const float step = size.x / static_cast<float>(columns);
    const float floor_height = size.y / static_cast<float>(floors);
    for (int column = 0; column < columns; ++column) {
        for (int level = 0; level < floors; ++level) {
            const glm::vec3 at = foot + glm::vec3((static_cast<float>(column) + 0.5f) * step - 0.5f * size.x,
                                                  (static_cast<float>(level) + 0.52f) * floor_height, 0);
            const glm::vec2 half(0.3f * step, 0.3f * floor_height);
            yard.solids.add_box(at + glm::vec3(0, 0, 0.01f), {half.x, half.y, 0.012f},
                                {0.02f, 0.022f, 0.026f, 1});
            yard.house_glass.add_quad(
                at + glm::vec3(-half.x, -half.y, 0.06f), at + glm::vec3(half.x, -half.y, 0.06f),
                at + glm::vec3(half.x, half.y, 0.06f), at + glm::vec3(-half.x, half.y, 0.06f), kWindowPane,
                Finish::kPlain, 2, 2);
            yard.solids.add_box(at - glm::vec3(0, half.y + 0.05f, -0.08f), {half.x + 0.1f, 0.05f, 0.12f},
                                stone);
            for (float x : {-half.x, 0.0f, half.x})
                yard.solids.add_box(at + glm::vec3(x, 0, 0.05f), {0.035f, half.y, 0.035f}, stone);
            for (float y : {0.25f * half.y, half.y})
                yard.solids.add_box(at + glm::vec3(0, y, 0.05f), {half.x, 0.035f, 0.035f}, stone);
        }
    }
}

void add_shelter(SmokeYard& yard, glm::vec3 foot) {
    const float width = 3.4f;
    const float depth = 1.3f;
    const float height = 2.3f;
    const auto at = [&](float x, float y, float z) { return foot + glm::vec3(x, y, z); };
    for (float x : {0.0f, width / 3, 2 * width / 3, width})
        add_bar(yard.solids, at(x, 0, 0), at(x, height, 0), 0.035f, kSteel);
    for (float x : {0.0f, width}) {
        add_bar(yard.solids, at(x, 0, depth), at(x, height, depth), 0.035f, kSteel);
        yard.house_glass.add_quad(at(x, 0.25f, 0), at(x, 0.25f, depth), at(x, 2.1f, depth), at(x, 2.1f, 0),
                                  kShelterPane, Finish::kPlain, 3, 3);
    }
    for (int i = 0; i < 3; ++i) {
        const float from = static_cast<float>(i) * width / 3;
        yard.house_glass.add_quad(at(from, 0.25f, 0), at(from + width / 3, 0.25f, 0),
                                  at(from + width / 3, 2.1f, 0), at(from, 2.1f, 0), kShelterPane,
                                  Finish::kPlain, 3, 3);
    }
    yard.solids.add_box(at(0.5f * width, height + 0.06f, 0.5f * depth + 0.1f),
                        {0.5f * width + 0.15f, 0.06f, 0.5f * depth + 0.3f}, {0.1f, 0.2f, 0.17f, 1},
                        Finish::kLacquer);
    yard.shadow.add_box(at(0.5f * width, height, 0.5f * depth + 0.1f),
                        {0.5f * width + 0.15f, 0.06f, 0.5f * depth + 0.3f});
    yard.solids.add_box(at(0.5f * width, 0.46f, 0.35f), {1.1f, 0.03f, 0.18f}, {0.3f, 0.17f, 0.08f, 1});
    for (float x : {0.5f, width - 0.5f})
        yard.solids.add_box(at(x, 0.22f, 0.35f), {0.03f, 0.22f, 0.12f}, kSteel);
}

// Posts and rails, and wire between neighbouring posts.
void add_fence(SmokeYard& yard, glm::vec3 from, glm::vec3 to) {
    const int panels = static_cast<int>(std::round(glm::length(to - from) / 1.1f));
    const glm::vec3 up(0, kFenceHeight, 0);
    add_bar(yard.solids, from + up, to + up, 0.025f, kSteel);
    for (int i = 0; i <= panels; ++i) {
        const glm::vec3 post = glm::mix(from, to, static_cast<float>(i) / static_cast<float>(panels));
        if (i % 2 == 0) add_bar(yard.solids, post, post + 1.04f * up, 0.032f, kSteel);
        if (i == panels) break;
        Card card{};
        const glm::vec3 half = (to - from) / (2.0f * static_cast<float>(panels));
        card.centre = post + half + 0.5f * up + glm::vec3(0, 0.02f, 0);
        card.right = half;
        card.up = 0.5f * up;
        card.columns = std::round(2 * glm::length(half) / kWireMesh);
        card.rows = std::round(kFenceHeight / kWireMesh);
        card.light = 0.75f;
        card.color = glm::vec4(0.8f, 0.82f, 0.85f, 1);
        yard.fence.push_back(card);
    }
}

void add_vehicle(SmokeYard& yard, const Vehicle& vehicle, glm::vec3 foot, float yaw, glm::vec3 half) {
    const glm::mat4 model = placed(foot, glm::vec3(1), yaw);
    yard.solids.add(vehicle.body, model);
    yard.car_glass.add(vehicle.glass, model);
    yard.shadow.add_box(foot + glm::vec3(0, 0.95f * half.y, 0), half * glm::vec3(1, 0.45f, 1), yaw);
    yard.shadow.add_box(foot + glm::vec3(0, 1.6f * half.y, 0), half * glm::vec3(0.45f, 0.4f, 0.8f), yaw);
}

void add_barrel(SmokeYard& yard, glm::vec3 foot) {
    const std::vector<glm::vec3> path = {foot, foot + glm::vec3(0, 0.86f, 0), foot + glm::vec3(0, 0.88f, 0),
                                         foot + glm::vec3(0, 0.55f, 0)};
    const std::vector<float> radii = {0.29f, 0.29f, 0.27f, 0.26f};
    yard.solids.add(pipe_mesh(std::span(path).first(2), std::span(radii).first(2), {.sides = 28}),
                    glm::mat4(1.0f), {0.28f, 0.12f, 0.06f, 1}, Finish::kGround);
    for (float y : {0.03f, 0.3f, 0.57f, 0.85f}) {
        const std::array<glm::vec3, 2> rib = {foot + glm::vec3(0, y, 0), foot + glm::vec3(0, y + 0.025f, 0)};
        const std::array<float, 2> wide = {0.305f, 0.305f};
        yard.solids.add(pipe_mesh(rib, wide, {.sides = 28, .capped = true}), glm::mat4(1.0f),
                        {0.2f, 0.09f, 0.05f, 1}, Finish::kGround);
    }
    yard.shadow.add_box(foot + glm::vec3(0, 0.45f, 0), {0.26f, 0.45f, 0.26f});
}

void add_plants(SmokeYard& yard, double foliage, std::uint64_t seed) {
    const auto plant = [&](TreeForm form, glm::vec3 foot, std::uint64_t key) {
        form.cards = static_cast<int>(std::lround(foliage * form.cards));
        grow_tree(form, foot, mix64(seed + key), yard.solids, yard.twigs);
        const float crown = form.height * (1 - form.crown_from);
        yard.shadow.add_ball(foot + glm::vec3(0, form.height - 0.5f * crown, 0),
                             {0.9f * form.crown_radius, 0.45f * crown, 0.9f * form.crown_radius}, 0.75f);
    };
    plant({.height = 7.6f,
           .trunk_radius = 0.2f,
           .crown_from = 0.32f,
           .crown_radius = 2.7f,
           .branches = 22,
           .cards = 385,
           .card_size = 0.5f},
          {-8.6f, 0, -4.5f}, 1);
    plant({.height = 6.4f,
           .trunk_radius = 0.17f,
           .crown_from = 0.36f,
           .crown_radius = 2.1f,
           .branches = 18,
           .cards = 302,
           .card_size = 0.45f},
          {8.6f, 0, -3.2f}, 2);
    plant({.height = 8.5f,
           .trunk_radius = 0.2f,
           .crown_from = 0.3f,
           .crown_radius = 2.6f,
           .branches = 20,
           .cards = 302,
           .card_size = 0.55f},
          {1.6f, 0, -12.0f}, 3);
    for (int i = 0; i < 9; ++i) {
        const std::uint64_t key = mix64(seed ^ (0x42757368ull << 32) ^ static_cast<std::uint64_t>(i));
        const float high = 0.8f + 0.7f * random_unit(key, 0);
        const float x =
            i < 4 ? -10.5f + 1.25f * static_cast<float>(i) : 3.6f + 1.5f * static_cast<float>(i - 4);
        plant({.height = high,
               .trunk_radius = 0,
               .crown_from = 0.0f,
               .crown_radius = 0.75f,
               .branches = 9,
               .cards = 70,
               .card_size = 0.24f},
              {x, 0, -0.55f - 0.8f * random_unit(key, 1)}, 10 + static_cast<std::uint64_t>(i));
    }
}

}  // namespace

SmokeYard make_smoke_yard(double foliage, std::uint64_t seed) {
    SmokeYard yard;
    add_grounds(yard);
    add_house(yard, {-13.0f, 0, -17}, {13, 8.4f, 8}, {0.36f, 0.14f, 0.09f}, Finish::kBricks, 6, 3);
    add_house(yard, {-0.5f, 0, -18.5f}, {9.5f, 5.6f, 8}, {0.5f, 0.46f, 0.37f}, Finish::kPlain, 4, 2);
    add_house(yard, {13.5f, 0, -17}, {15, 9.8f, 8}, {0.3f, 0.17f, 0.12f}, Finish::kBricks, 7, 3);
    add_shelter(yard, {-7.6f, 0, 2.2f});
    add_fence(yard, {-13.2f, 0, 0}, {13.2f, 0, 0});
    add_fence(yard, {5.5f, 0, 0}, {7.2f, 0, -12.1f});
    add_vehicle(yard, make_car({0.42f, 0.045f, 0.035f}), kCarFire - glm::vec3(1.5f, 1.0f, -0.1f), 0.12f,
                {2.2f, 0.72f, 0.85f});
    add_vehicle(yard, make_van({0.55f, 0.56f, 0.55f}), {3.3f, 0, -6.2f}, 0.5f, {2.5f, 1.05f, 0.95f});
    add_vehicle(yard, make_car({0.06f, 0.13f, 0.3f}), {4.5f, -0.12f, 6.3f}, 2.95f, {2.2f, 0.72f, 0.85f});
    add_barrel(yard, kBarrelFire - glm::vec3(0, 0.9f, 0));
    add_plants(yard, foliage, seed);
    return yard;
}

SceneTexture wire_texture() {
    constexpr int kSide = 64;
    SceneTexture texture;
    texture.width = texture.height = kSide;
    texture.channels = 4;
    for (int y = 0; y < kSide; ++y) {
        for (int x = 0; x < kSide; ++x) {
            const float u = (static_cast<float>(x) + 0.5f) / kSide;
            const float v = (static_cast<float>(y) + 0.5f) / kSide;
            // Two wires across the cell, in a zigzag from its corners; distances in cells.
            const auto off = [](float t) { return std::abs(t - std::round(t)) * std::sqrt(0.5f); };
            const float nearest = std::min(off(u - v), off(u + v));
            const float cover = std::clamp(0.5f + (0.042f - nearest) * kSide, 0.0f, 1.0f);
            const float round = std::sqrt(std::max(0.0f, 1 - nearest * nearest / (0.05f * 0.05f)));
            const float tone = 0.3f + 0.4f * round;
            texture.values.insert(texture.values.end(), {tone, tone, tone, cover});
        }
    }
    return texture;
}

}  // namespace ropsim
