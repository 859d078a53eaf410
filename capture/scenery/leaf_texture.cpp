// Leaves, needles, fronds and grass from bent blades.
#include "capture/scenery/leaf_texture.h"

#include "base/random.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

constexpr int kSide = 256;  // texels
constexpr float kQuarterTurn = glm::half_pi<float>();

// Half width of a blade at `t` from base to tip, relative to its widest.
float outline(float t, float belly) {
    if (t < belly) return std::pow(std::sin(kQuarterTurn * t / belly), 0.7f);
    return std::pow(std::cos(kQuarterTurn * (t - belly) / (1 - belly)), 0.85f);
}

glm::vec2 turned(glm::vec2 v, float angle) {
    return {v.x * std::cos(angle) - v.y * std::sin(angle), v.x * std::sin(angle) + v.y * std::cos(angle)};
}

// Draws from a stream of its own per plant.
struct Chance {
    std::uint64_t key;
    std::uint32_t draw = 0;
    float operator()(float low, float high) { return glm::mix(low, high, random_unit(key, draw++)); }
};

// The plant's colour, a little lighter or yellower.
glm::vec3 varied(glm::vec3 color, Chance& chance) {
    const float yellow = chance(0.0f, 0.35f);
    return color * chance(0.7f, 1.25f) * glm::vec3(1 + yellow, 1 + 0.3f * yellow, 1 - 0.3f * yellow);
}

}  // namespace

LeafPainting::LeafPainting(int side, glm::vec3 ground)
    : side_(side), texels_(static_cast<std::size_t>(side) * static_cast<std::size_t>(side), {ground, 0}) {}

void LeafPainting::paint(const Blade& blade) {
    const float length = glm::length(blade.direction);
    const glm::vec2 along = blade.direction / length;
    const glm::vec2 left(-along.y, along.x);
    const float curve = std::abs(blade.bend) > 1e-3f ? blade.bend / length : 0.0f;
    const float reach = length + blade.width;
    const auto texels = static_cast<float>(side_);
    const auto texel_of = [&](float at) {
        return std::clamp(static_cast<int>(std::floor(at * texels)), 0, side_ - 1);
    };
    for (int row = texel_of(1 - blade.base.y - reach); row <= texel_of(1 - blade.base.y + reach); ++row) {
        for (int column = texel_of(blade.base.x - reach); column <= texel_of(blade.base.x + reach);
             ++column) {
            // The upper edge of the texture is its first row.
            const glm::vec2 at((static_cast<float>(column) + 0.5f) / texels,
                               1 - (static_cast<float>(row) + 0.5f) / texels);
            float s = glm::dot(at - blade.base, along);
            float off = glm::dot(at - blade.base, left);
            if (curve != 0) {
                // The blade is an arc about the point 1 / curve to its left.
                const float radius = 1 / curve;
                const float toward = radius - off;
                const float side = radius > 0 ? 1.0f : -1.0f;
                off = radius - side * std::hypot(toward, s);
                s = std::atan2(s, toward * side) * std::abs(radius);
            }
            if (s < 0 || s > length) continue;
            const float half = 0.5f * blade.width * outline(s / length, blade.belly);
            const float cover = std::clamp(0.5f + (half - std::abs(off)) * texels, 0.0f, 1.0f);
            if (cover == 0) continue;
            const float middle = std::max(0.0f, 1 - 4 * std::abs(off) / std::max(half, 1e-4f));
            const float shade = (1 + blade.vein * middle) * (off > 0 ? 1.0f : 1 - 0.4f * blade.vein);
            glm::vec4& texel = texels_[static_cast<std::size_t>(row * side_ + column)];
            const float below = (1 - cover) * texel.a;
            const glm::vec3 color =
                (cover * shade * blade.color + below * glm::vec3(texel)) / (cover + below);
            texel = glm::vec4(color, cover + below);
        }
    }
}

SceneTexture LeafPainting::texture() const {
    SceneTexture texture;
    texture.width = texture.height = side_;
    texture.channels = 4;
    texture.repeat = false;
    texture.values.reserve(4 * texels_.size());
    for (const glm::vec4& t : texels_) texture.values.insert(texture.values.end(), {t.r, t.g, t.b, t.a});
    return texture;
}

