// Scene: a woman on a hill in the wind: hair, grass, leaves and a sheer scarf among opaque models.
#include "base/error.h"
#include "base/random.h"
#include "capture/scene_list.h"
#include "capture/scenery/light_volume.h"
#include "capture/scenery/scene_parts.h"
#include "capture/scenes/hair_draw.h"
#include "capture/scenes/hair_strands.h"
#include "capture/scenes/painted_mesh.h"
#include "capture/scenes/windy_cards.h"
#include "capture/scenes/windy_figure.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

constexpr double kBaseHairs = 15000;
constexpr double kBaseCards = 6000;
constexpr double kLeafShare = 0.1;  // of the cards
constexpr double kMostTimes = 60;
constexpr float kHairShadow = 0.35f;
constexpr glm::vec3 kEye{15.0f, -11.2f, 31.0f};

class WindyHillScene final : public SceneSource {
 public:
    WindyHillScene(double aspect, std::uint64_t seed)
        : aspect_(aspect),
          seed_(seed),
          models_(hill_models()),
          atlas_(plant_atlas(seed)),
          scarf_{scarf_tail(0), scarf_tail(1)},
          shadows_(glm::vec3(-22, -19, -26), glm::vec3(22, 4, 18)) {
        deposit_models();
        shadows_.illuminate(light_direction());
    }

    Scene build(const SceneScale& scale) const override {
        if (scale.count > kMostTimes) {
            throw UserError("--fragments",
                            fmt::format("the hill would need {:.0f} cards, more than {:.0f}; ask "
                                        "for fewer fragments or use a larger --size",
                                        kBaseCards * scale.count, kBaseCards * kMostTimes));
        }
        const auto amount = [&](double base) {
            return static_cast<std::uint32_t>(std::max(std::round(base * scale.count), 1.0));
        };
        const std::uint32_t hairs = amount(kBaseHairs);
        const std::uint32_t leaves = amount(kBaseCards * kLeafShare);
        const std::uint32_t grass = std::max(amount(kBaseCards), leaves + 1) - leaves;
        Scene scene;
        scene.counted_primitives = hairs;
        scene.description = fmt::format("a windy hill, {} hairs, {} cards, a scarf", hairs, grass + leaves);
        scene.camera = look_at(kEye, {3.2f, -7.9f, 0.0f}, 35.0f, aspect_, 1.0, 2.0f, 200);
        scene.camera.metres_per_unit = 0.1f;
        scene.light = light_camera(light_direction(), glm::vec3(2, -10, 0), 44);
        scene.background = {0.36f, 0.55f, 0.8f};
        scene.opaque = models_;
        scene.opaque.push_back(ground());
        scene.transparent.push_back(plant_card_draw("leaves", make_leaves(leaves), atlas_, kWind));
        scene.transparent.push_back(hair_draw(hairs));
        scene.transparent.push_back(plant_card_draw("grass", make_grass(grass), atlas_, kWind));
        for (const Scarf& tail : scarf_) scene.transparent.push_back(scarf_draw("scarf", tail, shadows_));
        return scene;
    }

 private:
    void deposit_models() {
        const BlobBody figure = figure_dress();
        const BlobBody wood = tree_wood();
        constexpr int kSteps = 64;
        for (int i = 0; i < kSteps * kSteps * kSteps; ++i) {
            const glm::vec3 unit = (glm::vec3(i % kSteps, i / kSteps % kSteps, i / kSteps / kSteps) + 0.5f) /
                                   static_cast<float>(kSteps);
            const glm::vec3 size(6, 16, 6);
            const glm::vec3 p = glm::vec3(-3, kFeet, -3) + size * unit;
            if (p.y < -2.5f && figure.distance(p) < 0)
                shadows_.deposit(p, 3.0f * size.x * size.y * size.z / (kSteps * kSteps * kSteps));
        }
        for (const glm::vec4& crown : tree_crowns()) {
            for (std::uint32_t k = 0; k < 300; ++k) {
                const std::uint64_t key = mix64(k);
                const glm::vec3 unit(random_unit(key, 0), random_unit(key, 1), random_unit(key, 2));
                const glm::vec3 p = 2.0f * unit - 1.0f;
                if (glm::length(p) < 1)
                    shadows_.deposit(glm::vec3(crown) + crown.w * p, 0.012f * crown.w * crown.w * crown.w);
            }
        }
        for (const Scarf& tail : scarf_)
            for (const glm::vec3& p : tail.points) shadows_.deposit(p, 0.008f);
    }

    SceneDraw ground() const {
        const TriangleMesh mesh = terrain_mesh({2, -4}, 90, 300, hill_height);
        return painted_draw("ground", mesh, [&](glm::vec3 p, glm::vec3) {
            const float mottle =
                0.5f + 0.5f * std::sin(0.9f * p.x + 1.3f * p.z) * std::sin(0.7f * p.z - 0.4f * p.x);
            const glm::vec3 color =
                glm::mix(glm::vec3(0.1f, 0.16f, 0.04f), glm::vec3(0.17f, 0.21f, 0.07f), mottle);
            return glm::vec4(color, light_at(p));
        });
    }

