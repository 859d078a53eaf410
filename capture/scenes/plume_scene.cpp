// Scene: a plume of smoke from a chimney, soft billboards in random order.
#include "base/error.h"
#include "base/parallel.h"
#include "base/random.h"
#include "capture/geometry/swept_mesh.h"
#include "capture/geometry/turbulence.h"
#include "capture/scene_list.h"
#include "capture/scenery/light_volume.h"
#include "capture/scenery/noise_texture.h"
#include "capture/scenery/scene_parts.h"
#include "capture/shader_sources.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

constexpr double kBaseParticles = 100000;
constexpr double kMaxParticles = 4e6;  // what fits into a GPU buffer of 128 MiB
constexpr std::uint32_t kPuffs = 900;  // billows that the particles gather in
constexpr float kAlpha =
    0.1f;  // at a billboard's densest; its mean is half, the .05 of Laine and Karras 2011, Fig. 8
constexpr float kHeight = 6.6f;                 // of the plume, metres
constexpr glm::vec3 kMouth{-1.5f, 1.3f, 0.0f};  // of the chimney

struct Particle {
    glm::vec3 position;
    float radius;
};

// Axis and radius of the plume at `age` from 0 (the mouth) to 1: it rises, slows down, and leans with the
// wind.
glm::vec3 axis_at(float age) {
    return kMouth +
           glm::vec3(3.6f * age * age + 0.5f * age, kHeight * 0.62f * std::pow(age, 0.8f), -0.6f * age * age);
}
float radius_at(float age) {
    return 0.16f + 1.05f * std::pow(age, 0.85f);
}

struct Puff {
    glm::vec3 centre;
    float radius;
    float age;
};

Puff make_puff(std::uint64_t seed, std::uint32_t index, const Turbulence& turbulence) {
    const std::uint64_t key = mix64(seed ^ (0x50756666ull << 32) ^ index);
    Puff puff;
    puff.age = std::pow(random_unit(key, 0), 0.8f);
    const float radius = radius_at(puff.age);
    const float angle = glm::two_pi<float>() * random_unit(key, 1);
    // Vortex rings: billows sit towards the rim rather than on the axis.
    const float out = radius * (0.35f + 0.5f * std::sqrt(random_unit(key, 2)));
    puff.centre =
        axis_at(puff.age) +
        glm::vec3(out * std::cos(angle), 0.3f * radius * (random_unit(key, 3) - 0.5f), out * std::sin(angle));
    puff.centre += 0.55f * radius * turbulence(puff.centre * 0.8f);
    puff.radius = radius * (0.22f + 0.3f * random_unit(key, 4));
    return puff;
}

Particle make_particle(std::uint64_t seed, std::uint32_t index, const std::vector<Puff>& puffs,
                       const Turbulence& turbulence) {
    const std::uint64_t key = mix64(seed ^ (0x536D6F6Bull << 32) ^ index);
    const Puff& puff = puffs[static_cast<std::size_t>(random_unit(key, 0) * static_cast<float>(kPuffs))];
    const float y = 2 * random_unit(key, 1) - 1;
    const float phi = glm::two_pi<float>() * random_unit(key, 2);
    const float r = std::sqrt(std::max(0.0f, 1 - y * y));
    const float distance = puff.radius * std::sqrt(random_unit(key, 3));
    Particle particle;
    particle.position = puff.centre + distance * glm::vec3(r * std::cos(phi), y, r * std::sin(phi));
    particle.position += 0.32f * radius_at(puff.age) * turbulence(particle.position * 2.1f);
    particle.radius = (0.016f + 0.056f * puff.age) * (0.7f + 0.6f * random_unit(key, 4));
    return particle;
}