SceneTexture twig_texture(std::uint64_t seed, glm::vec3 color) {
    LeafPainting painting(kSide, color);
    Chance chance{mix64(seed ^ (0x54776967ull << 32))};
    const glm::vec3 bark(0.09f, 0.06f, 0.035f);
    painting.paint({{0.5f, 0.01f}, {0.02f, 0.8f}, 0.02f, 0.2f, 0.1f, 0, bark});
    for (int branch = 0; branch < 8; ++branch) {
        const float side = branch % 2 == 0 ? 1.0f : -1.0f;
        const float height = 0.12f + 0.09f * static_cast<float>(branch);
        const glm::vec2 root(0.5f, height);
        const glm::vec2 twig = turned({0, 0.42f - 0.26f * height}, -side * chance(0.85f, 1.15f));
        painting.paint({root, twig, 0.012f, 0.2f, 0, 0, bark});
        for (int leaf = 0; leaf < 5; ++leaf) {
            const float t = 0.3f + 0.175f * static_cast<float>(leaf);
            const float turn = leaf == 4 ? chance(-0.3f, 0.3f) : (leaf % 2 == 0 ? 0.8f : -0.8f);
            const glm::vec2 direction =
                turned(glm::normalize(twig), turn + chance(-0.2f, 0.2f)) * chance(0.11f, 0.15f);
            painting.paint({root + t * twig, direction, chance(0.06f, 0.085f), 0.42f, chance(-0.4f, 0.4f),
                            0.3f, varied(color, chance)});
        }
    }
    for (int leaf = -2; leaf <= 2; ++leaf) {
        painting.paint({{0.515f, 0.78f},
                        turned({0, chance(0.13f, 0.17f)}, 0.55f * static_cast<float>(leaf)),
                        0.085f,
                        0.42f,
                        chance(-0.3f, 0.3f),
                        0.3f,
                        varied(color, chance)});
    }
    return painting.texture();
}

SceneTexture spray_texture(std::uint64_t seed, glm::vec3 color) {
    LeafPainting painting(kSide, color);
    Chance chance{mix64(seed ^ (0x53707261ull << 32))};
    const glm::vec3 bark(0.1f, 0.065f, 0.04f);
    const auto needles = [&](glm::vec2 root, glm::vec2 twig) {
        painting.paint({root, twig, 0.012f, 0.2f, 0, 0, bark});
        const int count = static_cast<int>(110 * glm::length(twig));
        for (int i = 0; i < count; ++i) {
            const float t = (static_cast<float>(i) + 0.5f) / static_cast<float>(count);
            for (float side : {-1.0f, 1.0f}) {
                const glm::vec2 needle = turned(glm::normalize(twig), side * chance(0.5f, 0.85f)) *
                                         (chance(0.06f, 0.085f) * (1 - 0.35f * t));
                painting.paint(
                    {root + t * twig, needle, 0.012f, 0.3f, -side * 0.3f, 0, varied(color, chance)});
            }
        }
    };
    for (int branch = 0; branch < 10; ++branch) {
        const float side = branch % 2 == 0 ? 1.0f : -1.0f;
        const float height = 0.06f + 0.08f * static_cast<float>(branch);
        needles({0.5f, height}, turned({0, 0.44f - 0.36f * height}, -side * chance(0.75f, 1.0f)));
    }
    needles({0.5f, 0.01f}, {0.0f, 0.91f});
    return painting.texture();
}

SceneTexture fern_texture(std::uint64_t seed, glm::vec3 color) {
    LeafPainting painting(kSide, color);
    Chance chance{mix64(seed ^ (0x4665726Eull << 32))};
    for (int i = 0; i < 30; ++i) {
        const float t = (static_cast<float>(i) + 0.5f) / 30;
        const float length =
            0.42f * std::pow(std::sin(glm::pi<float>() * (0.12f + 0.87f * t)), 0.8f) * (1.05f - 0.45f * t);
        for (float side : {-1.0f, 1.0f}) {
            const glm::vec2 direction =
                turned({0, length * chance(0.92f, 1.05f)}, -side * (1.25f - 0.4f * t));
            painting.paint({{0.5f, 0.05f + 0.9f * t},
                            direction,
                            0.034f * (1.1f - 0.5f * t),
                            0.3f,
                            side * 0.25f,
                            0.3f,
                            varied(color, chance)});
        }
    }
    painting.paint({{0.5f, 0.0f}, {0, 0.97f}, 0.016f, 0.1f, 0, 0, color * glm::vec3(1.3f, 1.1f, 0.8f)});
    return painting.texture();
}

SceneTexture grass_texture(std::uint64_t seed, glm::vec3 color) {
    LeafPainting painting(kSide, color);
    Chance chance{mix64(seed ^ (0x47726173ull << 32))};
    for (int i = 0; i < 34; ++i) {
        const float x = chance(0.22f, 0.78f);
        const float lean = (x - 0.5f) * -1.1f + chance(-0.25f, 0.25f);
        const glm::vec2 direction = turned({0, chance(0.4f, 0.95f)}, 0.4f * lean);
        painting.paint(
            {{x, 0.0f}, direction, chance(0.016f, 0.03f), 0.25f, 0.9f * lean, 0.3f, varied(color, chance)});
    }
    return painting.texture();
}

}  // namespace ropsim