    float light_at(glm::vec3 p) const {
        const bool inside = p.x > -22 && p.x < 22 && p.z > -26 && p.z < 18;
        return inside ? shadows_.transmittance(p + glm::vec3(0, 0.3f, 0), 1.0f) : 1.0f;
    }

    std::vector<PlantCard> make_grass(std::uint32_t count) const {
        std::vector<PlantCard> cards(count);
        for (std::uint32_t i = 0; i < count; ++i) {
            const std::uint64_t key = mix64(seed_ ^ (0x47726173ull << 32) ^ i);
            glm::vec2 at(0);
            // Not inside the woman's skirt, nor right before the camera.
            for (std::uint32_t draw = 16;; draw += 2) {
                at = glm::vec2(-26 + 56 * random_unit(key, draw), -24 + 50 * random_unit(key, draw + 1));
                if (glm::length(at - glm::vec2(0.4f, -0.3f)) > 2.3f &&
                    glm::distance(at, {kEye.x, kEye.z}) > 9)
                    break;
            }
            PlantCard& card = cards[i];
            const float gust = 0.5f + 0.5f * std::sin(0.45f * at.x - 0.25f * at.y) * std::cos(0.3f * at.y);
            card.base = {at.x, hill_height(at) - 0.15f, at.y};
            card.height =
                2.4f + 2.6f * random_unit(key, 0) + 3.6f * random_unit(key, 1) * random_unit(key, 2);
            card.width = 0.42f * card.height;
            card.yaw = glm::two_pi<float>() * random_unit(key, 3);
            card.bend = 0.25f + 0.4f * gust + 0.2f * random_unit(key, 4);
            card.column = random_unit(key, 5) < 0.12f ? 2 : random_unit(key, 6) < 0.5f ? 0 : 1;
            const float tone = 0.8f + 0.4f * random_unit(key, 7);
            card.tint = glm::vec4(tone * glm::mix(glm::vec3(1), glm::vec3(1.25f, 1.1f, 0.8f), gust),
                                  light_at(card.base + glm::vec3(0, 0.5f * card.height, 0)));
        }
        return cards;
    }

    std::vector<PlantCard> make_leaves(std::uint32_t count) const {
        const std::vector<glm::vec4> crowns = tree_crowns();
        std::vector<PlantCard> cards(count);
        for (std::uint32_t i = 0; i < count; ++i) {
            const std::uint64_t key = mix64(seed_ ^ (0x4C656176ull << 32) ^ i);
            const glm::vec4& crown = crowns[i % crowns.size()];
            const float y = 2 * random_unit(key, 0) - 1;
            const float phi = glm::two_pi<float>() * random_unit(key, 1);
            const float r = std::sqrt(1 - y * y);
            const float out = crown.w * std::cbrt(0.15f + 0.85f * random_unit(key, 2));
            PlantCard& card = cards[i];
            card.height = 1.9f;
            card.width = 1.2f;
            card.base = glm::vec3(crown) + out * glm::vec3(r * std::cos(phi), y, r * std::sin(phi)) -
                        glm::vec3(0, 0.5f * card.height, 0);
            card.yaw = glm::two_pi<float>() * random_unit(key, 3);
            card.bend = 0.35f + 0.3f * random_unit(key, 4);
            card.column = 3;
            const float tone = 0.8f + 0.4f * random_unit(key, 5);
            card.tint = glm::vec4(glm::vec3(tone), light_at(card.base));
        }
        return cards;
    }

    SceneDraw hair_draw(std::uint32_t count) const {
        HairStyle style;
        style.length = 4.2f;
        style.weight = 1.3f;
        style.sweep = 0;
        style.wind = 4.5f * kWind;
        style.gust = 0.55f;
        HairStrands hair = grow_hair(count, seed_, style);
        StrandGroup group;
        group.name = "hair";
        group.points_a_strand = kStrandPoints;
        group.half_width = 0.011f;
        group.points = std::move(hair.points);
        for (std::uint32_t i = 0; i < count; ++i) {
            const std::uint64_t key = mix64(seed_ * 0x9E3779B97F4A7C15ull + i);
            const float tone =
                0.6f + 0.5f * random_unit(mix64(seed_ + hair.locks[i]), 0) + 0.3f * random_unit(key, 0);
            group.looks.emplace_back(tone * glm::vec3(0.3f, 0.13f, 0.05f), 0.2f + 0.4f * random_unit(key, 1));
        }
        LightVolume volume(glm::vec3(-3, -5, -5), glm::vec3(7, 2.4f, 3));
        deposit_strands(group, static_cast<float>(kBaseHairs) / static_cast<float>(count), volume);
        volume.illuminate(light_direction());
        return strand_draw(group, {&volume, kHairShadow});
    }

    double aspect_;
    std::uint64_t seed_;
    std::vector<SceneDraw> models_;
    SceneTexture atlas_;
    std::vector<Scarf> scarf_;
    LightVolume shadows_;  // of what does not depend on the amount drawn
};

}  // namespace

std::unique_ptr<SceneSource> make_windy_hill_scene(double aspect, std::uint64_t seed) {
    return std::make_unique<WindyHillScene>(aspect, seed);
}

}  // namespace ropsim
