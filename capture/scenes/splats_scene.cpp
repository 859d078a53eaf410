// Scene: a garden as a trained capture in 3D Gaussians would show it.
#include "base/error.h"
#include "base/parallel.h"
#include "base/random.h"
#include "capture/files/splat_file.h"
#include "capture/geometry/shuffled_order.h"
#include "capture/scene_list.h"
#include "capture/scenery/light_volume.h"
#include "capture/scenery/scene_parts.h"
#include "capture/scenery/splat_draw.h"
#include "capture/scenes/garden.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

constexpr double kBaseSplats = 1e6;
constexpr double kMaxSplats = 3.2e7;
constexpr std::uint32_t kBatch = 8192;
constexpr float kShadowCell = 0.16f;  // how far off its own surface a splat looks for shadows, metres
constexpr glm::vec3 kShadowLow{-3.4f, -0.1f, -3.4f};  // of the part that has shadows: the patio
constexpr glm::vec3 kShadowHigh{3.4f, 2.0f, 3.4f};

glm::vec3 display(glm::vec3 color) {
    const auto encode = [](float c) {
        return c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1.0f / 2.4f) - 0.055f;
    };
    return {encode(color.r), encode(color.g), encode(color.b)};
}

class SplatsScene final : public SceneSource {
 public:
    SplatsScene(double aspect, std::uint64_t seed) : aspect_(aspect), seed_(seed) {}

    Scene build(const SceneScale& scale) const override {
        const double wanted = std::round(kBaseSplats * scale.count);
        if (wanted > kMaxSplats) {
            throw UserError("--fragments",
                            fmt::format("the garden would need {:.0f} splats, more than {:.0f}; ask for "
                                        "fewer fragments or use a larger --size",
                                        wanted, kMaxSplats));
        }
        const auto count = static_cast<std::uint32_t>(std::max(wanted, 1.0));
        const glm::vec3 eye(1.75f, 1.72f, 2.75f);
        Scene scene;
        scene.counted_primitives = count;
        scene.description = fmt::format("a garden in {} Gaussian splats", count);
        scene.camera = look_at(eye, {-0.1f, 0.82f, 0}, 46, aspect_, 1.3, 0.2f, 200);
        scene.light = light_camera(light_direction(), glm::vec3(0), 95);
        scene.transparent = splat_draws("splats", grow(count), eye);
        return scene;
    }

 private:
    SplatFile grow(std::uint32_t count) const {
        const std::vector<GardenSplat> garden = sample(count);
        LightVolume volume(kShadowLow, kShadowHigh);
        // Shadows are those of the base amount, whatever the count: the look does not depend on it.
        const float share = static_cast<float>(kBaseSplats) / static_cast<float>(count);
        for (const GardenSplat& s : garden)
            volume.deposit(s.position,
                           share * 0.5f * glm::two_pi<float>() * s.opacity * s.spread.x * s.spread.y);
        volume.illuminate(light_direction());
        SplatFile splats;
        splats.degree = 1;
        splats.positions.resize(count);
        splats.scales.resize(count);
        splats.rotations.resize(count);
        splats.opacities.resize(count);
        splats.harmonics.resize(std::size_t{4} * count);
        // Training leaves splats in no order that space knows.
        const std::vector<std::uint32_t> order = shuffled_order(count, seed_);
        in_batches(count, [&](std::uint32_t i) { finish(garden[order[i]], volume, splats, i); });
        return splats;
    }

    template <typename Work>
    static void in_batches(std::uint32_t count, const Work& work) {
        const auto batches = static_cast<int>((count + kBatch - 1) / kBatch);
        parallel_for(default_threads(), batches, [&](int batch) {
            const std::uint32_t first = static_cast<std::uint32_t>(batch) * kBatch;
            for (std::uint32_t i = first; i < std::min(first + kBatch, count); ++i) work(i);
        });
    }

    std::vector<GardenSplat> sample(std::uint32_t count) const {
        std::vector<GardenPart> parts = garden_surfaces();
        const std::vector<GardenPart> plants = garden_plants();
        parts.insert(parts.end(), plants.begin(), plants.end());
        std::vector<std::uint32_t> starts;  // of each part's splats
        double before = 0;
        for (const GardenPart& part : parts) {
            starts.push_back(static_cast<std::uint32_t>(std::lround(before * count)));
            before += part.share;
        }
        CHECK(std::fabs(before - 1) < 1e-9, "shares sum to {}", before);
        starts.push_back(count);
        std::vector<GardenSplat> garden(count);
        in_batches(count, [&](std::uint32_t i) {
            const auto next = std::upper_bound(starts.begin(), starts.end(), i);
            const auto part = static_cast<std::size_t>(next - starts.begin()) - 1;
            const std::uint64_t key = mix64(seed_ ^ (0x47617264ull << 32) ^ i);
            const auto usual = static_cast<std::uint32_t>(parts[part].share * kBaseSplats);
            garden[i] = parts[part].sample(key, i - starts[part], usual, seed_);
        });
        return garden;
    }

    static void finish(const GardenSplat& s, const LightVolume& volume, SplatFile& splats, std::uint32_t i) {
        const glm::vec3 to_light = light_direction();
        splats.positions[i] = s.position;
        const float thin = s.thickness * std::min(s.spread.x, s.spread.y);
        splats.scales[i] = {s.spread.x, s.spread.y, thin};
        const glm::vec3 side = glm::cross(s.normal, s.tangent);
        splats.rotations[i] = glm::normalize(glm::quat_cast(glm::mat3(s.tangent, side, s.normal)));
        splats.opacities[i] = s.opacity;
        glm::vec3 color = s.albedo;
        float sun = 0;
        if (s.occlusion >= 0) {
            const bool near = glm::all(glm::greaterThan(s.position, kShadowLow)) &&
                              glm::all(glm::lessThan(s.position, kShadowHigh));
            const float open =
                (1 - s.occlusion) *
                (near ? volume.transmittance(s.position + kShadowCell * to_light, 1.0f) : 1.0f);
            const float facing = glm::dot(s.normal, to_light);
            const float through = s.translucence * std::fabs(facing) + s.translucence * 0.4f;
            sun = open * std::min((1 - 0.5f * s.translucence) * std::max(facing, 0.0f) + through, 1.0f);
            const float sky = (1 - 0.8f * s.occlusion) * (0.6f + 0.4f * s.normal.y) * (0.4f + 0.6f * open);
            color *= sun * glm::vec3(2.3f, 2.1f, 1.75f) + sky * glm::vec3(0.36f, 0.44f, 0.56f);
        }
        glm::vec3* harmonics = &splats.harmonics[std::size_t{4} * i];
        harmonics[0] = (display(glm::min(color, glm::vec3(1.4f))) - 0.5f) / 0.28209479f;
        // A linear lobe about the mirror image of the sun; seen from there, the direction is its opposite.
        const glm::vec3 mirror = glm::reflect(-to_light, s.normal);
        const glm::vec3 lobe = s.gloss * (0.3f + 0.7f * std::min(sun, 1.0f)) / 0.48860251f * mirror;
        harmonics[1] = glm::vec3(lobe.y);
        harmonics[2] = glm::vec3(-lobe.z);
        harmonics[3] = glm::vec3(lobe.x);
    }

    double aspect_;
    std::uint64_t seed_;
};

}  // namespace

std::unique_ptr<SceneSource> make_splats_scene(double aspect, std::uint64_t seed) {
    return std::make_unique<SplatsScene>(aspect, seed);
}

}  // namespace ropsim
