// Models of the windy hill.
#include "capture/scenes/windy_figure.h"

#include "base/random.h"
#include "capture/scenery/scene_parts.h"
#include "capture/scenes/hair_head.h"
#include "capture/shader_sources.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

constexpr glm::vec3 kTreeFoot{-19.5f, -17.0f, -13.0f};

// Over-under pattern of threads, four by four crossings: gaps at the corners.
SceneTexture weave_texture() {
    constexpr int kSide = 64;
    SceneTexture texture;
    texture.width = texture.height = kSide;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            const float across = std::fabs(static_cast<float>(x % 16) - 7.5f) / 8;
            const float along = std::fabs(static_cast<float>(y % 16) - 7.5f) / 8;
            const float threads =
                std::max(glm::smoothstep(0.85f, 0.45f, across), glm::smoothstep(0.85f, 0.45f, along));
            const bool over = (x / 16 + y / 16) % 2 == 0;
            texture.values.push_back(0.12f + threads * (over ? 0.5f : 0.4f));
        }
    return texture;
}

SceneDraw rocks() {
    TriangleMesh rock = sphere_mesh(20);
    for (std::size_t i = 0; i < rock.positions.size(); ++i) {
        const glm::vec3 p = rock.positions[i];
        rock.positions[i] *= 1 + 0.13f * std::sin(3.7f * p.x + 2 * p.y) * std::cos(4.1f * p.z - p.y) +
                             0.05f * std::sin(9 * p.x) * std::sin(11 * p.y + 8 * p.z);
    }
    std::vector<MeshInstance> places;
    const auto add = [&](float x, float z, glm::vec3 size, float yaw) {
        places.push_back(
            {placed({x, hill_height({x, z}) + 0.3f * size.y, z}, size, yaw), {0.34f, 0.33f, 0.31f, 0}});
    };
    add(-6.5f, 3.5f, {2.8f, 3.9f, 2.3f}, 0.4f);
    add(-9.6f, 2.4f, {1.9f, 2.7f, 1.8f}, 1.9f);
    add(13.5f, -9.0f, {4.4f, 4.6f, 3.4f}, 2.6f);
    add(18.0f, -11.0f, {3.0f, 3.2f, 2.7f}, 1.1f);
    return matte_draw("rocks", rock, places);
}

}  // namespace

float hill_height(glm::vec2 at) {
    const float bumps = 0.35f * std::sin(0.31f * at.x + 0.5f) * std::cos(0.27f * at.y) +
                        0.12f * std::sin(1.1f * at.x - 0.7f * at.y);
    const glm::vec2 away = at - glm::vec2(1.0f, -2.0f);
    return kFeet - 0.3f - glm::dot(away, away) / 260 + bumps;
}

BlobBody figure_dress() {
    std::vector<Blob> blobs = {
        limb({0, -3.6f, -0.2f}, {0, -5.5f, -0.2f}, 0.93f, 0.78f, 0.5f),
        limb({0, -6.3f, -0.2f}, {0.5f, kFeet + 1.0f, -0.5f}, 1.0f, 2.1f, 0.5f),
    };
    // Folds of the skirt, drawn out by the wind.
    for (int i = 0; i < 9; ++i) {
        const float angle = glm::two_pi<float>() * static_cast<float>(i) / 9;
        const glm::vec3 out(std::cos(angle), 0, std::sin(angle));
        blobs.push_back(limb(glm::vec3(0, -7.5f, -0.2f) + 0.85f * out,
                             glm::vec3(0, kFeet + 0.6f, -0.3f) + 2.2f * out + 0.8f * kWind, 0.2f, 0.42f,
                             0.4f));
    }
    for (float side : {-1.0f, 1.0f}) {
        blobs.push_back(limb({side * 1.7f, -4.6f, -0.34f}, {side * 1.75f, -7.2f, 0.05f}, 0.31f, 0.2f, 0.15f));
    }
    return BlobBody(std::move(blobs));
}

BlobBody tree_wood() {
    const glm::vec3 fork = kTreeFoot + glm::vec3(0.8f, 7.0f, 0);
    std::vector<Blob> blobs = {limb(kTreeFoot - glm::vec3(0, 1.5f, 0), fork, 1.0f, 0.55f, 0.4f)};
    for (const glm::vec4& crown : tree_crowns())
        blobs.push_back(limb(fork, glm::vec3(crown) - glm::vec3(0, 0.3f * crown.w, 0), 0.42f, 0.1f, 0.3f));
    return BlobBody(std::move(blobs));
}

std::vector<glm::vec4> tree_crowns() {
    const glm::vec3 top = kTreeFoot + glm::vec3(1.5f, 11.0f, 0);
    return {glm::vec4(top, 3.0f), glm::vec4(top + glm::vec3(3.2f, -1.0f, 0.5f), 2.6f),
            glm::vec4(top + glm::vec3(-2.6f, -1.4f, 0.6f), 2.3f),
            glm::vec4(top + glm::vec3(1.2f, 2.2f, -0.4f), 2.5f),
            glm::vec4(top + glm::vec3(4.8f, 0.4f, -0.6f), 1.9f)};
}

