// Scene: fires in a yard; smoke passes through a wire fence, windows, vehicles and leaves.
#include "base/error.h"
#include "base/random.h"
#include "capture/geometry/tree_growth.h"
#include "capture/scene_list.h"
#include "capture/scenery/leaf_texture.h"
#include "capture/scenery/scene_parts.h"
#include "capture/scenery/sky_dome.h"
#include "capture/scenery/smoke_column.h"
#include "capture/scenes/smoke_yard.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ropsim {
namespace {

constexpr double kMaxPuffs = 2e6;  // what fits into a GPU buffer of 128 MiB
// All fragments over those of the puffs, at scale 1: beyond it only smoke is added.
constexpr double kPuffsForAll = 1.157;

struct NamedColumn {
    const char* name;
    SmokeColumn column;
    float roundness;
};

std::vector<NamedColumn> smoke_columns() {
    return {
        {"barrel smoke",
         {.source = kBarrelFire,
          .drift = {2.2f, 5.2f, -1.6f},
          .from_radius = 0.22f,
          .to_radius = 1.5f,
          .puff = 0.36f,
          .billows = 70,
          .puffs = 640,
          .alpha = 0.2f,
          .color = {0.62f, 0.6f, 0.57f}},
         0.3f},
        {"far smoke",
         {.source = kFarFire,
          .drift = {3.6f, 12.0f, 1.5f},
          .from_radius = 1.2f,
          .to_radius = 3.6f,
          .puff = 0.85f,
          .billows = 90,
          .puffs = 620,
          .alpha = 0.3f,
          .color = {0.13f, 0.125f, 0.13f}},
         0.3f},
        {"car smoke",
         {.source = kCarFire,
          .drift = {4.2f, 6.8f, 3.6f},
          .from_radius = 0.45f,
          .to_radius = 2.0f,
          .crowding = 1.38f,
          .puff = 0.5f,
          .billows = 130,
          .puffs = 2350,
          .alpha = 0.17f,
          .color = {0.24f, 0.225f, 0.21f}},
         0.35f},
        {"drifting smoke",
         {.source = kCarFire + glm::vec3(-2.0f, -0.7f, 0.6f),
          .drift = {10.5f, 0.9f, 3.2f},
          .bend = 1.0f,
          .from_radius = 0.4f,
          .to_radius = 1.1f,
          .puff = 0.5f,
          .billows = 80,
          .puffs = 330,
          .alpha = 0.12f,
          .color = {0.5f, 0.48f, 0.45f}},
         0.15f},
    };
}

SmokeColumn flames(glm::vec3 source, float radius) {
    return {.source = source - glm::vec3(0, 0.12f, 0),
            .drift = {0.15f, 3.6f * radius, 0.05f},
            .from_radius = radius,
            .to_radius = 0.3f * radius,
            .crowding = 1.6f,
            .puff = 0.62f * radius,
            .billows = 18,
            .puffs = 70,
            .alpha = 0.5f,
            .color = {2.2f, 0.75f, 0.12f}};
}

// Evenly spaced, so many of a hundred of the cards or panes.
void keep_share(std::vector<Card>& cards, double share) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < cards.size(); ++i) {
        if (std::floor(static_cast<double>(i + 1) * share) > std::floor(static_cast<double>(i) * share))
            cards[kept++] = cards[i];
    }
    cards.resize(kept);
}

void keep_share(SceneryMesh& panes, double share) {
    std::size_t kept = 0;
    for (std::size_t quad = 0; 6 * quad < panes.indices.size(); ++quad) {
        if (std::floor(static_cast<double>(quad + 1) * share) <=
            std::floor(static_cast<double>(quad) * share))
            continue;
        std::copy_n(panes.indices.begin() + static_cast<std::ptrdiff_t>(6 * quad), 6,
                    panes.indices.begin() + static_cast<std::ptrdiff_t>(6 * kept));
        ++kept;
    }
    panes.indices.resize(6 * kept);
}

class SmokeScene final : public SceneSource {
 public:
    SmokeScene(double aspect, std::uint64_t seed) : aspect_(aspect), seed_(seed) {}

    Scene build(const SceneScale& scale) const override {
        const double smoke = scale.count > 1 ? 1 + (scale.count - 1) * kPuffsForAll : scale.count;
        Scene scene;
        scene.camera = look_at({0.4f, 1.9f, 14.0f}, {0.2f, 2.75f, 0.0f}, 38.0f, aspect_, 1.4, 0.5f, 150);
        scene.light = light_camera(light_direction(), {0, 4.0f, -6.0f}, 24.0f);
        scene.background = daylight_.haze;
        const std::vector<std::vector<Card>> puffs = make_smoke(smoke, scene.camera);
        std::size_t count = 0;
        for (const std::vector<Card>& cards : puffs) count += cards.size();
        scene.description = fmt::format("smoke over a fenced yard, {} puffs", count);
        LightVolume volume(glm::vec3(-11, -0.2f, -16), glm::vec3(14, 14, 6));
        for (const std::vector<Card>& cards : puffs)
            deposit_puffs(cards, static_cast<float>(1 / std::max(smoke, 1e-6)), volume);
        volume.illuminate(light_direction());
        SmokeYard yard = make_smoke_yard(1.0, seed_);
        light_yard(yard, volume);
        add_draws(scene, yard, std::min(scale.count, 1.0), lit(puffs, yard.shadow, volume));
        // Of few things, none may be of a kind.
        std::erase_if(scene.transparent, [](const SceneDraw& draw) { return draw.primitives == 0; });
        return scene;
    }

