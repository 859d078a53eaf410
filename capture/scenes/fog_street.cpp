// Houses, lamp posts, two people and a tree, from boxes, surfaces of revolution and tubes.
#include "capture/scenes/fog_street.h"

#include "base/random.h"
#include "capture/geometry/lathe_mesh.h"
#include "capture/geometry/profile.h"
#include "capture/geometry/swept_mesh.h"
#include "capture/scenery/scene_parts.h"
#include "capture/shader_sources.h"

#include <cmath>
#include <string>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

enum Pattern { kPlain = 0, kCobbles = 1, kHouse = 2, kShining = 3 };

constexpr float kFlame = 3.9f;  // height of a lamp's flame, metres
constexpr glm::vec3 kIron(0.03f, 0.032f, 0.035f);
constexpr glm::vec3 kTree(3.1f, 0.0f, -1.2f);

glm::vec4 painted(glm::vec3 color, Pattern pattern = kPlain) {
    return {color, static_cast<float>(pattern)};
}

MeshInstance box(glm::vec3 low, glm::vec3 high, glm::vec3 color, Pattern pattern = kPlain) {
    return {placed(0.5f * (low + high), 0.5f * (high - low)), painted(color, pattern)};
}

glm::vec3 lamp_foot(int lamp) {
    const float z = -3.0f - 6.5f * static_cast<float>(lamp);
    return {lamp % 2 == 0 ? -3.4f : 3.4f, 0, z};
}

std::vector<MeshInstance> houses(std::uint64_t seed) {
    std::vector<MeshInstance> all = {
        box({-3.6f, -0.3f, -kStreetLength}, {3.6f, 0.0f, 12}, {0.2f, 0.2f, 0.21f}, kCobbles),
        box({-6, -0.3f, -kStreetLength}, {-3.6f, 0.13f, 12}, {0.22f, 0.21f, 0.2f}),
        box({3.6f, -0.3f, -kStreetLength}, {6, 0.13f, 12}, {0.22f, 0.21f, 0.2f}),
        box({-8, 0, -kStreetLength - 4}, {8, 13, -kStreetLength}, {0.2f, 0.17f, 0.15f}, kHouse)};
    for (int side = 0; side < 2; ++side) {
        float z = 9;
        for (std::uint32_t i = 0; z > -kStreetLength; ++i) {
            const std::uint64_t key = mix64(seed ^ 0x486F7573ull) + 64 * static_cast<std::uint64_t>(side) + i;
            const float length = 6 + 5 * random_unit(key, 0);
            const float height = 8 + 6 * random_unit(key, 1);
            const float front = kStreetHalfWidth + 0.5f * random_unit(key, 2);
            const glm::vec3 brick(0.2f + 0.16f * random_unit(key, 3), 0.13f + 0.09f * random_unit(key, 4),
                                  0.1f + 0.06f * random_unit(key, 5));
            const float x = side == 0 ? -1.0f : 1.0f;
            const glm::vec3 a(x * front, 0, z - length);
            const glm::vec3 b(x * (front + 6), height, z);
            all.push_back(box(glm::min(a, b), glm::max(a, b), brick, kHouse));
            const glm::vec3 c(x * (front - 0.18f), height, z - length);
            const glm::vec3 d(x * (front + 6), height + 0.3f, z);
            all.push_back(box(glm::min(c, d), glm::max(c, d), 1.2f * brick));
            z -= length + (random_unit(key, 6) < 0.25f ? 1.8f : 0.0f);
        }
    }
    return all;
}

TriangleMesh lamp_post() {
    TriangleMesh mesh = lathe_mesh({{0.16f, 0.0f},
                                    {0.16f, 0.12f},
                                    {0.11f, 0.2f},
                                    {0.09f, 0.55f},
                                    {0.11f, 0.62f},
                                    {0.055f, 0.72f},
                                    {0.045f, 3.1f},
                                    {0.075f, 3.16f},
                                    {0.045f, 3.24f},
                                    {0.035f, 3.5f},
                                    {0.13f, 3.58f},
                                    {0.0f, 3.6f}},
                                   20);
    // The lantern's roof and its corner bars.
    append_mesh(mesh, lathe_mesh({{0.0f, 4.2f},
                                  {0.27f, 4.2f},
                                  {0.25f, 4.24f},
                                  {0.1f, 4.4f},
                                  {0.04f, 4.44f},
                                  {0.05f, 4.5f},
                                  {0.0f, 4.56f}},
                                 6));
    for (int i = 0; i < 6; ++i) {
        const float angle = glm::two_pi<float>() * static_cast<float>(i) / 6;
        const glm::vec3 out(std::cos(angle), 0, std::sin(angle));
        append_mesh(mesh,
                    tube_mesh({0.125f * out + glm::vec3(0, 3.58f, 0), 0.23f * out + glm::vec3(0, 4.2f, 0)},
                              0.011f, 6));
    }
    return mesh;
}

