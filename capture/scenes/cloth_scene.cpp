// Scene: a colourful blanket over a rail, its pleats lying over one another; triangles in random order.
#include "base/error.h"
#include "base/parallel.h"
#include "base/random.h"
#include "capture/geometry/shuffled_order.h"
#include "capture/scene_list.h"
#include "capture/scenery/scene_parts.h"
#include "capture/shader_sources.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

constexpr int kColumns = 720;   // of quads, across the blanket
constexpr int kRows = 200;      // along it, over the rail
constexpr float kWidth = 6.4f;  // of the blanket laid flat, metres
constexpr float kLength = 2.5f;
constexpr float kRail = 1.3f;  // height of the rail's axis, metres
constexpr float kRailRadius = 0.03f;
constexpr float kAlpha = 0.4f;  // Laine and Karras 2011, Fig. 10
constexpr double kMaxCopies = 4000;
constexpr int kTextureSide = 512;
constexpr float kTau = glm::two_pi<float>();
constexpr glm::vec3 kCentre{0.0f, 0.8f, 0.0f};

// A few seeded waves: smooth, about 1 in size.
class Waves {
 public:
    explicit Waves(std::uint64_t seed) : key_(mix64(seed ^ (0x436C6F74ull << 32))) {}
    float operator()(float x, float y, std::uint32_t which) const {
        float sum = 0;
        for (std::uint32_t i = 0; i < 4; ++i) {
            const std::uint32_t draw = 16 * which + 4 * i;
            const float angle = kTau * random_unit(key_, draw);
            const float number = 1.5f + 2.5f * random_unit(key_, draw + 1);
            sum += 0.5f * std::sin(number * (x * std::cos(angle) + y * std::sin(angle)) +
                                   kTau * random_unit(key_, draw + 2));
        }
        return sum;
    }

 private:
    std::uint64_t key_;
};

struct ClothVertex {
    glm::vec3 position;
    float u;
    glm::vec3 normal;
    float v;
};
static_assert(sizeof(ClothVertex) == 8 * sizeof(float));

// One row of the sheet, `v` from 0 (its back edge) to 1 (its front edge). Across, it meanders: the direction
// of a thread swings by more than a right angle, so that pleats overlap.
void lay_row(const Waves& waves, float v, ClothVertex* row) {
    const float along = (v - 0.46f) * kLength;
    float x = 0;
    float deep = 0;
    for (int i = 0; i <= kColumns; ++i) {
        const float u = static_cast<float>(i) / kColumns;
        const float wide = kWidth * u;
        // The blanket hangs askew.
        const float d = along + 0.22f * (u - 0.5f);
        const float hang = std::fabs(d);
        const float loose = glm::smoothstep(0.0f, 0.9f, hang);
        const float phase =
            kTau * 10.3f * u + 0.8f * waves(wide, 0.8f * d, 0) + (d > 0 ? 0.5f : -0.6f) * hang;
        const float swing = 2.08f - 0.1f * loose + 0.13f * waves(1.3f * wide, 1.1f * d, 1);
        const float heading = swing * std::sin(phase);
        const float step = kWidth / kColumns;
        x += step * std::cos(heading);
        deep += step * std::sin(heading);
        const float bend = glm::half_pi<float>() * kRailRadius;
        glm::vec3 p(x, kRail, 0);
        glm::vec3 out(0, 0, d < 0 ? -1 : 1);
        if (hang < bend) {
            out = {0, std::cos(d / kRailRadius), std::sin(d / kRailRadius)};
        } else {
            p.y -= hang - bend;
        }
        // Pressed flat on the rail, free below.
        const float rise = 0.012f + 0.012f * std::sin(phase) + loose * (0.9f * deep + 0.16f);
        p += out * (kRailRadius + std::max(rise, 0.004f + 0.01f * std::sin(phase)));
        p.z += 0.05f * loose * waves(0.9f * wide, 1.4f * d, 2);
        row[i].position = p;
        row[i].u = 2.0f * u * kWidth / kLength;
        row[i].v = 2.0f * v;
    }
    // Gathered about the middle of the rail.
    const float middle = 0.5f * (row[0].position.x + row[kColumns].position.x);
    for (int i = 0; i <= kColumns; ++i) row[i].position.x -= middle;
}

