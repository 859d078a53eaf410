// Scene: fog that thickens down a street at night, under lamps, with a tree and the lamps' glass (McGuire and
// Mara 2017, Figs. 1 right, 14, 15, 21b and 23).
//
// Materials: fog and leaves are partial coverage, nothing passes through the covered part; fog scatters what
// is seen through it (collimation .2), leaves and glass do not. Glass is as in glass_scene.cpp.
#include "base/error.h"
#include "base/random.h"
#include "capture/scene_list.h"
#include "capture/scenery/noise_texture.h"
#include "capture/scenery/transmissive_draw.h"
#include "capture/scenes/fog_street.h"
#include "capture/shader_sources.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

constexpr double kBanks = 620;
constexpr double kLeaves = 9000;
constexpr double kMaxScale = 20'000;
constexpr float kNearest = 1.5f;  // of the fog, metres before the camera
constexpr float kFarthest = 46.0f;
constexpr glm::vec3 kEye(0.75f, 1.5f, 5.6f);

std::uint32_t whole(double count) {
    return static_cast<std::uint32_t>(std::max(std::round(count), 1.0));
}

// In [0, 1): the part of the sequence up to any index is spread evenly.
float spread(std::uint32_t index, double step, float offset) {
    const double value = step * index + static_cast<double>(offset);
    return static_cast<float>(value - std::floor(value));
}

SceneDraw fog_draw(std::uint64_t seed, const SceneScale& scale) {
    const std::uint32_t banks = whole(kBanks * scale.count);
    SceneDraw draw;
    draw.state.name = "fog";
    draw.vertex = shader_source("fog_vertex");
    draw.shading = std::string(shader_source("street_light")) + std::string(shader_source("fog_shading"));
    draw.primitives = 2 * banks;
    draw.parameters = street_lamps();
    draw.textures.push_back(noise_texture(seed));
    SceneBuffer buffer{1, {}};
    buffer.values.reserve(std::size_t{8} * banks);
    const auto size = static_cast<float>(scale.size);
    const std::uint64_t start = mix64(seed ^ 0x466F67ull);
    for (std::uint32_t i = 0; i < banks; ++i) {
        const std::uint64_t key = mix64(start + i);
        // Twice as far, twice as many to the metre: density grows with depth.
        const float u = spread(i, 0.7548776662466927, random_unit(start, 0));
        const float away = std::sqrt(glm::mix(kNearest * kNearest, kFarthest * kFarthest, u));
        const float x =
            (kStreetHalfWidth - 0.4f) * (2 * spread(i, 0.5698402909980532, random_unit(start, 1)) - 1);
        const float radius = (0.8f + 0.9f * random_unit(key, 0)) * (0.75f + 0.02f * away);
        const float y = 0.2f + 5.6f * random_unit(key, 1) * std::sqrt(random_unit(key, 2));
        // Near the camera a bank thins out instead of filling the view.
        const float alpha = (0.055f + 0.06f * random_unit(key, 3)) * std::min(1.0f, 0.25f + 0.08f * away);
        buffer.values.insert(buffer.values.end(),
                             {x, y, kEye.z - away, size * radius, alpha, random_unit(key, 4),
                              random_unit(key, 5), 0.55f + 0.3f * random_unit(key, 6)});
    }
    draw.buffers = {std::move(buffer)};
    return draw;
}

glm::vec3 random_direction(std::uint64_t key, std::uint32_t first) {
    const float z = 2 * random_unit(key, first) - 1;
    const float angle = glm::two_pi<float>() * random_unit(key, first + 1);
    const float ring = std::sqrt(1 - z * z);
    return {ring * std::cos(angle), ring * std::sin(angle), z};
}

SceneDraw leaves_draw(std::uint64_t seed, const SceneScale& scale) {
    const std::uint32_t leaves = whole(kLeaves * scale.count);
    const std::vector<glm::vec3> ends = twig_ends(seed);
    SceneDraw draw;
    draw.state.name = "leaves";
    draw.vertex = shader_source("leaf_vertex");
    draw.shading = std::string(shader_source("street_light")) + std::string(shader_source("leaf_shading"));
    draw.primitives = 2 * leaves;
    draw.parameters = street_lamps();
    SceneBuffer buffer{1, {}};
    buffer.values.reserve(std::size_t{12} * leaves);
    const auto size = static_cast<float>(scale.size);
    for (std::uint32_t i = 0; i < leaves; ++i) {
        const std::uint64_t key = mix64(mix64(seed ^ 0x4C656166ull) + i);
        const glm::vec3 end = ends[i % ends.size()];
        const glm::vec3 place = end + 0.26f * std::sqrt(random_unit(key, 0)) * random_direction(key, 1);
        // Leaves hang: their tips look down and outwards.
        const glm::vec3 along = glm::normalize(random_direction(key, 3) + glm::vec3(0, -0.7f, 0));
        const glm::vec3 across = glm::normalize(glm::cross(along, random_direction(key, 5)));
        const float half = size * (0.035f + 0.02f * random_unit(key, 7));
        const float autumn = random_unit(key, 8);
        const glm::vec3 a = half * along;
        const glm::vec3 b = 0.5f * half * across;
        buffer.values.insert(buffer.values.end(),
                             {place.x, place.y, place.z, 1.0f, a.x, a.y, a.z, 0.1f + 0.22f * autumn * autumn,
                              b.x, b.y, b.z, 0.17f + 0.06f * random_unit(key, 9)});
    }
    draw.buffers = {std::move(buffer)};
    return draw;
}

SceneDraw lanterns_draw() {
    GlassLook look;
    look.environment = "night_environment";
    look.reflectance = 0.06f;
    look.inner_reflections = 0.05f;
    std::vector<MeshInstance> copies;
    for (const glm::vec4& lamp : street_lamps())
        copies.push_back({placed(glm::vec3(lamp), glm::vec3(1.0f)), {0.95f, 0.9f, 0.78f, 1.0f}});
    return transmissive_draw("lanterns", lantern_panes(), copies, look);
}

class FogScene final : public SceneSource {
 public:
    FogScene(double aspect, std::uint64_t seed) : aspect_(aspect), seed_(seed) { shrinks = true; }

    Scene build(const SceneScale& scale) const override {
        if (scale.count > kMaxScale) {
            throw UserError(
                "--fragments",
                fmt::format("'fog' would need {:.0f} banks of fog, more than {:.0f}; ask for fewer "
                            "fragments or use a larger --size",
                            kBanks * scale.count, kBanks * kMaxScale));
        }
        Scene scene;
        scene.description =
            fmt::format("a street at night: {:.0f} banks of fog, {:.0f} leaves, {} lanterns of glass",
                        std::round(kBanks * scale.count), std::round(kLeaves * scale.count), kStreetLamps);
        scene.materials = true;
        scene.camera = look_at(kEye, {-0.1f, 1.85f, -8.0f}, 40, aspect_, 1.2, 0.2f, 90);
        scene.light = light_camera(glm::normalize(glm::vec3(0.2f, 1, 0.3f)), {0, 2, -20}, 30);
        scene.background = {0.012f, 0.017f, 0.03f};
        scene.opaque = street_draws(seed_);
        scene.transparent.push_back(leaves_draw(seed_, scale));
        scene.transparent.push_back(fog_draw(seed_, scale));
        scene.transparent.push_back(lanterns_draw());
        return scene;
    }

 private:
    double aspect_;
    std::uint64_t seed_;
};

}  // namespace

std::unique_ptr<SceneSource> make_fog_scene(double aspect, std::uint64_t seed) {
    return std::make_unique<FogScene>(aspect, seed);
}

}  // namespace ropsim
