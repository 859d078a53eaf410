// The garden's built things: table, vase, patio, house; its ground and sky.
#include "base/random.h"
#include "capture/scenes/garden.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

constexpr float kTableRadius = 0.78f;
constexpr float kTableTop = 0.74f;
constexpr float kTau = glm::two_pi<float>();

// Distance to the nearest joint of a running bond of bricks, and a random tone of the brick.
struct Bond {
    float joint;
    float tone;
};
Bond bond_at(glm::vec2 at, glm::vec2 brick) {
    const float row = std::floor(at.y / brick.y);
    const float along = at.x / brick.x + 0.5f * std::fmod(std::fabs(row), 2.0f);
    const float u = along - std::floor(along);
    const float v = at.y / brick.y - row;
    return {std::min(std::min(u, 1 - u) * brick.x, std::min(v, 1 - v) * brick.y),
            garden_lattice({static_cast<int>(std::floor(along)), static_cast<int>(row), 7})};
}

glm::vec3 wood(glm::vec3 at, float tone) {
    const float grain = garden_noise({at.x * 5, at.y * 60, at.z * 70});
    return glm::mix(glm::vec3(0.16f, 0.085f, 0.045f), glm::vec3(0.42f, 0.27f, 0.16f),
                    std::clamp(0.2f + 0.5f * grain + 0.4f * tone, 0.0f, 1.0f));
}

GardenSplat table_top(std::uint64_t key, std::uint32_t index, std::uint32_t count, std::uint64_t) {
    const glm::vec2 uv = even_point(index);
    const bool rim = index % 8 == 0;
    const float angle = kTau * uv.y;
    const float radius = rim ? kTableRadius : kTableRadius * std::sqrt(uv.x);
    GardenSplat splat;
    splat.position = {radius * std::cos(angle), kTableTop, radius * std::sin(angle)};
    if (rim) {
        splat.position.y -= 0.035f * uv.x;
        splat.normal = {std::cos(angle), 0, std::sin(angle)};
    }
    // Slats along x.
    const float slat = splat.position.z / 0.092f;
    const float in_slat = slat - std::floor(slat);
    splat.albedo = wood(splat.position, garden_lattice({static_cast<int>(std::floor(slat)), 3, 1}));
    if (!rim && std::min(in_slat, 1 - in_slat) < 0.05f) {
        splat.albedo *= 0.12f;
        splat.position.y -= 0.01f;
    }
    splat.gloss = 0.12f;
    const float area = glm::pi<float>() * kTableRadius * kTableRadius;
    dress_surface(splat, key, std::sqrt(area / (0.875f * static_cast<float>(count))) * (rim ? 0.8f : 1.0f));
    return splat;
}

GardenSplat table_frame(std::uint64_t key, std::uint32_t index, std::uint32_t count, std::uint64_t) {
    const glm::vec2 uv = even_point(index);
    const auto bar = index % 6;  // four legs, two crossed struts
    const float angle = kTau * (0.125f + 0.25f * static_cast<float>(bar));
    const glm::vec3 out(std::cos(angle), 0, std::sin(angle));
    glm::vec3 from = 0.62f * out;
    glm::vec3 to = 0.42f * out + glm::vec3(0, kTableTop - 0.03f, 0);
    if (bar >= 4) {
        from = -0.55f * out + glm::vec3(0, 0.22f, 0);
        to = 0.55f * out + glm::vec3(0, 0.22f, 0);
    }
    const glm::vec3 axis = glm::normalize(to - from);
    const glm::vec3 side = glm::normalize(glm::cross(axis, out + glm::vec3(0.01f, 0.02f, 0)));
    const float turn = kTau * uv.y;
    GardenSplat splat;
    splat.normal = std::cos(turn) * side + std::sin(turn) * glm::cross(axis, side);
    splat.position = glm::mix(from, to, uv.x) + 0.026f * splat.normal;
    splat.tangent = axis;
    splat.albedo = wood(splat.position, 0.3f) * 0.8f;
    dress_surface(splat, key, std::sqrt(6 * 0.9f * 0.026f * kTau / static_cast<float>(count)));
    return splat;
}

// Radius of the vase at height `h` from 0 to 1.
float vase_profile(float h) {
    const float belly = 0.115f * std::sin(glm::pi<float>() * std::pow(h, 0.75f) * 0.86f + 0.35f);
    return 0.028f + belly + (h > 0.93f ? 0.35f * (h - 0.93f) : 0.0f);
}

