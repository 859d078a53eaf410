// Scene: a head with long hair, thousands of thin translucent strands in the order of their growth.
#include "base/error.h"
#include "base/random.h"
#include "capture/scene_list.h"
#include "capture/scenery/scene_parts.h"
#include "capture/scenes/hair_draw.h"
#include "capture/scenes/hair_head.h"
#include "capture/scenes/hair_strands.h"

#include <algorithm>
#include <cmath>

namespace ropsim {
namespace {

constexpr double kBaseStrands = 42000;
constexpr double kMaxStrands = 200000;  // what fits into a GPU buffer of 128 MiB
constexpr float kHalfWidth = 0.0026f;   // decimetres: a strand stands for several hairs
constexpr float kShadowStrength = 0.2f;

class HairScene final : public SceneSource {
 public:
    HairScene(double aspect, std::uint64_t seed) : aspect_(aspect), seed_(seed), bust_(bust_draws()) {}

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
        scene.description = fmt::format("a head of long hair, {} strands", count);
        scene.camera = look_at({3.6f, 0.1f, 7.7f}, {0.05f, -0.92f, 0.0f}, 30.0f, aspect_, 1.0, 1.0f, 20);
        scene.light = light_camera(light_direction(), glm::vec3(0, -1.0f, 0), 4.0f);
        scene.camera.metres_per_unit = 0.1f;
        scene.background = {0.32f, 0.36f, 0.4f};
        scene.opaque = bust_;
        scene.transparent.push_back(strands(count));
        return scene;
    }

 private:
    SceneDraw strands(std::uint32_t count) const {
        HairStrands hair = grow_hair(count, seed_);
        StrandGroup group;
        group.name = "strands";
        group.points_a_strand = kStrandPoints;
        group.half_width = kHalfWidth;
        group.points = std::move(hair.points);
        group.looks.reserve(count);
        for (std::uint32_t i = 0; i < count; ++i) {
            const std::uint64_t key = mix64(seed_ * 0x9E3779B97F4A7C15ull + i);
            const float lock = random_unit(mix64(seed_ + hair.locks[i]), 0);
            const float tone = 0.65f + 0.35f * lock + 0.3f * random_unit(key, 0);
            const glm::vec3 color =
                tone * glm::mix(glm::vec3(0.3f, 0.11f, 0.035f), glm::vec3(0.52f, 0.24f, 0.08f), lock);
            group.looks.emplace_back(color, 0.1f + 0.3f * random_unit(key, 1));
        }
        LightVolume volume(glm::vec3(-2.2f, -4.0f, -2.2f), glm::vec3(2.2f, 1.6f, 2.2f));
        // Shadows are those of the base amount of hair, whatever the count: the look does not depend on it.
        deposit_strands(group, static_cast<float>(kBaseStrands) / static_cast<float>(count), volume);
        volume.illuminate(light_direction());
        return strand_draw(group, {&volume, kShadowStrength});
    }

    double aspect_;
    std::uint64_t seed_;
    std::vector<SceneDraw> bust_;
};

}  // namespace

std::unique_ptr<SceneSource> make_hair_scene(double aspect, std::uint64_t seed) {
    return std::make_unique<HairScene>(aspect, seed);
}

}  // namespace ropsim