// A person in a coat and hat, 1.8 m tall.
TriangleMesh person() {
    TriangleMesh mesh;
    const glm::mat4 flat = glm::scale(glm::mat4(1.0f), glm::vec3(1, 1, 0.72f));
    const auto smooth = [](const std::vector<glm::vec2>& points) {
        return lathe_mesh(smooth_profile(points, 5), 28);
    };
    append_mesh(mesh,
                smooth({{0.0f, 0.36f},
                        {0.24f, 0.34f},
                        {0.22f, 0.7f},
                        {0.165f, 1.05f},
                        {0.2f, 1.28f},
                        {0.215f, 1.4f},
                        {0.13f, 1.5f},
                        {0.06f, 1.53f},
                        {0.06f, 1.58f}}),
                flat);
    append_mesh(mesh, smooth({{0.05f, 1.55f}, {0.085f, 1.6f}, {0.1f, 1.68f}, {0.085f, 1.76f}, {0.0f, 1.8f}}));
    append_mesh(mesh, lathe_mesh({{0.0f, 1.715f},
                                  {0.19f, 1.7f},
                                  {0.19f, 1.712f},
                                  {0.11f, 1.73f},
                                  {0.1f, 1.83f},
                                  {0.05f, 1.84f},
                                  {0.0f, 1.82f}},
                                 28));
    for (float side : {-1.0f, 1.0f}) {
        append_mesh(mesh, tube_mesh({{side * 0.085f, 0.0f, 0.02f}, {side * 0.08f, 0.4f, 0}}, 0.06f, 12));
        append_mesh(
            mesh,
            tube_mesh({{side * 0.2f, 1.4f, 0}, {side * 0.265f, 1.15f, 0.02f}, {side * 0.24f, 0.85f, 0.06f}},
                      0.055f, 12));
        append_mesh(mesh, sphere_mesh(8), placed({side * 0.085f, 0.04f, 0.06f}, {0.055f, 0.045f, 0.13f}));
    }
    return mesh;
}

TriangleMesh umbrella() {
    TriangleMesh mesh =
        lathe_mesh(smooth_profile({{0.0f, 2.32f}, {0.2f, 2.28f}, {0.42f, 2.14f}, {0.55f, 1.96f}}, 5), 8, 5);
    append_mesh(mesh, tube_mesh({{0, 1.15f, 0}, {0, 2.4f, 0}}, 0.012f, 8));
    return mesh;
}