// The house with the chimney, its garden, fields and hills.
std::vector<SceneDraw> village(std::uint64_t seed) {
    const glm::vec4 plaster(0.62f, 0.57f, 0.48f, 0);
    const glm::vec4 brick(0.42f, 0.16f, 0.1f, 0);
    const glm::vec4 tile(0.3f, 0.11f, 0.07f, 0);
    const glm::vec4 frame(0.75f, 0.73f, 0.68f, 0);
    const glm::vec4 glass(0.05f, 0.07f, 0.1f, 0);
    std::vector<MeshInstance> boxes = {
        {placed({0, -0.1f, -20}, {60, 0.1f, 32}), {0.13f, 0.2f, 0.06f, 0}},
        {placed({-2.6f, 0.45f, -0.2f}, {1.3f, 0.45f, 0.7f}), plaster},
        {placed({-2.6f, 0.05f, -0.2f}, {1.32f, 0.05f, 0.72f}), {0.3f, 0.28f, 0.26f, 0}},
        {placed({-1.5f, 0.85f, 0}, {0.13f, 0.42f, 0.13f}), brick},
        {placed({-1.5f, 1.22f, 0}, {0.17f, 0.04f, 0.17f}), tile},
        {placed({-2.75f, 0.3f, 0.5f}, {0.14f, 0.3f, 0.02f}), {0.1f, 0.2f, 0.16f, 0}}};
    for (const float x : {-3.5f, -3.1f, -2.3f, -1.75f}) {
        boxes.push_back({placed({x, 0.52f, 0.5f}, {0.14f, 0.18f, 0.02f}), frame});
        for (const float side : {-1.0f, 1.0f})
            boxes.push_back({placed({x + 0.063f * side, 0.52f, 0.505f}, {0.05f, 0.155f, 0.02f}), glass});
    }
    // Fields, each of its own crop, and hedges between them.
    for (int i = 0; i < 9; ++i) {
        const std::uint64_t key = mix64(seed ^ (0x46696C64ull << 32) ^ static_cast<std::uint64_t>(i));
        const float x = -24.0f + 6.0f * static_cast<float>(i);
        const glm::vec3 crop =
            glm::mix(glm::vec3(0.1f, 0.19f, 0.05f), glm::vec3(0.36f, 0.31f, 0.12f), random_unit(key, 0));
        const float z = -9.0f - 6.0f * random_unit(key, 1);
        boxes.push_back({placed({x, 0.005f, z - 5.0f}, {2.9f, 0.01f, 5.0f}), glm::vec4(crop, 0)});
        boxes.push_back({placed({x, 0.14f, z}, {2.9f, 0.14f, 0.12f}), {0.05f, 0.1f, 0.03f, 0}});
    }
    std::vector<MeshInstance> balls;
    for (int i = 0; i < 26; ++i) {
        const std::uint64_t key = mix64(seed ^ (0x54726565ull << 32) ^ static_cast<std::uint64_t>(i));
        const glm::vec3 foot(-17.0f + 34.0f * random_unit(key, 0), 0, -4.0f - 16.0f * random_unit(key, 1));
        const float tall = 1.3f + 1.1f * random_unit(key, 2);
        boxes.push_back({placed(foot + glm::vec3(0, 0.25f * tall, 0), {0.06f, 0.25f * tall, 0.06f}),
                         {0.14f, 0.09f, 0.06f, 0}});
        for (std::uint32_t k = 0; k < 9; ++k) {
            const glm::vec3 out = glm::vec3(random_unit(key, 4 * k + 3), random_unit(key, 4 * k + 4),
                                            random_unit(key, 4 * k + 5)) -
                                  0.5f;
            const float tone = 0.7f + 0.5f * random_unit(key, 4 * k + 6);
            balls.push_back(
                {placed(foot + tall * (glm::vec3(0, 0.68f, 0) + 0.42f * out), glm::vec3(0.2f * tall)),
                 glm::vec4(tone * glm::vec3(0.06f, 0.13f, 0.035f), 0)});
        }
    }
    // Hills, paler with the distance.
    for (int i = 0; i < 5; ++i) {
        const float along = static_cast<float>(i);
        balls.push_back({placed({-30.0f + 15.0f * along, -1.0f, -40.0f + 2.0f * static_cast<float>(i % 2)},
                                {16, 3.4f + static_cast<float>(i * 2 % 3), 5}),
                         {0.15f, 0.24f, 0.22f, 0}});
    }
    SceneDraw roof = matte_draw("roof", extruded_mesh({{-0.85f, 0}, {0.85f, 0}, {0, 0.42f}}, 1.42f, 20),
                                {{placed({-2.6f, 0.87f, -0.2f}, glm::vec3(1), glm::half_pi<float>()), tile}});
    return {matte_draw("ground", box_mesh(), boxes), matte_draw("foliage", sphere_mesh(14), balls),
            std::move(roof)};
}

