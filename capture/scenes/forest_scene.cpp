// Scene: a wood of trees, ferns and grass on cards with smooth cut-outs, in random order, under a hazy sky.
#include "base/error.h"
#include "base/random.h"
#include "capture/geometry/tree_growth.h"
#include "capture/scene_list.h"
#include "capture/scenery/leaf_texture.h"
#include "capture/scenery/scene_parts.h"
#include "capture/scenery/sky_dome.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

constexpr double kMaxScale = 150;  // what fits into a GPU buffer of 128 MiB
constexpr glm::vec3 kEye{0.0f, 1.65f, 10.0f};
constexpr float kSpacing = 3.7f;  // from tree to tree, metres
constexpr float kDepth = 41.0f;   // of the wood

// Middle of the path through the wood.
float path_x(float z) {
    return 0.9f * std::sin(0.16f * z) - 0.25f;
}

float ground_height(float x, float z) {
    const float bumps =
        0.22f * std::sin(0.31f * x + 0.7f) * std::sin(0.27f * z) + 0.12f * std::sin(0.6f * x - 0.4f * z);
    const float aside = glm::smoothstep(0.8f, 4.0f, std::abs(x - path_x(z)));
    return aside * (bumps + 0.35f) - 0.15f;
}

// What grows, each kind with its own cards.
struct Wood {
    SceneryMesh trunks;
    std::vector<Card> broadleaf;
    std::vector<Card> conifer;
    std::vector<Card> fern;
    std::vector<Card> grass;
};

// Whether a plant of this size can be seen at all.
bool in_view(glm::vec3 foot, float margin) {
    const float distance = kEye.z - foot.z;
    return std::abs(foot.x) < 0.86f * distance + margin;
}

void add_tree(Wood& wood, glm::vec3 foot, int times, std::uint64_t key) {
    const float distance = glm::length(foot - kEye);
    // Far trees have fewer, larger cards, as games draw them.
    const float coarse = 1 + distance / 26;
    TreeForm form;
    form.conifer = random_unit(key, 2) < 0.42f;
    form.height = (form.conifer ? 9.5f : 8.0f) * (0.8f + 0.45f * random_unit(key, 3));
    form.trunk_radius = 0.11f + 0.1f * random_unit(key, 4);
    form.crown_from = (form.conifer ? 0.14f : 0.24f) + 0.12f * random_unit(key, 5);
    form.crown_radius = (form.conifer ? 2.0f : 2.3f) * (0.8f + 0.4f * random_unit(key, 6));
    form.branches = form.conifer ? 44 : 22;
    form.card_size = (form.conifer ? 0.52f : 0.42f) * coarse;
    const float cards = (form.conifer ? 167.0f : 133.0f) / (coarse * coarse);
    form.cards = times * static_cast<int>(std::ceil(cards));
    form.bark = form.conifer ? glm::vec3(0.15f, 0.1f, 0.07f) : glm::vec3(0.2f, 0.17f, 0.13f);
    grow_tree(form, foot, key, wood.trunks, form.conifer ? wood.conifer : wood.broadleaf);
}

void add_bush(Wood& wood, glm::vec3 foot, int times, std::uint64_t key) {
    TreeForm form;
    form.height = 0.9f + 0.9f * random_unit(key, 2);
    form.trunk_radius = 0;
    form.crown_from = 0;
    form.crown_radius = 0.7f + 0.4f * random_unit(key, 3);
    form.branches = 9;
    form.card_size = 0.26f + 0.012f * glm::length(foot - kEye);
    form.cards = times * 20;
    grow_tree(form, foot, key, wood.trunks, wood.broadleaf);
}

// A rosette of fronds that arch outwards.
void add_fern(Wood& wood, glm::vec3 foot, int times, std::uint64_t key) {
    const int fronds = times * 8;
    for (int i = 0; i < fronds; ++i) {
        const auto draw = static_cast<std::uint32_t>(4 * i + 8);
        const float angle = 2.4f * static_cast<float>(i) + 0.8f * random_unit(key, draw);
        const glm::vec3 out(std::cos(angle), 0, std::sin(angle));
        const float lean = 0.7f + 0.5f * random_unit(key, draw + 1);
        const float half = (0.26f + 0.2f * random_unit(key, draw + 2)) * (0.8f + 0.5f * random_unit(key, 3));
        Card card{};
        card.up = half * (std::sin(lean) * out + glm::vec3(0, std::cos(lean), 0));
        card.right = 0.85f * half * glm::normalize(glm::cross(out, glm::vec3(0, 1, 0)));
        card.centre = foot + card.up + glm::vec3(0, -0.02f, 0);
        card.columns = card.rows = 1;
        const float tone = 0.7f + 0.5f * random_unit(key, draw + 3);
        card.color = glm::vec4(tone, tone, tone, 1);
        wood.fern.push_back(card);
    }
}

