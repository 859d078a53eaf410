// Scene: a head with long hair, thousands of thin translucent strands in the order of their growth.
#include "base/error.h"
#include "base/random.h"
#include "capture/light_volume.h"
#include "capture/scene_list.h"
#include "capture/scene_parts.h"
#include "capture/scenes/hair_strands.h"
#include "capture/shader_sources.h"

#include <algorithm>
#include <cmath>

namespace ropsim {
namespace {

constexpr double kBaseStrands = 12000;
constexpr double kMaxStrands = 200000;  // what fits into a GPU buffer of 128 MiB
constexpr float kHalfWidth = 0.0024f;   // decimetres: a strand stands for several hairs
constexpr float kShadowStrength = 0.35f;

// An opaque mannequin's head: skull, face, neck and shoulders as ellipsoids.
SceneDraw head_draw() {
    const glm::vec4 skin(0.72f, 0.46f, 0.34f, 0.0f);
    const glm::vec4 lips(0.55f, 0.2f, 0.18f, 0.0f);
    const glm::vec4 white(0.8f, 0.78f, 0.75f, 0.0f);
    const glm::vec4 iris(0.05f, 0.07f, 0.09f, 0.0f);
    const glm::vec4 brow(0.1f, 0.05f, 0.03f, 0.0f);
    const glm::vec4 cloth(0.12f, 0.2f, 0.32f, 0.0f);
    std::vector<MeshInstance> parts = {
        {placed(kSkullCentre, kSkullRadii), skin},
        {placed({0, -0.3f, 0.2f}, {0.61f, 0.78f, 0.63f}), skin},     // jaw and cheeks
        {placed({0, -0.84f, 0.42f}, {0.26f, 0.2f, 0.26f}), skin},    // chin
        {placed({0, -0.24f, 0.86f}, {0.085f, 0.24f, 0.1f}), skin},   // nose
        {placed({0, -0.36f, 0.92f}, {0.115f, 0.085f, 0.1f}), skin},  // its tip
        {placed({0, -0.6f, 0.76f}, {0.17f, 0.055f, 0.06f}), lips},
        {placed({0, -1.3f, -0.1f}, {0.4f, 0.9f, 0.4f}), skin},       // neck
        {placed({0, -2.15f, -0.15f}, {1.6f, 0.62f, 0.62f}), cloth},  // shoulders
    };
    for (float side : {-1.0f, 1.0f}) {
        parts.push_back({placed({side * 0.27f, -0.06f, 0.72f}, {0.13f, 0.075f, 0.1f}), white});
        parts.push_back({placed({side * 0.26f, -0.06f, 0.79f}, {0.06f, 0.062f, 0.045f}), iris});
        parts.push_back({placed({side * 0.28f, 0.1f, 0.77f}, {0.17f, 0.028f, 0.07f}), brow});
        parts.push_back({placed({side * 0.76f, -0.12f, 0.0f}, {0.08f, 0.2f, 0.13f}), skin});
    }
    return matte_draw("head", sphere_mesh(40), parts);
}

class HairScene final : public SceneSource {
 public:
    HairScene(double aspect, std::uint64_t seed) : aspect_(aspect), seed_(seed) {}

    Scene build(const SceneScale& scale) const override {
        const double wanted = std::round(kBaseStrands * scale.count);
        if (wanted > kMaxStrands) {
            throw UserError("--fragments",
                            fmt::format("the hair would need {:.0f} strands, more than {:.0f}; ask for "
                                        "fewer fragments or use a larger --size",
                                        wanted, kMaxStrands));
        }
        const auto count = static_cast<std::uint32_t>(std::max(wanted, 1.0));
        Scene scene;
        scene.description = fmt::format("a head of hair, {} strands", count);
        scene.camera = look_at({2.3f, 0.1f, 7.0f}, {0.0f, -0.72f, 0.0f}, 31.5f, aspect_, 1.0, 1.0f, 20);
        scene.light = light_camera(light_direction(), glm::vec3(0, -1.0f, 0), 4.0f);
        scene.camera.metres_per_unit = 0.1f;
        scene.background = {0.32f, 0.36f, 0.4f};
        scene.opaque.push_back(head_draw());
        scene.transparent.push_back(strands_draw(count));
        return scene;
    }

 private:
    SceneDraw strands_draw(std::uint32_t count) const {
        const HairStrands hair = grow_hair(count, seed_);
        LightVolume volume(glm::vec3(-2.2f, -4.0f, -2.2f), glm::vec3(2.2f, 1.6f, 2.2f));
        // Shadows are those of the base amount of hair, whatever the count: the look does not depend on it.
        const float area = kHalfWidth * 0.11f * static_cast<float>(kBaseStrands) / static_cast<float>(count);
        for (const glm::vec3& point : hair.points) volume.deposit(point, area);
        volume.illuminate(light_direction());
        SceneDraw draw;
        draw.state.name = "strands";
        draw.vertex = shader_source("hair_vertex");
        draw.shading = shader_source("hair_shading");
        draw.primitives = count * 2 * (kStrandPoints - 1);
        SceneBuffer points{1, {}};
        points.values.reserve(4 * hair.points.size());
        for (const glm::vec3& p : hair.points) {
            const float light = volume.transmittance(p, kShadowStrength);
            points.values.insert(points.values.end(), {p.x, p.y, p.z, light});
        }
        SceneBuffer strands{2, {}};
        draw.indices.reserve(std::size_t{3} * draw.primitives);
        for (std::uint32_t i = 0; i < count; ++i) {
            const std::uint64_t key = mix64(seed_ * 0x9E3779B97F4A7C15ull + i);
            const float lock = random_unit(mix64(seed_ + hair.locks[i]), 0);
            const float tone = 0.65f + 0.35f * lock + 0.3f * random_unit(key, 0);
            const glm::vec3 color =
                tone * glm::mix(glm::vec3(0.3f, 0.11f, 0.035f), glm::vec3(0.52f, 0.24f, 0.08f), lock);
            strands.values.insert(strands.values.end(),
                                  {color.r, color.g, color.b, 0.1f + 0.3f * random_unit(key, 1)});
            for (std::uint32_t k = 0; k + 1 < kStrandPoints; ++k) {
                const std::uint32_t v = 2 * (i * kStrandPoints + k);
                draw.indices.insert(draw.indices.end(), {v, v + 1, v + 2, v + 1, v + 3, v + 2});
            }
        }
        draw.buffers = {std::move(points), std::move(strands)};
        draw.parameters = {glm::vec4(light_direction(), 0), glm::vec4(kStrandPoints, kHalfWidth, 0, 0)};
        return draw;
    }

    double aspect_;
    std::uint64_t seed_;
};

}  // namespace

std::unique_ptr<SceneSource> make_hair_scene(double aspect, std::uint64_t seed) {
    return std::make_unique<HairScene>(aspect, seed);
}

}  // namespace ropsim
