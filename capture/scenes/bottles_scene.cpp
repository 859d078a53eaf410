// Scene: four coloured plastic bottles on a table in a courtyard (McGuire and Mara 2017, Fig. 12).
//
// Materials as the paper has them: coverage 1, transmission per channel, index 1 (the paper's plastic does
// not refract), collimation 1; colour is what the glossy surface mirrors and a little light from inside the
// plastic. The trace's alpha is the least that says the same (transmissive() in
// capture/shaders/surface.glsl).
#include "base/error.h"
#include "base/random.h"
#include "capture/geometry/lathe_mesh.h"
#include "capture/geometry/profile.h"
#include "capture/scene_list.h"
#include "capture/scenery/table_light.h"
#include "capture/scenery/transmissive_draw.h"
#include "capture/shader_sources.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

constexpr double kMaxBottles = 2e6;
constexpr float kWall = 0.0012f;   // metres
constexpr float kHeight = 0.236f;  // to the mouth
constexpr float kRadius = 0.037f;  // of the body
constexpr float kLabelLow = 0.062f;
constexpr float kLabelHigh = 0.107f;
const glm::vec3 to_sun = glm::normalize(glm::vec3(0.5f, 0.8f, -0.12f));

constexpr glm::vec3 kPlastics[] = {
    {0.93f, 0.36f, 0.2f}, {0.3f, 0.8f, 0.36f}, {0.26f, 0.52f, 0.93f}, {0.95f, 0.8f, 0.25f}};

// Outer wall from the middle of the foot to the mouth; `inset` moves it inwards, for the inner wall.
std::vector<glm::vec2> wall(float inset) {
    const auto smooth = [&](std::vector<glm::vec2> points, int steps) {
        for (glm::vec2& p : points) p.x = std::max(p.x - inset, 0.0f);
        return smooth_profile(points, steps);
    };
    std::vector<glm::vec2> all = smooth({{0.0f, 0.012f + inset},
                                         {0.016f, 0.009f + inset},
                                         {0.027f, 0.001f + inset},
                                         {0.0345f, 0.004f + inset},
                                         {kRadius, 0.014f}},
                                        5);
    const auto add = [&](const std::vector<glm::vec2>& more) {
        all.insert(all.end(), more.begin() + 1, more.end());
    };
    // A waist under the label, ribs above it, the shoulder, the neck with its ring.
    add(smooth({{kRadius, 0.014f},
                {kRadius, 0.036f},
                {kRadius - 0.0025f, 0.046f},
                {kRadius, 0.055f},
                {kRadius, 0.061f},
                {kRadius, 0.112f}},
               5));
    for (int rib = 0; rib < 3; ++rib) {
        const float y = 0.112f + 0.011f * static_cast<float>(rib);
        add(smooth({{kRadius, y}, {kRadius - 0.0022f, y + 0.0055f}, {kRadius, y + 0.011f}}, 4));
    }
    add(smooth({{kRadius, 0.145f},
                {0.0355f, 0.158f},
                {0.028f, 0.18f},
                {0.0185f, 0.2f},
                {0.0136f, 0.212f},
                {0.013f, 0.218f}},
               6));
    if (inset == 0) add({{0.013f, 0.218f}, {0.0168f, 0.2185f}, {0.0168f, 0.221f}, {0.013f, 0.2215f}});
    all.emplace_back(0.013f - inset, kHeight);
    return all;
}

// Both walls and the rim between them.
TriangleMesh bottle_mesh() {
    std::vector<glm::vec2> profile = wall(0);
    const std::vector<glm::vec2> inner = wall(kWall);
    profile.insert(profile.end(), inner.rbegin(), inner.rend());
    return lathe_mesh(profile, 56);
}

// Of the body at a height, for its shadow.
float bottle_radius(float height) {
    if (height > kHeight) return 0;
    if (height < 0.15f) return kRadius;
    return std::max(0.013f, glm::mix(kRadius, 0.013f, (height - 0.15f) / 0.06f));
}

struct Bottle {
    glm::vec3 place;
    glm::vec3 plastic;
    float size;
};

std::vector<Bottle> bottles(std::uint64_t seed, std::size_t count) {
    std::vector<Bottle> all = {{{-0.066f, 0, -0.05f}, kPlastics[1], 1.06f},
                               {{0.016f, 0, -0.09f}, kPlastics[2], 1.12f},
                               {{0.066f, 0, -0.012f}, kPlastics[3], 0.97f},
                               {{-0.016f, 0, 0.034f}, kPlastics[0], 0.93f}};
    for (std::size_t i = all.size(); i < count; ++i) {
        const std::uint64_t key = mix64(seed * 0x9E3779B97F4A7C15ull + i);
        all.push_back({{0.42f * (random_unit(key, 0) - 0.5f), 0, 0.3f * (random_unit(key, 1) - 0.65f)},
                       kPlastics[random_bits(key, 2) % 4],
                       0.9f + 0.25f * random_unit(key, 3)});
    }
    return all;
}