GardenSplat vase(std::uint64_t key, std::uint32_t index, std::uint32_t count, std::uint64_t) {
    const glm::vec2 uv = even_point(index);
    constexpr float kTall = 0.3f;
    const float h = uv.x;
    const float radius = vase_profile(h);
    const float slope = (vase_profile(h + 0.005f) - vase_profile(h - 0.005f)) / (0.01f * kTall);
    const float angle = kTau * uv.y;
    const glm::vec3 out(std::cos(angle), 0, std::sin(angle));
    GardenSplat splat;
    splat.normal = glm::normalize(out - glm::vec3(0, slope, 0));
    splat.position = radius * out + glm::vec3(0, kTableTop + kTall * h, 0);
    splat.tangent = glm::vec3(-out.z, 0, out.x);
    const float wave = h + 0.02f * std::sin(6 * angle);
    const bool band = std::fabs(wave - 0.66f) < 0.06f || std::fabs(wave - 0.3f) < 0.025f;
    splat.albedo = band ? glm::vec3(0.78f, 0.74f, 0.66f) : glm::vec3(0.03f, 0.1f, 0.28f);
    splat.albedo *= 0.85f + 0.3f * garden_noise(splat.position * 40.0f);
    splat.gloss = 0.5f;
    splat.occlusion = 0.25f * (1 - h);
    dress_surface(splat, key, std::sqrt(kTall * kTau * 0.11f / static_cast<float>(count)));
    return splat;
}

GardenSplat patio(std::uint64_t key, std::uint32_t index, std::uint32_t count, std::uint64_t) {
    const glm::vec2 uv = even_point(index);
    GardenSplat splat;
    splat.position = {kPatioHalf * (2 * uv.x - 1), 0, kPatioHalf * (2 * uv.y - 1)};
    const Bond stone = bond_at({splat.position.x, splat.position.z}, {0.52f, 0.36f});
    const float mottle =
        garden_noise(splat.position * 9.0f) * 0.6f + garden_noise(splat.position * 55.0f) * 0.4f;
    splat.albedo = glm::mix(glm::vec3(0.24f, 0.215f, 0.19f), glm::vec3(0.46f, 0.41f, 0.35f), stone.tone) *
                   (0.7f + 0.6f * mottle);
    if (stone.joint < 0.011f) {
        // Moss in some joints.
        splat.albedo = garden_noise(splat.position * 3.0f) > 0.5f ? glm::vec3(0.05f, 0.075f, 0.02f)
                                                                  : glm::vec3(0.085f, 0.075f, 0.06f);
        splat.position.y -= 0.006f;
    }
    dress_surface(splat, key, 2 * kPatioHalf / std::sqrt(static_cast<float>(count)));
    return splat;
}

// Earth and far meadow, coarser with the distance.
GardenSplat ground(std::uint64_t key, std::uint32_t index, std::uint32_t count, std::uint64_t) {
    constexpr float kNear = 2.4f;
    constexpr float kFar = 70.0f;
    const glm::vec2 uv = even_point(index);
    const float radius = kNear * std::pow(kFar / kNear, uv.x);
    const float angle = kTau * uv.y;
    GardenSplat splat;
    splat.position = {radius * std::cos(angle), -0.02f, radius * std::sin(angle)};
    const float patch = garden_noise(splat.position * 0.9f);
    splat.albedo = glm::mix(glm::vec3(0.055f, 0.1f, 0.02f), glm::vec3(0.13f, 0.17f, 0.045f), patch) *
                   (0.8f + 0.4f * garden_noise(splat.position * 4.0f));
    const bool paved = std::max(std::fabs(splat.position.x), std::fabs(splat.position.z)) < kPatioHalf;
    if (paved) splat.albedo = {0.1f, 0.09f, 0.075f};
    dress_surface(splat, key, radius * std::sqrt(kTau * std::log(kFar / kNear) / static_cast<float>(count)));
    return splat;
}

// Windows, frames and the door on the wall; false where there is bare brick.
bool paint_openings(glm::vec2 at, GardenSplat& splat) {
    struct Opening {
        glm::vec2 low, high;
        bool door;
    };
    constexpr Opening kOpenings[] = {
        {{-8.6f, 0.95f}, {-7.0f, 2.4f}, false}, {{-5.4f, 0.0f}, {-4.3f, 2.25f}, true},
        {{-3.3f, 0.95f}, {-1.7f, 2.4f}, false}, {{-8.6f, 3.4f}, {-7.0f, 4.7f}, false},
        {{-5.6f, 3.4f}, {-4.1f, 4.7f}, false},  {{-3.3f, 3.4f}, {-1.7f, 4.7f}, false}};
    for (const Opening& o : kOpenings) {
        const glm::vec2 inside = glm::min(at - o.low, o.high - at);
        const float edge = std::min(inside.x, inside.y);
        if (edge < 0) continue;
        const glm::vec2 middle = glm::abs(at - 0.5f * (o.low + o.high));
        const bool bar = std::min(middle.x, middle.y) < 0.03f;
        if (o.door) {
            const bool panel = edge > 0.16f && middle.x > 0.06f && middle.y > 0.08f;
            splat.albedo = glm::vec3(0.06f, 0.2f, 0.13f) * (panel ? 0.75f : 1.0f);
        } else if (edge < 0.08f || bar) {
            splat.albedo = glm::vec3(0.72f);
        } else {
            const float curtain = garden_noise({at.x * 5, at.y * 0.7f, 0});
            splat.albedo =
                glm::mix(glm::vec3(0.035f, 0.05f, 0.065f), glm::vec3(0.22f, 0.25f, 0.28f), curtain);
            splat.gloss = 0.35f;
            splat.position.z -= 0.06f;
        }
        return true;
    }
    return false;
}

