// Paints blades, flowers and leaves into an atlas and packs cards.
#include "capture/scenes/windy_cards.h"

#include "base/random.h"
#include "capture/scenery/scene_parts.h"
#include "capture/shader_sources.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

constexpr int kColumnWidth = 128;
constexpr int kHeight = 256;
constexpr int kMargin = 6;  // pixels on either side of a picture that stay empty

// A picture of the atlas, painted back to front.
class Picture {
 public:
    Picture(SceneTexture& atlas, int column) : atlas_(atlas), left_(column * kColumnWidth) {}

    // (x, y) in pixels of the picture, y down; `cover` in [0, 1].
    void dab(int x, int y, const glm::vec3& color, float cover) {
        if (x < kMargin || x >= kColumnWidth - kMargin || y < kMargin || y >= kHeight || cover <= 0) return;
        float* texel = &atlas_.values[4 * static_cast<std::size_t>(y * atlas_.width + left_ + x)];
        const float under = texel[3] * (1 - cover);
        const float alpha = cover + under;
        for (int c = 0; c < 3; ++c) texel[c] = (color[c] * cover + texel[c] * under) / alpha;
        texel[3] = alpha;
    }

    // An ellipse with soft edges, turned by `angle`.
    void spot(glm::vec2 centre, glm::vec2 radii, float angle, const glm::vec3& color) {
        const int reach = static_cast<int>(std::max(radii.x, radii.y)) + 2;
        const float c = std::cos(angle);
        const float s = std::sin(angle);
        const glm::ivec2 middle(centre);
        for (int y = middle.y - reach; y <= middle.y + reach; ++y)
            for (int x = middle.x - reach; x <= middle.x + reach; ++x) {
                const glm::vec2 d = glm::vec2(x, y) - centre;
                const glm::vec2 turned = glm::vec2(c * d.x + s * d.y, c * d.y - s * d.x) / radii;
                const float edge = (1 - glm::length(turned)) * std::min(radii.x, radii.y);
                dab(x, y, (0.85f + 0.15f * turned.x) * color, glm::clamp(edge + 0.5f, 0.0f, 1.0f));
            }
    }

    // A blade from the foot at x = `foot` to `tip`, bowed and tapering; returns nothing but paint.
    void blade(float foot, glm::vec2 tip, float half_width, const glm::vec3& color) {
        const int top = static_cast<int>(tip.y);
        for (int y = top; y < kHeight; ++y) {
            const float up = static_cast<float>(kHeight - y) / static_cast<float>(kHeight - top);
            const float middle = glm::mix(foot, tip.x, up * up);
            const float half = half_width * (1 - up * up) + 0.3f;
            const int first = static_cast<int>(std::floor(middle - half - 1));
            for (int x = first; x <= first + static_cast<int>(2 * half) + 3; ++x) {
                const float away = static_cast<float>(x) - middle;
                const float shade = (0.55f + 0.5f * up) * (away < 0 ? 1.0f : 0.82f);
                dab(x, y, shade * color, glm::clamp(half - std::fabs(away) + 0.5f, 0.0f, 1.0f));
            }
        }
    }

 private:
    SceneTexture& atlas_;
    int left_;
};

glm::vec3 grass_color(std::uint64_t key) {
    const glm::vec3 green =
        glm::mix(glm::vec3(0.12f, 0.26f, 0.05f), glm::vec3(0.3f, 0.42f, 0.1f), random_unit(key, 20));
    return glm::mix(green, glm::vec3(0.5f, 0.45f, 0.2f), 0.6f * random_unit(key, 21) * random_unit(key, 22));
}