class BottlesScene final : public SceneSource {
 public:
    BottlesScene(double aspect, std::uint64_t seed) : aspect_(aspect), seed_(seed), bottle_(bottle_mesh()) {
        shrinks = true;
    }

    Scene build(const SceneScale& scale) const override {
        if (4 * scale.count > kMaxBottles) {
            throw UserError(
                "--fragments",
                fmt::format("'bottles' would need {:.0f} bottles, more than {:.0f}; ask for fewer "
                            "fragments or use a larger --size",
                            4 * scale.count, kMaxBottles));
        }
        const auto count = static_cast<std::size_t>(std::max(4.0, std::round(4 * scale.count)));
        const std::vector<Bottle> all = bottles(seed_, count);
        const glm::mat4 sized = glm::scale(glm::mat4(1.0f), glm::vec3(static_cast<float>(scale.size)));
        Scene scene;
        scene.description = fmt::format("{} coloured plastic bottles on a table in a courtyard", count);
        scene.materials = true;
        scene.camera = look_at({0.0f, 0.2f, 0.48f}, {0.0f, 0.115f, -0.03f}, 33, aspect_, 1.2, 0.1f, 60);
        scene.light = light_camera(to_sun, {0, 0.11f, 0}, 0.3f);
        scene.background = {0.6f, 0.7f, 0.8f};
        std::vector<MeshInstance> walls;
        std::vector<MeshInstance> caps;
        std::vector<MeshInstance> labels;
        for (const Bottle& bottle : all) {
            const glm::mat4 model = sized * placed(bottle.place, glm::vec3(bottle.size));
            walls.push_back({model, glm::vec4(bottle.plastic, 1)});
            // Thousands of opaque labels would hide what the further bottles are for.
            if (caps.size() == 4) continue;
            caps.push_back({model, glm::vec4(0.35f * bottle.plastic * bottle.plastic, 0)});
            labels.push_back({model, glm::vec4(0.3f * bottle.plastic, 2)});
        }
        add_opaque(scene, all, caps, labels);
        GlassLook look;
        look.environment = "courtyard_environment";
        look.to_sun = to_sun;
        look.sun = glm::vec3(160, 140, 110);
        look.eta = 1;
        look.reflectance = 0.05f;
        look.inner_reflections = 0.14f;
        look.gloss = 260;
        scene.transparent.push_back(transmissive_draw("bottles", bottle_, walls, look));
        return scene;
    }

 private:
    static void add_opaque(Scene& scene, const std::vector<Bottle>& all,
                           const std::vector<MeshInstance>& caps, const std::vector<MeshInstance>& labels) {
        TableLight light({-0.5f, -0.45f}, 0.9f, to_sun);
        for (std::size_t i = 0; i < caps.size(); ++i) {
            const Bottle& bottle = all[i];
            light.shadow({{bottle.place.x, bottle.place.z},
                          bottle.size * kHeight,
                          [&](float height) { return bottle.size * bottle_radius(height / bottle.size); },
                          bottle.plastic});
        }
        const TriangleMesh cap = lathe_mesh(
            {{0.0f, 0.222f}, {0.0162f, 0.222f}, {0.0162f, 0.2375f}, {0.0152f, 0.239f}, {0.0f, 0.239f}}, 48);
        const TriangleMesh label =
            lathe_mesh({{kRadius + 0.0005f, kLabelLow}, {kRadius + 0.0005f, kLabelHigh}}, 56);
        const auto add = [&](const char* name, const TriangleMesh& mesh,
                             const std::vector<MeshInstance>& copies) {
            SceneDraw draw = matte_draw(name, mesh, copies);
            draw.shading = std::string(shader_source("courtyard_environment")) +
                           std::string(shader_source("courtyard_shading"));
            draw.parameters = {glm::vec4(to_sun, 0), light.rectangle()};
            draw.textures.push_back(light.texture());
            scene.opaque.push_back(std::move(draw));
        };
        add("courtyard", box_mesh(), {{placed({0, 0, 0}, glm::vec3(25)), {1, 1, 1, 3}}});
        add("table", box_mesh(),
            {{placed({0, -0.02f, 0.05f}, {0.75f, 0.02f, 0.4f}), {0.34f, 0.2f, 0.11f, 1}}});
        add("caps", cap, caps);
        add("labels", label, labels);
    }

    double aspect_;
    std::uint64_t seed_;
    TriangleMesh bottle_;
};

}  // namespace

std::unique_ptr<SceneSource> make_bottles_scene(double aspect, std::uint64_t seed) {
    return std::make_unique<BottlesScene>(aspect, seed);
}

}  // namespace ropsim