GardenSplat house(std::uint64_t key, std::uint32_t index, std::uint32_t count, std::uint64_t) {
    constexpr float kLeft = -11.0f;
    constexpr float kRight = -0.9f;
    constexpr float kTall = 5.6f;
    const glm::vec2 uv = even_point(index);
    GardenSplat splat;
    glm::vec2 at;
    const bool side = index % 6 == 0;  // the gable wall, running away from the garden
    if (side) {
        at = {6.0f * uv.x, kTall * uv.y};
        splat.position = {kRight, at.y, -6.5f - at.x};
        splat.normal = {1, 0, 0};
    } else {
        at = {glm::mix(kLeft, kRight, uv.x), kTall * uv.y};
        splat.position = {at.x, at.y, -6.5f};
        splat.normal = {0, 0, 1};
    }
    splat.tangent = {0, 1, 0};
    const Bond brick = bond_at(at, {0.24f, 0.085f});
    splat.albedo = glm::mix(glm::vec3(0.25f, 0.095f, 0.06f), glm::vec3(0.48f, 0.23f, 0.14f), brick.tone);
    if (brick.joint < 0.012f) splat.albedo = {0.46f, 0.42f, 0.36f};
    splat.albedo *= 0.8f + 0.4f * garden_noise(splat.position * 1.3f);
    if (!side) paint_openings(at, splat);
    splat.occlusion = 0.4f * std::exp(-2.5f * at.y);
    const float area = (kRight - kLeft + 6.0f) * kTall;
    dress_surface(splat, key, std::sqrt(area / static_cast<float>(count)));
    return splat;
}

GardenSplat sky(std::uint64_t key, std::uint32_t index, std::uint32_t count, std::uint64_t) {
    constexpr float kRadius = 85.0f;
    const glm::vec2 uv = even_point(index);
    const float up = 1.05f * uv.x - 0.05f;
    const float out = std::sqrt(1 - up * up);
    const glm::vec3 direction(out * std::cos(kTau * uv.y), up, out * std::sin(kTau * uv.y));
    GardenSplat splat;
    splat.position = kRadius * direction;
    splat.normal = -direction;
    const glm::vec3 at(direction.x * 4, direction.y * 9, direction.z * 4);
    const float cloud =
        glm::smoothstep(0.45f, 0.75f, 0.7f * garden_noise(at) + 0.3f * garden_noise(at * 3.0f));
    splat.albedo = glm::mix(
        glm::mix(glm::vec3(0.62f, 0.74f, 0.86f), glm::vec3(0.2f, 0.4f, 0.75f), std::sqrt(std::max(up, 0.0f))),
        glm::vec3(0.95f), 0.75f * cloud);
    dress_surface(splat, key, std::sqrt(kTau * kRadius * kRadius * 1.05f / static_cast<float>(count)));
    splat.opacity = std::max(splat.opacity, 0.6f);
    // Its own light.
    splat.occlusion = -1;
    return splat;
}

// What training leaves in the air where no view contradicts it.
GardenSplat floaters(std::uint64_t key, std::uint32_t, std::uint32_t, std::uint64_t) {
    GardenSplat splat;
    splat.position = random_direction(key, 0) * (1.5f + 7 * random_unit(key, 2));
    splat.position.y = 0.2f + std::fabs(splat.position.y) * 0.6f;
    splat.normal = random_direction(key, 3);
    splat.tangent = across(splat.normal);
    splat.spread = glm::vec2(0.06f, 0.03f) * std::exp(0.7f * random_normal(key, 5));
    splat.opacity = 0.01f + 0.05f * random_unit(key, 7);
    splat.albedo = glm::mix(glm::vec3(0.1f, 0.14f, 0.06f), glm::vec3(0.5f), random_unit(key, 8));
    return splat;
}

}  // namespace

std::vector<GardenPart> garden_surfaces() {
    return {{0.085, table_top}, {0.02, table_frame}, {0.03, vase}, {0.14, patio},
            {0.06, ground},     {0.12, house},       {0.006, sky}, {0.003, floaters}};
}

}  // namespace ropsim
