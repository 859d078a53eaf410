// What the parts of the garden share: noise, even sampling, the sizes and opacities of splats.
#include "base/random.h"
#include "capture/scenes/garden.h"

#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

constexpr float kTau = glm::two_pi<float>();

}  // namespace

float garden_lattice(glm::ivec3 cell) {
    const auto key = mix64(static_cast<std::uint64_t>(static_cast<std::uint32_t>(cell.x)) ^
                           mix64(static_cast<std::uint64_t>(static_cast<std::uint32_t>(cell.y)) ^
                                 mix64(static_cast<std::uint32_t>(cell.z))));
    return static_cast<float>(key >> 40) * 0x1p-24f;
}

float garden_noise(glm::vec3 at) {
    const glm::vec3 cell = glm::floor(at);
    const glm::ivec3 i(cell);
    const glm::vec3 f = at - cell;
    const glm::vec3 s = f * f * (3.0f - 2.0f * f);
    float sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 step(corner & 1, (corner >> 1) & 1, corner >> 2);
        const glm::vec3 weight = glm::mix(1.0f - s, s, glm::vec3(step));
        sum += weight.x * weight.y * weight.z * garden_lattice(i + step);
    }
    return sum;
}

glm::vec2 even_point(std::uint32_t index) {
    const double x = 0.5 + 0.7548776662466927 * index;
    const double y = 0.5 + 0.5698402909980532 * index;
    return {static_cast<float>(x - std::floor(x)), static_cast<float>(y - std::floor(y))};
}

glm::vec3 random_direction(std::uint64_t key, std::uint32_t draw) {
    const float y = 2 * random_unit(key, draw) - 1;
    const float angle = kTau * random_unit(key, draw + 1);
    const float out = std::sqrt(1 - y * y);
    return {out * std::cos(angle), y, out * std::sin(angle)};
}

float random_normal(std::uint64_t key, std::uint32_t draw) {
    const float radius = std::sqrt(-2 * std::log(1 - random_unit(key, draw)));
    return radius * std::cos(kTau * random_unit(key, draw + 1));
}

glm::vec3 across(glm::vec3 normal) {
    const glm::vec3 other = std::fabs(normal.y) < 0.9f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0);
    return glm::normalize(glm::cross(normal, other));
}

void dress_surface(GardenSplat& splat, std::uint64_t key, float spacing) {
    const float size = 0.6f * spacing * std::exp(0.3f * random_normal(key, 40));
    const float stretch = std::exp(0.35f * random_normal(key, 42));
    const bool faint = random_unit(key, 44) < 0.07f;
    splat.spread = glm::vec2(size * stretch, size / stretch) * (faint ? 1.9f : 1.0f);
    const float u = random_unit(key, 45);
    splat.opacity = faint ? 0.05f + 0.25f * u : (u < 0.3f ? 0.3f + 2 * u : 0.9f + 0.09f * u);
    const glm::vec3 first = across(splat.normal);
    const float turn = kTau * random_unit(key, 46);
    splat.tangent = std::cos(turn) * first + std::sin(turn) * glm::cross(splat.normal, first);
}

void dress_leaf(GardenSplat& splat, std::uint64_t key, float size) {
    const float scale = size * std::exp(0.3f * random_normal(key, 40));
    splat.spread = {scale * 1.4f, scale * 0.75f};
    splat.opacity = random_unit(key, 42) < 0.3f ? 0.15f + 0.6f * random_unit(key, 43)
                                                : 0.88f + 0.11f * random_unit(key, 43);
    splat.tangent = across(splat.normal);
    const float turn = kTau * random_unit(key, 44);
    splat.tangent = std::cos(turn) * splat.tangent + std::sin(turn) * glm::cross(splat.normal, splat.tangent);
    splat.translucence = 0.35f;
}

}  // namespace ropsim