void paint_grass(SceneTexture& atlas, int column, std::uint64_t seed, int blades, bool flowers) {
    Picture picture(atlas, column);
    for (int i = 0; i < blades; ++i) {
        const std::uint64_t key =
            mix64(seed ^ (static_cast<std::uint64_t>(column) << 40) ^ static_cast<std::uint64_t>(i));
        const auto unit = [&](std::uint32_t draw) { return random_unit(key, draw); };
        const float foot = 30.0f + 68.0f * unit(0);
        const glm::vec2 tip(glm::clamp(foot + 70.0f * (unit(1) - 0.5f), 14.0f, 113.0f),
                            14.0f + 150.0f * unit(2) * unit(2));
        picture.blade(foot, tip, flowers ? 2.0f : 2.6f + 1.8f * unit(3), grass_color(key));
        if (!flowers || i % 3 != 0) continue;
        const glm::vec3 petals = i % 2 == 0 ? glm::vec3(0.85f, 0.2f, 0.12f) : glm::vec3(0.9f, 0.88f, 0.8f);
        for (int petal = 0; petal < 6; ++petal) {
            const float angle = glm::two_pi<float>() * (static_cast<float>(petal) / 6 + unit(4));
            picture.spot(tip + 7.0f * glm::vec2(std::cos(angle), std::sin(angle)), {7, 4.5f}, angle, petals);
        }
        picture.spot(tip, {4, 4}, 0, {0.8f, 0.55f, 0.08f});
    }
}

void paint_leaves(SceneTexture& atlas, int column, std::uint64_t seed) {
    Picture picture(atlas, column);
    for (int i = 0; i < 60; ++i) {
        const std::uint64_t key = mix64(seed ^ 0x4C656166ull ^ static_cast<std::uint64_t>(i));
        const auto unit = [&](std::uint32_t draw) { return random_unit(key, draw); };
        const glm::vec2 centre(22.0f + 84.0f * unit(0), 24.0f + 208.0f * unit(1));
        const glm::vec3 color = glm::mix(glm::vec3(0.1f, 0.2f, 0.05f), glm::vec3(0.3f, 0.4f, 0.1f), unit(2));
        picture.spot(centre, {13, 6}, glm::two_pi<float>() * unit(3), color);
    }
}

}  // namespace

SceneTexture plant_atlas(std::uint64_t seed) {
    SceneTexture atlas;
    atlas.width = kCardColumns * kColumnWidth;
    atlas.height = kHeight;
    atlas.channels = 4;
    atlas.repeat = false;
    atlas.values.assign(4 * static_cast<std::size_t>(atlas.width) * static_cast<std::size_t>(atlas.height),
                        0);
    paint_grass(atlas, 0, seed, 16, false);
    paint_grass(atlas, 1, seed, 11, false);
    paint_grass(atlas, 2, seed, 9, true);
    paint_leaves(atlas, 3, seed);
    return atlas;
}

SceneDraw plant_card_draw(const std::string& name, const std::vector<PlantCard>& cards,
                          const SceneTexture& atlas, glm::vec3 wind) {
    constexpr std::uint32_t kVertices = 8;
    SceneDraw draw;
    draw.state.name = name;
    draw.vertex = shader_source("windy_card_vertex");
    draw.shading = shader_source("windy_card_shading");
    draw.primitives = static_cast<std::uint32_t>(6 * cards.size());
    draw.textures.push_back(atlas);
    SceneBuffer buffer{1, {}};
    buffer.values.reserve(12 * cards.size());
    draw.indices.reserve(18 * cards.size());
    for (std::uint32_t i = 0; i < cards.size(); ++i) {
        const PlantCard& c = cards[i];
        buffer.values.insert(buffer.values.end(),
                             {c.base.x, c.base.y, c.base.z, c.width, c.yaw, c.height, c.bend,
                              static_cast<float>(c.column), c.tint.r, c.tint.g, c.tint.b, c.tint.a});
        for (std::uint32_t v = kVertices * i; v < kVertices * i + 6; v += 2)
            draw.indices.insert(draw.indices.end(), {v, v + 1, v + 2, v + 1, v + 3, v + 2});
    }
    draw.buffers = {std::move(buffer)};
    draw.parameters = {glm::vec4(light_direction(), 0), glm::vec4(wind, kCardColumns)};
    return draw;
}

}  // namespace ropsim