class PlumeScene final : public SceneSource {
 public:
    PlumeScene(double aspect, std::uint64_t seed) : aspect_(aspect), seed_(seed) {}

    Scene build(const SceneScale& scale) const override {
        const double wanted = std::round(kBaseParticles * scale.count);
        if (wanted > kMaxParticles) {
            throw UserError("--fragments",
                            fmt::format("the plume would need {:.0f} particles, more than {:.0f}; ask "
                                        "for fewer fragments or use a larger --size",
                                        wanted, kMaxParticles));
        }
        const auto count = static_cast<std::uint32_t>(std::max(wanted, 1.0));
        Scene scene;
        scene.counted_primitives = count;
        scene.description = fmt::format("a plume of smoke, {} particles", count);
        scene.camera = look_at({0.6f, 1.9f, 10.0f}, {0.45f, 3.2f, 0}, 43, aspect_, 1.4, 1.0f, 60);
        scene.light = light_camera(light_direction(), glm::vec3(1.0f, 4.0f, 0.0f), 5.5f);
        scene.background = {0.24f, 0.4f, 0.66f};
        scene.opaque = village(seed_);
        scene.transparent.push_back(smoke_draw(count));
        return scene;
    }

 private:
    SceneDraw smoke_draw(std::uint32_t count) const {
        const std::vector<Particle> particles = make_particles(count);
        LightVolume volume(glm::vec3(-3.2f, 0.5f, -3.2f), glm::vec3(5.2f, 8.0f, 2.8f));
        // Shadows are those of the base amount of smoke, whatever the count: the look does not depend on it.
        const float share = static_cast<float>(kBaseParticles) / static_cast<float>(count);
        for (const Particle& p : particles)
            volume.deposit(p.position, share * kAlpha * p.radius * p.radius * 1.6f);
        volume.illuminate(light_direction());
        SceneDraw draw;
        draw.state.name = "smoke";
        draw.vertex = shader_source("plume_vertex");
        draw.shading = shader_source("plume_shading");
        draw.primitives = 2 * count;
        draw.textures.push_back(noise_texture(seed_));
        SceneBuffer buffer{1, {}};
        buffer.values.reserve(std::size_t{8} * count);
        for (std::uint32_t i = 0; i < count; ++i) {
            const Particle& p = particles[i];
            const std::uint64_t key = mix64(seed_ ^ (0x4C6F6F6Bull << 32) ^ i);
            const float light = volume.transmittance(p.position, 1.0f);
            buffer.values.insert(buffer.values.end(),
                                 {p.position.x, p.position.y, p.position.z, p.radius, light, kAlpha,
                                  random_unit(key, 0), random_unit(key, 1)});
        }
        draw.buffers = {std::move(buffer)};
        draw.parameters = {glm::vec4(0.95f, 0.88f, 0.76f, 0), glm::vec4(0.12f, 0.15f, 0.2f, 0)};
        return draw;
    }

    std::vector<Particle> make_particles(std::uint32_t count) const {
        const Turbulence turbulence(seed_);
        std::vector<Puff> puffs;
        for (std::uint32_t i = 0; i < kPuffs; ++i) puffs.push_back(make_puff(seed_, i, turbulence));
        std::vector<Particle> particles(count);
        constexpr std::uint32_t kBatch = 4096;
        const auto batches = static_cast<int>((count + kBatch - 1) / kBatch);
        parallel_for(default_threads(), batches, [&](int batch) {
            const std::uint32_t first = static_cast<std::uint32_t>(batch) * kBatch;
            for (std::uint32_t i = first; i < std::min(first + kBatch, count); ++i) {
                particles[i] = make_particle(seed_, i, puffs, turbulence);
            }
        });
        return particles;
    }

    double aspect_;
    std::uint64_t seed_;
};

}  // namespace

std::unique_ptr<SceneSource> make_plume_scene(double aspect, std::uint64_t seed) {
    return std::make_unique<PlumeScene>(aspect, seed);
}

}  // namespace ropsim