// Trunk, branches and twigs; `ends`, if wanted, receives the twigs' ends.
TriangleMesh tree(std::uint64_t seed, std::vector<glm::vec3>* ends) {
    TriangleMesh mesh;
    const auto tapered = [&](const std::vector<glm::vec3>& path, float foot, float top) {
        SweptProfile sweep;
        sweep.path = path;
        sweep.outline = circle_outline(1, 10);
        sweep.crease_degrees = 100;
        sweep.up = glm::vec3(0.3f, 0.1f, 1);
        for (std::size_t i = 0; i < path.size(); ++i)
            sweep.scales.push_back(
                glm::mix(foot, top, static_cast<float>(i) / static_cast<float>(path.size() - 1)));
        append_mesh(mesh, swept_mesh(sweep));
    };
    const glm::vec3 crown = kTree + glm::vec3(-0.1f, 2.2f, 0.1f);
    tapered({kTree, kTree + glm::vec3(0.05f, 0.9f, 0), crown}, 0.15f, 0.1f);
    for (std::uint32_t branch = 0; branch < 9; ++branch) {
        const std::uint64_t key = mix64(seed ^ 0x54726565ull) + 100 * static_cast<std::uint64_t>(branch);
        const float angle = 2.4f * static_cast<float>(branch) + 0.5f * random_unit(key, 0);
        const float reach = 0.8f + 0.7f * random_unit(key, 1);
        const glm::vec3 out(reach * std::cos(angle), 0.7f + 1.1f * random_unit(key, 2),
                            reach * std::sin(angle));
        const glm::vec3 end = crown + out;
        tapered({crown - glm::vec3(0, 0.1f, 0), crown + 0.5f * out + glm::vec3(0, 0.15f, 0), end}, 0.07f,
                0.025f);
        for (std::uint32_t twig = 0; twig < 9; ++twig) {
            const float along = 0.35f + 0.65f * random_unit(key, 10 + 4 * twig);
            const glm::vec3 from = crown + along * out + glm::vec3(0, 0.1f * (1 - along), 0);
            const glm::vec3 reach_twig =
                glm::vec3(random_unit(key, 11 + 4 * twig), random_unit(key, 12 + 4 * twig),
                          random_unit(key, 13 + 4 * twig)) -
                glm::vec3(0.5f, 0.42f, 0.5f);
            const glm::vec3 to = from + 1.1f * reach_twig;
            tapered({from, to}, 0.016f, 0.006f);
            if (ends == nullptr) continue;
            ends->push_back(to);
            ends->push_back(0.5f * (from + to));
        }
    }
    return mesh;
}

}  // namespace

std::vector<glm::vec4> street_lamps() {
    std::vector<glm::vec4> lamps;
    for (int i = 0; i < kStreetLamps; ++i) lamps.emplace_back(lamp_foot(i) + glm::vec3(0, kFlame, 0), 7.0f);
    return lamps;
}

std::vector<SceneDraw> street_draws(std::uint64_t seed) {
    std::vector<MeshInstance> posts;
    std::vector<MeshInstance> flames;
    for (int i = 0; i < kStreetLamps; ++i) {
        posts.push_back({placed(lamp_foot(i), glm::vec3(1)), painted(kIron)});
        flames.push_back({placed(lamp_foot(i) + glm::vec3(0, kFlame, 0), {0.055f, 0.085f, 0.055f}),
                          painted({5.0f, 3.9f, 2.5f}, kShining)});
    }
    const glm::vec3 near(-0.75f, 0, 0.3f);
    std::vector<SceneDraw> draws;
    draws.push_back(matte_draw("houses", box_mesh(), houses(seed)));
    draws.push_back(matte_draw("lamp posts", lamp_post(), posts));
    draws.push_back(matte_draw("flames", sphere_mesh(12), flames));
    draws.push_back(
        matte_draw("people", person(),
                   {{placed(near, glm::vec3(0.95f), 2.9f), painted({0.42f, 0.05f, 0.04f})},
                    {placed({1.5f, 0, -13}, glm::vec3(1.02f), 0.4f), painted({0.06f, 0.055f, 0.05f})},
                    {placed({-1.9f, 0, -24}, glm::vec3(1), 1.0f), painted({0.06f, 0.055f, 0.05f})}}));
    draws.push_back(
        matte_draw("umbrella", umbrella(),
                   {{placed(near + glm::vec3(0.2f, -0.05f, 0.05f), glm::vec3(0.95f), 0.3f, -0.08f),
                     painted({0.05f, 0.05f, 0.06f})}}));
    draws.push_back(
        matte_draw("tree", tree(seed, nullptr), {{glm::mat4(1.0f), painted({0.09f, 0.065f, 0.045f})}}));
    for (SceneDraw& draw : draws) {
        draw.shading =
            std::string(shader_source("street_light")) + std::string(shader_source("street_shading"));
        draw.parameters = street_lamps();
    }
    return draws;
}

TriangleMesh lantern_panes() {
    // Six flat panes, wider at the top, glass on both faces.
    TriangleMesh mesh = lathe_mesh({{0.12f, -0.31f}, {0.225f, 0.295f}}, 6, 5);
    append_mesh(mesh, lathe_mesh({{0.114f, -0.31f}, {0.219f, 0.295f}}, 6, 5));
    return mesh;
}

std::vector<glm::vec3> twig_ends(std::uint64_t seed) {
    std::vector<glm::vec3> ends;
    tree(seed, &ends);
    return ends;
}

}  // namespace ropsim