 private:
    std::vector<std::vector<Card>> make_smoke(double scale, const Camera& camera) const {
        const Turbulence turbulence(seed_);
        const glm::mat3 axes = glm::transpose(glm::mat3(camera.view));
        std::vector<SmokeColumn> columns;
        for (const NamedColumn& named : smoke_columns()) columns.push_back(named.column);
        columns.push_back(flames(kCarFire + glm::vec3(-0.1f, 0, 0.6f), 0.4f));
        columns.push_back(flames(kBarrelFire, 0.22f));
        std::vector<std::vector<Card>> puffs;
        for (std::size_t i = 0; i < columns.size(); ++i) {
            const double wanted = std::round(columns[i].puffs * scale);
            if (wanted > kMaxPuffs) {
                throw UserError(
                    "--fragments",
                    fmt::format("the smoke would need {:.0f} puffs in a column, more than {:.0f}; ask "
                                "for fewer fragments or use a larger --size",
                                wanted, kMaxPuffs));
            }
            puffs.push_back(make_puffs(columns[i], static_cast<std::uint32_t>(wanted), turbulence, axes[0],
                                       axes[1], mix64(seed_ ^ (i << 40))));
        }
        return puffs;
    }

    static void light_yard(SmokeYard& yard, const LightVolume& volume) {
        const auto light = [&](glm::vec3 position, glm::vec3 normal) {
            const glm::vec3 off = position + 0.03f * normal;
            return yard.shadow.light(off) * volume.transmittance(off, 0.7f);
        };
        for (SceneryMesh* mesh : {&yard.ground, &yard.solids, &yard.car_glass, &yard.house_glass})
            mesh->illuminate(light);
        LightVolume leaves(glm::vec3(-12, 0, -15), glm::vec3(12, 9, 2));
        deposit_cards(yard.twigs, 0.18f, leaves);
        leaves.illuminate(light_direction());
        illuminate_cards(yard.twigs, leaves, 1.0f);
    }

    // Smoke is lit through itself; fires glow.
    static std::vector<std::vector<Card>> lit(std::vector<std::vector<Card>> puffs, const SunShadow& shadow,
                                              const LightVolume& volume) {
        for (std::vector<Card>& cards : puffs) {
            for (Card& card : cards) {
                const bool fire = card.color.r > 1;
                card.light =
                    fire ? 1.0f : volume.transmittance(card.centre, 0.5f) * shadow.light(card.centre);
            }
        }
        return puffs;
    }

    void add_draws(Scene& scene, SmokeYard& yard, double share, std::vector<std::vector<Card>> puffs) const {
        scene.opaque.push_back(
            scenery_draw("sky", sky_dome(daylight_, {0.2f, 0.33f, 0.58f}, 120, seed_), daylight_, seed_));
        scene.opaque.push_back(scenery_draw("ground", yard.ground, daylight_, seed_));
        scene.opaque.push_back(scenery_draw("solids", yard.solids, daylight_, seed_));
        shuffle_cards(yard.twigs, seed_);
        shuffle_cards(yard.fence, seed_);
        for (std::vector<Card>* cards : {&yard.twigs, &yard.fence}) keep_share(*cards, share);
        for (SceneryMesh* panes : {&yard.car_glass, &yard.house_glass}) keep_share(*panes, share);
        const std::vector<NamedColumn> columns = smoke_columns();
        const auto smoke = [&](std::size_t i) {
            scene.transparent.push_back(
                smoke_draw(columns[i].name, puffs[i], puff_texture(seed_), daylight_, columns[i].roundness));
        };
        // In no order of depth: what is in front of what differs from pixel to pixel.
        smoke(0);
        scene.transparent.push_back(film_draw("car windows", yard.car_glass, daylight_));
        smoke(1);
        scene.transparent.push_back(cutout_draw("fence", yard.fence, wire_texture(), daylight_, false));
        smoke(2);
        scene.transparent.push_back(cutout_draw(
            "leaves", yard.twigs, twig_texture(seed_, glm::vec3(0.13f, 0.22f, 0.045f)), daylight_, true));
        scene.transparent.push_back(film_draw("windows", yard.house_glass, daylight_));
        smoke(3);
        std::vector<Card> fires = std::move(puffs[4]);
        fires.insert(fires.end(), puffs[5].begin(), puffs[5].end());
        scene.transparent.push_back(smoke_draw("flames", fires, puff_texture(seed_ + 1), daylight_, 0));
    }

    double aspect_;
    std::uint64_t seed_;
    Daylight daylight_;
};

}  // namespace

std::unique_ptr<SceneSource> make_smoke_scene(double aspect, std::uint64_t seed) {
    return std::make_unique<SmokeScene>(aspect, seed);
}

}  // namespace ropsim
