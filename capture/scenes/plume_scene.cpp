// Scene: a plume of smoke from a chimney, soft billboards in random order.
#include "base/error.h"
#include "base/parallel.h"
#include "base/random.h"
#include "capture/light_volume.h"
#include "capture/scene_list.h"
#include "capture/scene_parts.h"
#include "capture/shader_sources.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

constexpr double kBaseParticles = 100000;
constexpr double kMaxParticles = 4e6;  // what fits into a GPU buffer of 128 MiB
constexpr std::uint32_t kPuffs = 900;  // billows that the particles gather in
constexpr float kAlpha = 0.11f;
constexpr int kTextureSize = 64;
constexpr float kHeight = 6.6f;                 // of the plume, metres
constexpr glm::vec3 kMouth{-1.5f, 1.3f, 0.0f};  // of the chimney

struct Particle {
    glm::vec3 position;
    float radius;
    float alpha;
};

// A smooth vector field of a few seeded waves, each octave finer and weaker; divergence-free, about 1 in
// size.
class Turbulence {
 public:
    explicit Turbulence(std::uint64_t seed) {
        for (int i = 0; i < kWaves; ++i) {
            const std::uint64_t key = mix64(seed ^ (0x57617665ull << 32) ^ static_cast<std::uint64_t>(i));
            const auto direction = [&](std::uint32_t draw) {
                return glm::normalize(glm::vec3(random_unit(key, draw), random_unit(key, draw + 1),
                                                random_unit(key, draw + 2)) *
                                          2.0f -
                                      1.0f + 1e-3f);
            };
            const int octave = i / kWavesAnOctave;
            waves_[i].number = direction(0) * (1.1f * std::exp2(static_cast<float>(octave)));
            // Across the direction of travel, so nothing is compressed.
            waves_[i].push = glm::normalize(glm::cross(waves_[i].number, direction(3))) *
                             (0.55f * std::exp2(-0.75f * static_cast<float>(octave)));
            waves_[i].phase = glm::two_pi<float>() * random_unit(key, 6);
        }
    }

    glm::vec3 operator()(glm::vec3 position) const {
        glm::vec3 sum(0);
        for (const Wave& wave : waves_)
            sum += wave.push * std::sin(glm::dot(wave.number, position) + wave.phase);
        return sum;
    }

 private:
    static constexpr int kWavesAnOctave = 6;
    static constexpr int kWaves = 4 * kWavesAnOctave;
    struct Wave {
        glm::vec3 number;
        glm::vec3 push;
        float phase;
    };
    Wave waves_[kWaves];
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
    // Thins out while it mixes with the air.
    particle.alpha =
        kAlpha * (1.1f - 0.3f * puff.age) * (1.0f - glm::smoothstep(0.75f, 1.0f, puff.age) * 0.75f);
    return particle;
}

// Smooth repeating noise in [0, 1]: two octaves of seeded lattice values.
SceneTexture noise_texture(std::uint64_t seed) {
    SceneTexture texture;
    texture.width = texture.height = kTextureSize;
    const auto lattice = [&](int cells, int x, int y) {
        const auto index = static_cast<std::uint32_t>((y % cells) * cells + x % cells);
        return random_unit(mix64(seed ^ (0x54657874ull << 32) ^ static_cast<std::uint64_t>(cells)), index);
    };
    for (int y = 0; y < kTextureSize; ++y) {
        for (int x = 0; x < kTextureSize; ++x) {
            float sum = 0;
            for (int cells : {8, 16}) {
                const int side = kTextureSize / cells;
                const float u =
                    glm::smoothstep(0.0f, 1.0f, static_cast<float>(x % side) / static_cast<float>(side));
                const float v =
                    glm::smoothstep(0.0f, 1.0f, static_cast<float>(y % side) / static_cast<float>(side));
                const int i = x / side;
                const int j = y / side;
                sum +=
                    0.5f * glm::mix(glm::mix(lattice(cells, i, j), lattice(cells, i + 1, j), u),
                                    glm::mix(lattice(cells, i, j + 1), lattice(cells, i + 1, j + 1), u), v);
            }
            texture.values.push_back(sum);
        }
    }
    return texture;
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
        scene.description = fmt::format("a plume of smoke, {} particles", count);
        scene.camera = look_at({0.6f, 1.9f, 10.0f}, {0.45f, 3.1f, 0}, 39, aspect_, 1.4, 1.0f, 60);
        scene.light = light_camera(light_direction(), glm::vec3(1.0f, 4.0f, 0.0f), 5.5f);
        scene.background = {0.2f, 0.36f, 0.62f};
        const TriangleMesh box = box_mesh();
        scene.opaque.push_back(
            matte_draw("ground", box,
                       {{placed({0, -0.1f, -12}, {40, 0.1f, 20}), {0.2f, 0.26f, 0.12f, 1.0f}},
                        {placed({-1.5f, 0.6f, 0}, {0.2f, 0.68f, 0.2f}), {0.5f, 0.2f, 0.13f, 0.0f}},
                        {placed({-1.5f, 1.24f, 0}, {0.25f, 0.07f, 0.25f}), {0.42f, 0.17f, 0.11f, 0.0f}},
                        {placed({-2.5f, 0.4f, -0.3f}, {1.1f, 0.5f, 0.8f}), {0.6f, 0.56f, 0.48f, 0.0f}}}));
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
            volume.deposit(p.position, share * p.alpha * p.radius * p.radius * 1.6f);
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
                                 {p.position.x, p.position.y, p.position.z, p.radius, light, p.alpha,
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