void add_grass(Wood& wood, glm::vec3 foot, int times, std::uint64_t key) {
    const int blades = times * 2;
    for (int i = 0; i < blades; ++i) {
        const auto draw = static_cast<std::uint32_t>(3 * i + 8);
        const float angle = 1.7f * static_cast<float>(i) + glm::pi<float>() * random_unit(key, draw);
        const float half = 0.13f + 0.12f * random_unit(key, draw + 1);
        Card card{};
        card.up = glm::vec3(0, half, 0);
        card.right = 1.2f * half * glm::vec3(std::cos(angle), 0, std::sin(angle));
        card.centre = foot + card.up - glm::vec3(0, 0.02f, 0);
        card.columns = card.rows = 1;
        const float tone = 0.7f + 0.5f * random_unit(key, draw + 2);
        card.color = glm::vec4(tone * 1.05f, tone, tone * 0.9f, 1);
        wood.grass.push_back(card);
    }
}

// Plants at random places of the triangle that the eye sees, `count` of them from `nearest` to `reach` metres
// away, denser nearby.
template <typename Add>
void scatter(std::uint64_t seed, int count, float nearest, float reach, float clearing, const Add& add) {
    for (int i = 0; i < count; ++i) {
        const std::uint64_t key = mix64(seed + static_cast<std::uint64_t>(i));
        const float distance = nearest + (reach - nearest) * std::pow(random_unit(key, 0), 0.8f);
        const float x = (2 * random_unit(key, 1) - 1) * (0.9f * distance + 0.5f);
        const float z = kEye.z - distance;
        if (std::abs(x - path_x(z)) < clearing) continue;
        add(glm::vec3(x, ground_height(x, z), z), key);
    }
}

Wood plant_wood(int times, std::uint64_t seed) {
    Wood wood;
    const int rows = static_cast<int>(kDepth / kSpacing);
    for (int row = 0; row < rows; ++row) {
        for (int column = -14; column <= 14; ++column) {
            const std::uint64_t key =
                mix64(seed ^ (0x54726565ull << 32) ^ static_cast<std::uint64_t>(row * 64 + column + 32));
            const float x = kSpacing * (static_cast<float>(column) + 0.75f * (random_unit(key, 0) - 0.5f));
            const float z =
                4.5f - kSpacing * (static_cast<float>(row) + 0.75f * (random_unit(key, 1) - 0.5f));
            const glm::vec3 foot(x, ground_height(x, z), z);
            if (std::abs(x - path_x(z)) < 1.9f || !in_view(foot, 2.0f)) continue;
            add_tree(wood, foot, times, key);
        }
    }
    scatter(mix64(seed ^ 0x62757368u), 44, 5.0f, 20, 1.3f,
            [&](glm::vec3 foot, std::uint64_t key) { add_bush(wood, foot, times, key); });
    scatter(mix64(seed ^ 0x6665726Eu), 200, 2.2f, 17, 0.7f,
            [&](glm::vec3 foot, std::uint64_t key) { add_fern(wood, foot, times, key); });
    scatter(mix64(seed ^ 0x67726173u), 880, 2.2f, 14, 0.35f,
            [&](glm::vec3 foot, std::uint64_t key) { add_grass(wood, foot, times, key); });
    return wood;
}

SceneryMesh make_ground() {
    SceneryMesh ground;
    ground.add_quad({-42, 0, 10}, {42, 0, 10}, {42, 0, -52}, {-42, 0, -52}, glm::vec4(1.0f), Finish::kGround,
                    280, 220);
    for (SceneryVertex& vertex : ground.vertices) {
        glm::vec3& p = vertex.position;
        p.y = ground_height(p.x, p.z);
        const float e = 0.1f;
        vertex.normal =
            glm::normalize(glm::vec3(ground_height(p.x - e, p.z) - ground_height(p.x + e, p.z), 2 * e,
                                     ground_height(p.x, p.z - e) - ground_height(p.x, p.z + e)));
        const float path = 1 - glm::smoothstep(0.3f, 1.0f, std::abs(p.x - path_x(p.z)));
        vertex.color =
            glm::vec4(glm::mix(glm::vec3(0.13f, 0.12f, 0.05f), glm::vec3(0.27f, 0.2f, 0.13f), path), 1);
    }
    return ground;
}