std::vector<SceneDraw> hill_models() {
    std::vector<SceneDraw> draws = bust_draws();
    const glm::vec4 cloth(0.06f, 0.1f, 0.13f, 0.0f);
    draws.push_back(matte_draw("skirt",
                               figure_dress().mesh({-3.6f, kFeet - 1, -3.8f}, {4.2f, -3, 3.4f}, 0.12f),
                               {{glm::mat4(1.0f), cloth}}));
    std::vector<MeshInstance> hands;
    for (float side : {-1.0f, 1.0f})
        hands.push_back(
            {placed({side * 1.76f, -7.65f, 0.12f}, {0.17f, 0.45f, 0.24f}), {0.68f, 0.45f, 0.34f, 0}});
    draws.push_back(matte_draw("hands", sphere_mesh(12), hands));
    std::vector<Blob> wrap;
    for (int i = 0; i < 20; ++i) {
        const auto around = [](int k) {
            const float angle = glm::two_pi<float>() * static_cast<float>(k) / 20;
            return glm::vec3(0.56f * std::sin(angle), -1.5f - 0.12f * std::cos(angle),
                             -0.25f + 0.56f * std::cos(angle));
        };
        wrap.push_back(limb(around(i), around(i + 1), 0.19f, 0.19f, 0.03f));
    }
    draws.push_back(matte_draw("scarf's turn around the neck",
                               BlobBody(std::move(wrap)).mesh({-1, -2.1f, -1.3f}, {1, -1, 0.8f}, 0.06f),
                               {{glm::mat4(1.0f), {0.62f, 0.09f, 0.07f, 0}}}));
    const BlobBody wood = tree_wood();
    draws.push_back(
        matte_draw("tree", wood.mesh(kTreeFoot - glm::vec3(6, 3, 4), kTreeFoot + glm::vec3(10, 16, 4), 0.25f),
                   {{glm::mat4(1.0f), {0.16f, 0.11f, 0.075f, 0}}}));
    draws.push_back(rocks());
    return draws;
}

Scarf scarf_tail(int tail) {
    Scarf scarf;
    scarf.across = 17;
    scarf.rows = 150;
    const float phase = tail == 0 ? 0.0f : 2.4f;
    const float length = tail == 0 ? 15.5f : 10.0f;
    const glm::vec3 sideways = glm::normalize(glm::cross(kWind, glm::vec3(0, 1, 0)));
    const float drop = tail == 0 ? 12.0f : 6.0f;
    const glm::vec3 start = tail == 0 ? glm::vec3(0.2f, -1.6f, 0.35f) : glm::vec3(0.3f, -1.5f, -0.6f);
    for (std::uint32_t row = 0; row < scarf.rows; ++row) {
        const float s = static_cast<float>(row) / static_cast<float>(scarf.rows - 1);
        const float swing = glm::smoothstep(0.0f, 0.4f, s);
        const glm::vec3 middle =
            start + length * s * kWind +
            glm::vec3(0,
                      -drop * std::pow(std::sin(glm::half_pi<float>() * s), 1.8f) +
                          0.5f * swing * std::sin(9 * s + phase),
                      0) +
            (0.9f * swing * std::sin(11 * s + phase) + (tail == 0 ? 2.5f : 0.3f) * s) * sideways;
        const float half = 0.3f + 1.15f * glm::smoothstep(0.0f, 0.25f, s);
        // The sheet twists about its length and flutters across.
        const float twist = 0.75f * std::sin(5 * s + phase) * swing;
        for (std::uint32_t column = 0; column < scarf.across; ++column) {
            const float v = 2 * static_cast<float>(column) / static_cast<float>(scarf.across - 1) - 1;
            const float flutter = 0.28f * swing * std::sin(17 * s + 2.2f * v + phase) * (0.4f + std::fabs(v));
            scarf.points.push_back(
                middle + half * v * (std::cos(twist) * glm::vec3(0, 1, 0) + std::sin(twist) * sideways) +
                flutter * (std::cos(twist) * sideways - std::sin(twist) * glm::vec3(0, 1, 0)));
        }
    }
    return scarf;
}

SceneDraw scarf_draw(const std::string& name, const Scarf& scarf, const LightVolume& shadows) {
    SceneDraw draw;
    draw.state.name = name;
    draw.vertex = shader_source("scarf_vertex");
    draw.shading = shader_source("scarf_shading");
    draw.textures.push_back(weave_texture());
    SceneBuffer buffer{1, {}};
    const auto at = [&](std::uint32_t row, std::uint32_t column) {
        return scarf
            .points[std::min(row, scarf.rows - 1) * scarf.across + std::min(column, scarf.across - 1)];
    };
    for (std::uint32_t row = 0; row < scarf.rows; ++row) {
        for (std::uint32_t column = 0; column < scarf.across; ++column) {
            const glm::vec3 p = at(row, column);
            const glm::vec3 along = at(row + 1, column) - at(row > 0 ? row - 1 : 0, column);
            const glm::vec3 across = at(row, column + 1) - at(row, column > 0 ? column - 1 : 0);
            const glm::vec3 n = glm::normalize(glm::cross(across, along));
            const float light = shadows.transmittance(p, 1.0f);
            buffer.values.insert(buffer.values.end(),
                                 {p.x, p.y, p.z, light, n.x, n.y, n.z, 0, static_cast<float>(column) * 0.3f,
                                  static_cast<float>(row) * 0.2f,
                                  static_cast<float>(row) / static_cast<float>(scarf.rows - 1), 0});
            if (row + 1 == scarf.rows || column + 1 == scarf.across) continue;
            const std::uint32_t a = row * scarf.across + column;
            draw.indices.insert(draw.indices.end(),
                                {a, a + 1, a + scarf.across, a + 1, a + scarf.across + 1, a + scarf.across});
        }
    }
    draw.primitives = static_cast<std::uint32_t>(draw.indices.size() / 3);
    draw.buffers = {std::move(buffer)};
    draw.parameters = {glm::vec4(light_direction(), 0), glm::vec4(0.75f, 0.1f, 0.08f, 0),
                       glm::vec4(0.9f, 0.72f, 0.4f, 0)};
    return draw;
}

}  // namespace ropsim