std::vector<ClothVertex> lay_cloth(std::uint64_t seed) {
    constexpr int kRow = kColumns + 1;
    std::vector<ClothVertex> vertices(static_cast<std::size_t>(kRow) * (kRows + 1));
    const Waves waves(seed);
    parallel_for(default_threads(), kRows + 1, [&](int j) {
        lay_row(waves, static_cast<float>(j) / kRows, &vertices[static_cast<std::size_t>(j * kRow)]);
    });
    for (int j = 0; j <= kRows; ++j) {
        for (int i = 0; i <= kColumns; ++i) {
            const auto at = [&](int column, int line) {
                const int c = std::clamp(column, 0, kColumns);
                const int l = std::clamp(line, 0, kRows);
                return vertices[static_cast<std::size_t>(l * kRow + c)].position;
            };
            vertices[static_cast<std::size_t>(j * kRow + i)].normal =
                glm::normalize(glm::cross(at(i, j + 1) - at(i, j - 1), at(i + 1, j) - at(i - 1, j)));
        }
    }
    return vertices;
}

// Stripes of many colours with rows of lozenges and crosses, as woven; linear.
SceneTexture woven_pattern(std::uint64_t seed) {
    constexpr glm::vec3 kColors[] = {{0.75f, 0.04f, 0.05f}, {0.9f, 0.42f, 0.03f},  {0.03f, 0.2f, 0.5f},
                                     {0.85f, 0.75f, 0.5f},  {0.02f, 0.33f, 0.26f}, {0.55f, 0.04f, 0.3f},
                                     {0.95f, 0.68f, 0.06f}, {0.08f, 0.45f, 0.6f}};
    constexpr int kBands = 16;
    SceneTexture texture;
    texture.width = texture.height = kTextureSide;
    texture.channels = 4;
    texture.values.reserve(std::size_t{4} * kTextureSide * kTextureSide);
    for (int y = 0; y < kTextureSide; ++y) {
        for (int x = 0; x < kTextureSide; ++x) {
            const float across = static_cast<float>(x) / kTextureSide;
            const float along = kBands * static_cast<float>(y) / kTextureSide;
            const int band = static_cast<int>(along);
            const float in_band = along - static_cast<float>(band);
            glm::vec3 color = kColors[static_cast<std::size_t>(band * 5 % 8)];
            const glm::vec3 other = kColors[static_cast<std::size_t>((band * 5 + 3) % 8)];
            const float cell = 16 * across + 0.5f * static_cast<float>(band % 2);
            const float in_cell = std::fabs(cell - std::floor(cell) - 0.5f) + std::fabs(in_band - 0.5f);
            if (band % 2 == 0) {
                if (in_cell < 0.42f) color = other;
                if (in_cell < 0.18f) color = {0.9f, 0.85f, 0.7f};
            } else if (std::fabs(in_band - 0.5f) < 0.12f) {
                color = other;
            }
            if (in_band < 0.08f || in_band > 0.92f) color = {0.02f, 0.02f, 0.03f};
            const std::uint64_t key = mix64(seed ^ (0x57656176ull << 32));
            const float thread =
                0.8f + 0.2f * random_unit(key, static_cast<std::uint32_t>(y * kTextureSide + x));
            color *= thread;
            texture.values.insert(texture.values.end(), {color.r, color.g, color.b, 1.0f});
        }
    }
    return texture;
}

class ClothScene final : public SceneSource {
 public:
    ClothScene(double aspect, std::uint64_t seed) : aspect_(aspect), seed_(seed), cloth_(lay_cloth(seed)) {
        shrinks = true;
    }

