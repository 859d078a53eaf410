// Puffs about clumps about a bent axis.
#include "capture/scenery/smoke_column.h"

#include "base/parallel.h"
#include "base/random.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

constexpr int kPuffTexels = 128;

glm::vec3 random_direction(std::uint64_t key, std::uint32_t draw) {
    const float y = 2 * random_unit(key, draw) - 1;
    const float phi = glm::two_pi<float>() * random_unit(key, draw + 1);
    const float r = std::sqrt(std::max(0.0f, 1 - y * y));
    return {r * std::cos(phi), y, r * std::sin(phi)};
}

struct Billow {
    glm::vec3 centre;
    float radius;
    float age;
};

Billow make_billow(const SmokeColumn& column, const Turbulence& turbulence, std::uint64_t seed, int index) {
    const std::uint64_t key = mix64(seed ^ (0x42696Cull << 32) ^ static_cast<std::uint64_t>(index));
    Billow billow;
    billow.age =
        std::pow((static_cast<float>(index) + random_unit(key, 0)) / static_cast<float>(column.billows),
                 column.crowding);
    const float sideways = std::pow(billow.age, column.bend);
    const glm::vec3 axis = column.source + column.drift * glm::vec3(sideways, billow.age, sideways);
    const float radius = glm::mix(column.from_radius, column.to_radius, std::pow(billow.age, 0.8f));
    const float angle = glm::two_pi<float>() * random_unit(key, 1);
    const float out = radius * 0.75f * std::sqrt(random_unit(key, 2));
    billow.centre = axis + glm::vec3(out * std::cos(angle), 0.4f * radius * (random_unit(key, 3) - 0.5f),
                                     out * std::sin(angle));
    billow.centre += 0.35f * radius * turbulence(billow.centre * 0.7f);
    billow.radius = radius * (0.3f + 0.3f * random_unit(key, 4));
    return billow;
}

Card make_puff(const SmokeColumn& column, const std::vector<Billow>& billows, const Turbulence& turbulence,
               glm::vec3 across, glm::vec3 up, std::uint64_t key) {
    const auto pick = static_cast<std::size_t>(random_unit(key, 0) * static_cast<float>(billows.size()));
    const Billow& billow = billows[pick];
    Card card{};
    card.centre = billow.centre + billow.radius * std::sqrt(random_unit(key, 1)) * random_direction(key, 2);
    card.centre += 0.25f * billow.radius * turbulence(card.centre * 1.9f);
    const float grown = glm::mix(0.75f, 1.35f, billow.age);
    const float radius = column.puff * grown * (0.7f + 0.6f * random_unit(key, 4));
    card.centre.y = std::max(card.centre.y, 0.55f * radius);
    const float angle = glm::two_pi<float>() * random_unit(key, 5);
    card.right = radius * (std::cos(angle) * across + std::sin(angle) * up);
    card.up = radius * (std::cos(angle) * up - std::sin(angle) * across);
    card.columns = random_unit(key, 6) < 0.5f ? -1.0f : 1.0f;
    card.rows = 1;
    // Thins out towards its end, and differs a little in colour.
    const float alpha = column.alpha * (1 - 0.8f * glm::smoothstep(0.55f, 1.0f, billow.age));
    card.color = glm::vec4(column.color * (0.85f + 0.3f * random_unit(key, 7)), alpha);
    return card;
}

}  // namespace

std::vector<Card> make_puffs(const SmokeColumn& column, std::uint32_t count, const Turbulence& turbulence,
                             glm::vec3 across, glm::vec3 up, std::uint64_t seed) {
    std::vector<Billow> billows;
    for (int i = 0; i < column.billows; ++i) billows.push_back(make_billow(column, turbulence, seed, i));
    std::vector<Card> puffs(count);
    constexpr std::uint32_t kBatch = 512;
    const auto batches = static_cast<int>((count + kBatch - 1) / kBatch);
    parallel_for(default_threads(), batches, [&](int batch) {
        const std::uint32_t first = static_cast<std::uint32_t>(batch) * kBatch;
        for (std::uint32_t i = first; i < std::min(first + kBatch, count); ++i) {
            const std::uint64_t key = mix64(seed ^ (0x50756666ull << 32) ^ i);
            puffs[i] = make_puff(column, billows, turbulence, across, up, key);
        }
    });
    return puffs;
}

void deposit_puffs(const std::vector<Card>& puffs, float share, LightVolume& volume) {
    for (const Card& puff : puffs) {
        const float radius = glm::length(puff.right);
        // Spread over its ball, or a cell would hold all of it.
        const float area = share * 0.22f * puff.color.a * glm::pi<float>() * radius * radius;
        for (const glm::vec3 off : {glm::vec3(0), glm::vec3(1, 0, 0), glm::vec3(-1, 0, 0), glm::vec3(0, 1, 0),
                                    glm::vec3(0, -1, 0), glm::vec3(0, 0, 1), glm::vec3(0, 0, -1)})
            volume.deposit(puff.centre + 0.5f * radius * off, area);
    }
}

SceneTexture puff_texture(std::uint64_t seed) {
    SceneTexture texture;
    texture.width = texture.height = kPuffTexels;
    texture.repeat = false;
    const Turbulence turbulence(seed ^ 0x50756666u);
    for (int y = 0; y < kPuffTexels; ++y) {
        for (int x = 0; x < kPuffTexels; ++x) {
            const glm::vec2 at =
                2.0f * (glm::vec2(static_cast<float>(x), static_cast<float>(y)) + 0.5f) / float{kPuffTexels} -
                1.0f;
            const float r = glm::length(at);
            // Billows: the folds of noise are sharp, its bumps round.
            const glm::vec3 noise = turbulence({4.0f * at.x, 4.0f * at.y, 3.0f});
            const float bumps = 1 - std::min(std::abs(noise.x) + 0.5f * std::abs(noise.y), 1.0f);
            const float edge = glm::smoothstep(0.0f, 0.75f, 1 - r - 0.28f * (1 - bumps) * r);
            texture.values.push_back(r < 0.98f ? edge * (0.45f + 0.55f * bumps) : 0.0f);
        }
    }
    return texture;
}

}  // namespace ropsim