class ForestScene final : public SceneSource {
 public:
    ForestScene(double aspect, std::uint64_t seed) : aspect_(aspect), seed_(seed) {
        daylight_.haze = {0.6f, 0.68f, 0.62f};
        daylight_.haze_extinction = 0.0115f;
        daylight_.sun = {1.9f, 1.7f, 1.3f};
        daylight_.sky = {0.24f, 0.29f, 0.28f};
    }

    Scene build(const SceneScale& scale) const override {
        if (scale.count > kMaxScale) {
            throw UserError(
                "--fragments",
                fmt::format("the wood would need {:.0f} times its cards, more than {:.0f} times; ask "
                            "for fewer fragments or use a larger --size",
                            scale.count, kMaxScale));
        }
        // Whole multiples of every plant's cards are grown, and as many of them drawn as asked for.
        const double grown = std::max(std::ceil(scale.count), 1.0);
        Wood wood = plant_wood(static_cast<int>(grown), seed_);
        LightVolume volume(glm::vec3(-40, -0.5f, -46), glm::vec3(40, 15, 12));
        for (std::vector<Card>* cards : {&wood.broadleaf, &wood.conifer, &wood.fern, &wood.grass}) {
            // Shadows are those of scale 1, whatever the number of cards: the look does not depend on it.
            deposit_cards(*cards, 0.16f / static_cast<float>(grown), volume);
        }
        volume.illuminate(light_direction());
        SceneryMesh ground = make_ground();
        for (SceneryMesh* mesh : {&ground, &wood.trunks})
            mesh->illuminate(
                [&](glm::vec3 position, glm::vec3) { return volume.transmittance(position, 1.0f); });
        Scene scene;
        scene.camera = look_at(kEye, {0.1f, 3.0f, -6.0f}, 50.0f, aspect_, 1.4, 0.3f, 150);
        scene.light = light_camera(light_direction(), {0, 5.0f, -18.0f}, 46.0f);
        scene.background = daylight_.haze;
        scene.opaque.push_back(
            scenery_draw("sky", sky_dome(daylight_, {0.42f, 0.56f, 0.72f}, 120, seed_), daylight_, seed_));
        scene.opaque.push_back(scenery_draw("ground", ground, daylight_, seed_));
        scene.opaque.push_back(scenery_draw("trunks", wood.trunks, daylight_, seed_));
        const glm::vec3 green(0.12f, 0.2f, 0.035f);
        std::size_t total = 0;
        const auto draw = [&](const char* name, std::vector<Card>& cards, SceneTexture texture) {
            illuminate_cards(cards, volume, 0.75f);
            shuffle_cards(cards, seed_);
            cards.resize(static_cast<std::size_t>(
                std::lround(scale.count / grown * static_cast<double>(cards.size()))));
            total += cards.size();
            scene.transparent.push_back(cutout_draw(name, cards, std::move(texture), daylight_, true));
        };
        draw("conifers", wood.conifer, spray_texture(seed_, {0.06f, 0.125f, 0.045f}));
        draw("grass", wood.grass, grass_texture(seed_, {0.16f, 0.22f, 0.05f}));
        draw("broadleaf trees and bushes", wood.broadleaf, twig_texture(seed_, green));
        draw("ferns", wood.fern, fern_texture(seed_, {0.13f, 0.23f, 0.045f}));
        // Of few things, none may be of a kind.
        std::erase_if(scene.transparent, [](const SceneDraw& d) { return d.primitives == 0; });
        scene.description = fmt::format("a wood, {} cards", total);
        return scene;
    }

 private:
    double aspect_;
    std::uint64_t seed_;
    Daylight daylight_;
};

}  // namespace

std::unique_ptr<SceneSource> make_forest_scene(double aspect, std::uint64_t seed) {
    return std::make_unique<ForestScene>(aspect, seed);
}

}  // namespace ropsim