    Scene build(const SceneScale& scale) const override {
        if (scale.count > kMaxCopies) {
            throw UserError("--fragments",
                            fmt::format("{:.0f} blankets would be needed, more than {:.0f}; ask for fewer "
                                        "fragments or use a larger --size",
                                        scale.count, kMaxCopies));
        }
        const int count = std::max(static_cast<int>(std::lround(scale.count)), 1);
        Scene scene;
        scene.description = fmt::format("{} blanket{} of {} triangles in random order, alpha {}", count,
                                        count == 1 ? "" : "s", 2 * kColumns * kRows, kAlpha);
        scene.camera = look_at({1.3f, 1.25f, 3.6f}, {0.02f, 0.78f, 0}, 30, aspect_, 1.0, 1.0f, 20);
        scene.light = light_camera(light_direction(), kCentre, 1.6f);
        scene.background = {0.1f, 0.12f, 0.14f};
        scene.opaque = room();
        scene.transparent.push_back(cloth_draw(count, static_cast<float>(scale.size)));
        return scene;
    }

 private:
    static std::vector<SceneDraw> room() {
        const glm::vec4 wood(0.36f, 0.2f, 0.1f, 0.0f);
        std::vector<MeshInstance> parts = {
            {placed({0, -0.05f, 0}, {9, 0.05f, 5}), {0.2f, 0.17f, 0.14f, 0.0f}},
            {placed({0, 2.0f, -2.2f}, {9, 2.1f, 0.05f}), {0.1f, 0.12f, 0.14f, 0.0f}},
            {placed({0, kRail, 0}, {1.15f, 0.024f, 0.024f}), wood}};
        for (const float side : {-1.0f, 1.0f}) {
            parts.push_back({placed({1.13f * side, 0.5f * kRail, 0}, {0.026f, 0.5f * kRail, 0.026f}), wood});
            parts.push_back({placed({1.13f * side, 0.03f, 0}, {0.03f, 0.03f, 0.28f}), wood});
        }
        return {matte_draw("room", box_mesh(), parts)};
    }

    SceneDraw cloth_draw(int count, float size) const {
        constexpr std::uint32_t kRow = kColumns + 1;
        SceneDraw draw;
        draw.state.name = "cloth";
        draw.vertex = shader_source("blanket_vertex");
        draw.shading = shader_source("blanket_shading");
        draw.primitives = 2 * kColumns * kRows;
        draw.instances = static_cast<std::uint32_t>(count);
        SceneBuffer vertices{1, {}};
        vertices.values.reserve(8 * cloth_.size());
        for (const ClothVertex& p : cloth_)
            vertices.values.insert(vertices.values.end(), {p.position.x, p.position.y, p.position.z, p.u,
                                                           p.normal.x, p.normal.y, p.normal.z, p.v});
        SceneBuffer copies{2, {}};
        for (int i = 0; i < count; ++i) {
            // Further blankets lie a little beside the first.
            const float beside = 0.02f * static_cast<float>(i);
            copies.values.insert(copies.values.end(), {beside, -0.6f * beside, 0.4f * beside, size});
        }
        draw.indices.reserve(std::size_t{3} * draw.primitives);
        for (const std::uint32_t triangle : shuffled_order(draw.primitives, seed_)) {
            const std::uint32_t quad = triangle / 2;
            const std::uint32_t v = quad / kColumns * kRow + quad % kColumns;
            if (triangle % 2 == 0) {
                draw.indices.insert(draw.indices.end(), {v, v + kRow, v + 1});
            } else {
                draw.indices.insert(draw.indices.end(), {v + 1, v + kRow, v + kRow + 1});
            }
        }
        draw.buffers = {std::move(vertices), std::move(copies)};
        draw.textures.push_back(woven_pattern(seed_));
        draw.parameters = {glm::vec4(light_direction(), 0), glm::vec4(kCentre, kAlpha)};
        return draw;
    }

    double aspect_;
    std::uint64_t seed_;
    std::vector<ClothVertex> cloth_;
};

}  // namespace

std::unique_ptr<SceneSource> make_cloth_scene(double aspect, std::uint64_t seed) {
    return std::make_unique<ClothScene>(aspect, seed);
}

}  // namespace ropsim
