// Scene: a dog with 300,000 hairs.
#include "base/error.h"
#include "capture/scene_list.h"
#include "capture/scenery/light_volume.h"
#include "capture/scenery/scene_parts.h"
#include "capture/scenes/dog_body.h"
#include "capture/scenes/dog_fur.h"
#include "capture/scenes/painted_mesh.h"

#include <algorithm>
#include <cmath>

namespace ropsim {
namespace {

constexpr double kBaseHairs = 300000;
constexpr double kMaxHairs = 1.2e6;
constexpr float kShadowStrength = 0.16f;
constexpr glm::vec3 kLow{-10.0f, -0.2f, -6.0f};  // of the volume that casts and receives shadows
constexpr glm::vec3 kHigh{6.4f, 8.6f, 2.4f};

class DogScene final : public SceneSource {
 public:
    DogScene(double aspect, std::uint64_t seed)
        : aspect_(aspect),
          seed_(seed),
          body_(dog_body()),
          skin_(body_.mesh({-5.4f, -0.3f, -1.7f}, {5.6f, 8.0f, 1.7f}, 0.06f)),
          details_(dog_details()) {}

    Scene build(const SceneScale& scale) const override {
        const double wanted = std::round(kBaseHairs * scale.count);
        if (wanted > kMaxHairs) {
            throw UserError("--fragments",
                            fmt::format("the dog would need {:.0f} hairs, more than {:.0f}; ask for fewer "
                                        "fragments or use a larger --size",
                                        wanted, kMaxHairs));
        }
        const auto count = static_cast<std::uint32_t>(std::max(wanted, 1.0));
        Scene scene;
        scene.description = fmt::format("a dog with {} hairs", count);
        scene.counted_primitives = count;
        scene.camera = look_at({13.2f, 7.2f, 15.6f}, {0.45f, 3.7f, -0.3f}, 25.0f, aspect_, 1.06, 5.0f, 80.0f);
        scene.camera.metres_per_unit = 0.1f;
        scene.light = light_camera(light_direction(), glm::vec3(0, 3.8f, 0), 6.8f);
        scene.background = {0.42f, 0.55f, 0.7f};
        const std::vector<StrandGroup> fur = groom_dog(skin_, count, seed_);
        LightVolume volume(kLow, kHigh);
        // Shadows are those of the base amount of fur, whatever the count: the look does not depend on it.
        const float share = static_cast<float>(kBaseHairs) / static_cast<float>(count);
        for (const StrandGroup& group : fur) deposit_strands(group, share, volume);
        deposit_body(volume);
        volume.illuminate(light_direction());
        for (const StrandGroup& group : fur)
            scene.transparent.push_back(strand_draw(group, {&volume, kShadowStrength}));
        scene.opaque = details_;
        scene.opaque.push_back(painted_draw("skin", skin_, [&](glm::vec3 p, glm::vec3 n) {
            const float light = volume.transmittance(p + 0.1f * n, kShadowStrength);
            return glm::vec4(0.6f * dog_color(p, dog_noise(p)), light);
        }));
        scene.opaque.push_back(ground(volume));
        return scene;
    }

 private:
    // The body itself, so that it shades its own fur and the ground.
    void deposit_body(LightVolume& volume) const {
        const glm::vec3 cell = (kHigh - kLow) / static_cast<float>(LightVolume::kCells);
        for (int i = 0; i < LightVolume::kCells * LightVolume::kCells * LightVolume::kCells; ++i) {
            const glm::ivec3 c(i % LightVolume::kCells, i / LightVolume::kCells % LightVolume::kCells,
                               i / (LightVolume::kCells * LightVolume::kCells));
            const glm::vec3 p = kLow + cell * (glm::vec3(c) + 0.5f);
            if (std::fabs(p.z) < 1.7f && p.x > -5.2f && body_.distance(p) < -0.1f)
                volume.deposit(p, 30.0f * cell.x * cell.y * cell.z);
        }
    }

    static SceneDraw ground(const LightVolume& volume) {
        const TriangleMesh mesh = terrain_mesh({0, 0}, 60, 400, [](glm::vec2 at) {
            return 0.06f * std::sin(0.7f * at.x + 1) * std::sin(0.9f * at.y) - 0.04f;
        });
        return painted_draw("ground", mesh, [&](glm::vec3 p, glm::vec3) {
            const float light = volume.transmittance(p + glm::vec3(0, 0.1f, 0), kShadowStrength);
            const float mottle = 0.5f + 0.5f * dog_noise(1.7f * p) * dog_noise(0.31f * p + 2.0f);
            const glm::vec3 color =
                glm::mix(glm::vec3(0.13f, 0.2f, 0.06f), glm::vec3(0.22f, 0.26f, 0.1f), mottle);
            const bool shaded = p.x > kLow.x && p.x < kHigh.x && p.z > kLow.z && p.z < kHigh.z;
            return glm::vec4(color, shaded ? light : 1.0f);
        });
    }

    double aspect_;
    std::uint64_t seed_;
    BlobBody body_;
    TriangleMesh skin_;
    std::vector<SceneDraw> details_;
};

}  // namespace

std::unique_ptr<SceneSource> make_dog_scene(double aspect, std::uint64_t seed) {
    return std::make_unique<DogScene>(aspect, seed);
}

}  // namespace ropsim
