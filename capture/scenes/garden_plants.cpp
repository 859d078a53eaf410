// What grows in the garden: the bouquet, grass, hedges, bushes and trees.
#include "base/random.h"
#include "capture/scenes/garden.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

constexpr float kTau = glm::two_pi<float>();

// A random number of (seed, what, which).
std::uint64_t thing_key(std::uint64_t seed, std::uint32_t what, std::uint32_t which) {
    return mix64(mix64(seed ^ (std::uint64_t{what} << 40)) ^ which);
}

// Where stem `stem` of the bouquet is at `t` from 0 (the vase's mouth) to 1.
glm::vec3 stem_at(std::uint64_t key, float t) {
    const float angle = kTau * random_unit(key, 0);
    const float lean = 0.06f + 0.3f * std::sqrt(random_unit(key, 1));
    const float tall = 0.2f + 0.22f * random_unit(key, 2) + 0.12f * (0.36f - lean);
    const float out = 0.035f * random_unit(key, 3) + lean * t * t;
    return {out * std::cos(angle), 1.0f + tall * (1.35f * t - 0.35f * t * t), out * std::sin(angle)};
}

GardenSplat bouquet_leaf(std::uint64_t key, std::uint32_t, std::uint32_t, std::uint64_t seed) {
    constexpr float kLeaves = 520;
    const auto which = static_cast<std::uint32_t>(kLeaves * random_unit(key, 0));
    const std::uint64_t leaf = thing_key(seed, 1, which);
    const glm::vec3 root = stem_at(thing_key(seed, 2, which % 40), 0.1f + 0.8f * random_unit(leaf, 0));
    glm::vec3 along = random_direction(leaf, 1);
    along = glm::normalize(along + glm::vec3(root.x, 0, root.z) * 3.0f + glm::vec3(0, 0.45f, 0));
    const glm::vec3 side = glm::normalize(glm::cross(along, glm::vec3(0.01f, 1, 0.02f)));
    const float length = 0.05f + 0.05f * random_unit(leaf, 3);
    const float s = random_unit(key, 1);
    const float width = 0.24f * length * std::sin(glm::pi<float>() * std::pow(s, 0.8f));
    const float t = 2 * random_unit(key, 2) - 1;
    GardenSplat splat;
    // Leaves droop along their length and fold up from the midrib.
    splat.position = root + along * (length * s) + side * (width * t) +
                     glm::vec3(0, 0.3f * width * std::fabs(t) - 0.35f * length * s * s, 0);
    splat.normal = glm::normalize(glm::cross(side, along) + side * (0.3f * t) + along * (0.5f * s));
    const float tone = random_unit(leaf, 4);
    splat.albedo = glm::mix(glm::vec3(0.03f, 0.1f, 0.022f), glm::vec3(0.13f, 0.27f, 0.06f), tone);
    if (std::fabs(t) < 0.1f) splat.albedo *= 1.5f;
    dress_leaf(splat, key, 0.0028f);
    splat.gloss = 0.1f;
    return splat;
}

GardenSplat bouquet_flower(std::uint64_t key, std::uint32_t index, std::uint32_t, std::uint64_t seed) {
    constexpr std::uint32_t kFlowers = 30;
    const auto which = index % kFlowers;
    const std::uint64_t flower = thing_key(seed, 2, which);
    const glm::vec3 head = stem_at(flower, 1.0f);
    const glm::vec3 up =
        glm::normalize(stem_at(flower, 1.0f) - stem_at(flower, 0.8f) + glm::vec3(0, 0.03f, 0.02f));
    const glm::vec3 first = across(up);
    const glm::vec3 second = glm::cross(up, first);
    constexpr float kPetals = 13;
    const float layer = std::floor(3 * random_unit(key, 0));
    const float petal = std::floor(kPetals * random_unit(key, 1)) + 0.33f * layer;
    const float size = (0.03f + 0.018f * random_unit(flower, 10)) * (1 - 0.2f * layer);
    const float s = std::sqrt(random_unit(key, 2));
    const float spread = (random_unit(key, 3) - 0.5f) * 0.75f * (1.1f - s * s * 0.6f);
    const float angle = kTau * (petal + spread) / kPetals;
    const glm::vec3 out = std::cos(angle) * first + std::sin(angle) * second;
    GardenSplat splat;
    if (random_unit(key, 4) < 0.12f) {
        splat.position = head + 0.011f * (random_direction(key, 5) + up);
        splat.normal = up;
        splat.albedo = {0.55f, 0.32f, 0.03f};
    } else {
        const float rise = 0.25f + 0.28f * layer;
        splat.position = head + size * (s * out + up * (rise * s + 0.1f * s * s));
        splat.normal = glm::normalize(up - rise * out);
        constexpr std::array<glm::vec3, 4> kColors = {
            glm::vec3(0.62f, 0.06f, 0.2f), glm::vec3(0.8f, 0.75f, 0.66f), glm::vec3(0.75f, 0.3f, 0.42f),
            glm::vec3(0.75f, 0.45f, 0.05f)};
        const auto color = static_cast<std::size_t>(4 * random_unit(flower, 11));
        splat.albedo = kColors[color] * (0.55f + 0.45f * s);
    }
    dress_leaf(splat, key, 0.0026f);
    return splat;
}

GardenSplat bouquet_stem(std::uint64_t key, std::uint32_t index, std::uint32_t, std::uint64_t seed) {
    const std::uint64_t stem = thing_key(seed, 2, index % 40);
    const float t = random_unit(key, 0);
    const glm::vec3 here = stem_at(stem, t);
    const glm::vec3 axis = glm::normalize(stem_at(stem, t + 0.02f) - here);
    GardenSplat splat;
    const float turn = kTau * random_unit(key, 1);
    splat.normal = std::cos(turn) * across(axis) + std::sin(turn) * glm::cross(axis, across(axis));
    splat.position = here + 0.0025f * splat.normal;
    splat.tangent = axis;
    splat.spread = {0.006f, 0.0015f};
    splat.albedo = {0.09f, 0.16f, 0.04f};
    return splat;
}

// Half of the directions lie where the views of the capture looked most.
float seen_angle(std::uint64_t key, std::uint32_t draw) {
    const float u = random_unit(key, draw);
    if (random_unit(key, draw + 1) < 0.5f) return kTau * u;
    return -2.1f + 1.9f * (u - 0.5f);
}

GardenSplat grass(std::uint64_t key, std::uint32_t, std::uint32_t, std::uint64_t) {
    constexpr float kNear = 2.6f;
    constexpr float kFar = 18.0f;
    const float radius = kNear * std::pow(kFar / kNear, random_unit(key, 0));
    const float angle = seen_angle(key, 1);
    GardenSplat splat;
    splat.position = {radius * std::cos(angle), 0, radius * std::sin(angle)};
    const float beyond = std::max(std::fabs(splat.position.x), std::fabs(splat.position.z)) - kPatioHalf;
    const float tall = (0.03f + 0.05f * random_unit(key, 3)) * (beyond < 0 ? 0.35f : 1.0f);
    if (beyond < 0) {
        // Only tufts in the joints.
        splat.position *= 1.0f + 2 * (0.05f - beyond) / radius;
    }
    const glm::vec3 lean = glm::normalize(glm::vec3(0, 1, 0) + 0.55f * random_direction(key, 4));
    splat.tangent = lean;
    splat.normal = across(lean);
    splat.position += lean * (0.5f * tall) - glm::vec3(0, 0.02f, 0);
    splat.spread = {0.33f * tall, 0.0009f * radius};
    splat.thickness = 0.5f;
    splat.opacity = 0.5f + 0.49f * random_unit(key, 6);
    const float patch = garden_noise(splat.position * 0.9f);
    splat.albedo = glm::mix(glm::vec3(0.07f, 0.15f, 0.025f), glm::vec3(0.22f, 0.3f, 0.075f),
                            0.6f * patch + 0.4f * random_unit(key, 7));
    splat.translucence = 0.5f;
    // Blades are lit like the lawn that they make.
    splat.normal = glm::normalize(splat.normal - glm::dot(splat.normal, lean) * lean);
    return splat;
}

struct Box {
    glm::vec3 low, high;
};

GardenSplat hedge(std::uint64_t key, std::uint32_t index, std::uint32_t, std::uint64_t) {
    constexpr std::array<Box, 3> kHedges = {Box{{-0.2f, 0, -7.3f}, {8.6f, 1.75f, -6.3f}},
                                            Box{{6.6f, 0, -6.4f}, {7.7f, 1.6f, 4.0f}},
                                            Box{{-8.2f, 0, -3.0f}, {-7.2f, 1.6f, 6.5f}}};
    const Box& box = kHedges[index % 10 < 6 ? 0 : (index % 10 < 8 ? 1 : 2)];
    const glm::vec3 size = box.high - box.low;
    // The faces that can be seen: top and the long sides.
    const int thin = size.x < size.z ? 0 : 2;
    const bool top = random_unit(key, 0) < 0.38f;
    const int axis = top ? 1 : thin;
    glm::vec3 at(random_unit(key, 1), random_unit(key, 2), random_unit(key, 3));
    const bool far_side = !top && random_unit(key, 4) < 0.3f;
    GardenSplat splat;
    glm::vec3 outward(0);
    outward[axis] =
        top ? 1.0f : (thin == 2 ? 1.0f : (box.low.x > 0 ? -1.0f : 1.0f)) * (far_side ? -1.0f : 1.0f);
    at[axis] = outward[axis] > 0 ? 1.0f : 0.0f;
    const float inward = 0.16f * random_unit(key, 5) * random_unit(key, 6);
    splat.position = box.low + size * at - outward * inward;
    splat.position += outward * (0.22f * (garden_noise(splat.position * 3.0f) - 0.5f) +
                                 0.1f * (garden_noise(splat.position * 9.0f) - 0.5f));
    splat.normal = glm::normalize(outward + 0.9f * random_direction(key, 7));
    const float tone = 0.5f * random_unit(key, 9) + 0.5f * garden_noise(splat.position * 2.5f);
    splat.albedo = glm::mix(glm::vec3(0.02f, 0.06f, 0.012f), glm::vec3(0.1f, 0.19f, 0.035f), tone);
    splat.occlusion = std::min(inward * 6 + 0.35f * std::exp(-2 * splat.position.y), 0.85f);
    dress_leaf(splat, key, 0.014f);
    splat.gloss = 0.08f;
    return splat;
}

struct Bush {
    glm::vec3 centre;
    glm::vec3 radii;
    glm::vec3 leaf;
    glm::vec3 flower;
    float flowers;  // share of splats
};

GardenSplat bush(std::uint64_t key, std::uint32_t index, std::uint32_t, std::uint64_t) {
    static constexpr std::array<Bush, 10> kBushes = {
        Bush{{-7.6f, 0.5f, -5.7f}, {0.8f, 0.75f, 0.6f}, {0.09f, 0.16f, 0.05f}, {0.7f, 0.65f, 0.6f}, 0.12f},
        Bush{{-6.3f, 0.35f, -5.6f}, {0.65f, 0.55f, 0.5f}, {0.12f, 0.2f, 0.05f}, {0.6f, 0.12f, 0.4f}, 0.16f},
        Bush{{-3.6f, 0.45f, -5.7f}, {0.6f, 0.65f, 0.5f}, {0.06f, 0.15f, 0.04f}, {0.75f, 0.55f, 0.06f}, 0.12f},
        Bush{{-2.5f, 0.4f, -5.6f}, {0.7f, 0.6f, 0.55f}, {0.1f, 0.19f, 0.07f}, {0.65f, 0.08f, 0.1f}, 0.14f},
        Bush{{-1.2f, 0.6f, -5.9f}, {0.75f, 0.9f, 0.6f}, {0.05f, 0.13f, 0.04f}, {0.7f, 0.3f, 0.5f}, 0.1f},
        Bush{{2.6f, 0.4f, -5.3f}, {0.8f, 0.6f, 0.6f}, {0.11f, 0.2f, 0.06f}, {0.35f, 0.2f, 0.6f}, 0.2f},
        Bush{{4.4f, 0.5f, -4.9f}, {0.7f, 0.75f, 0.65f}, {0.15f, 0.21f, 0.06f}, {0.8f, 0.75f, 0.65f}, 0.1f},
        Bush{{5.7f, 0.45f, -2.6f}, {0.7f, 0.7f, 0.7f}, {0.08f, 0.17f, 0.05f}, {0.7f, 0.35f, 0.08f}, 0.12f},
        Bush{{-4.7f, 0.5f, -2.2f}, {0.75f, 0.75f, 0.7f}, {0.07f, 0.15f, 0.05f}, {0.6f, 0.6f, 0.75f}, 0.14f},
        Bush{{-5.2f, 0.45f, 1.6f}, {0.8f, 0.65f, 0.7f}, {0.1f, 0.17f, 0.05f}, {0.75f, 0.6f, 0.1f}, 0.08f}};
    const Bush& b = kBushes[index % kBushes.size()];
    glm::vec3 out = random_direction(key, 0);
    if (out.y < -0.5f) out.y = -out.y;
    // Foliage gathers in lumps.
    const float lump =
        garden_noise(out * 2.6f + b.centre) * 0.45f + garden_noise(out * 7.0f + b.centre) * 0.2f;
    const float depth = 0.3f * random_unit(key, 2) * random_unit(key, 3);
    GardenSplat splat;
    splat.position = b.centre + b.radii * out * (0.72f + lump - depth);
    splat.normal = glm::normalize(out + 0.8f * random_direction(key, 4));
    const bool flower = random_unit(key, 6) < b.flowers && depth < 0.12f;
    splat.albedo = flower ? b.flower : b.leaf * (0.5f + 0.8f * random_unit(key, 7));
    splat.occlusion = std::min(2.2f * depth + 0.5f * (0.45f - lump) + (out.y < 0 ? 0.3f : 0.0f), 0.85f);
    splat.occlusion = std::max(splat.occlusion, 0.0f);
    dress_leaf(splat, key, flower ? 0.015f : 0.012f);
    return splat;
}

struct Tree {
    glm::vec3 foot;
    float tall;
    float crown;
    glm::vec3 leaf;
};

GardenSplat tree(std::uint64_t key, std::uint32_t index, std::uint32_t, std::uint64_t seed) {
    static constexpr std::array<Tree, 9> kTrees = {
        Tree{{2.2f, 0, -10.5f}, 5.2f, 1.9f, {0.1f, 0.18f, 0.04f}},
        Tree{{6.0f, 0, -12.0f}, 6.5f, 2.4f, {0.06f, 0.13f, 0.03f}},
        Tree{{10.5f, 0, -9.0f}, 5.6f, 2.1f, {0.13f, 0.19f, 0.05f}},
        Tree{{12.0f, 0, -3.0f}, 6.0f, 2.3f, {0.08f, 0.15f, 0.04f}},
        Tree{{3.8f, 0, -18.0f}, 8.5f, 3.2f, {0.05f, 0.11f, 0.03f}},
        Tree{{11.0f, 0, -19.0f}, 9.0f, 3.6f, {0.07f, 0.13f, 0.035f}},
        Tree{{0.6f, 0, -15.5f}, 7.0f, 2.5f, {0.1f, 0.15f, 0.03f}},
        Tree{{-11.5f, 0, 2.0f}, 6.5f, 2.6f, {0.09f, 0.16f, 0.04f}},
        Tree{{-2.0f, 0, 12.0f}, 6.8f, 2.6f, {0.08f, 0.15f, 0.04f}}};
    const std::uint32_t which = index % kTrees.size();
    const Tree& t = kTrees[which];
    GardenSplat splat;
    if (random_unit(key, 0) < 0.07f) {
        const float h = random_unit(key, 1);
        const float angle = kTau * random_unit(key, 2);
        splat.normal = {std::cos(angle), 0, std::sin(angle)};
        splat.position = t.foot + splat.normal * (0.035f * t.tall * (1.1f - 0.7f * h)) +
                         glm::vec3(0, h * 0.75f * t.tall, 0);
        splat.albedo = glm::vec3(0.13f, 0.095f, 0.065f) *
                       (0.6f + 0.8f * garden_noise(splat.position * glm::vec3(9, 2, 9)));
        splat.occlusion = 0.3f * h;
        dress_surface(splat, key, 0.06f);
        return splat;
    }
    constexpr float kClusters = 26;
    const std::uint64_t cluster =
        thing_key(seed, 5 + which, static_cast<std::uint32_t>(kClusters * random_unit(key, 1)));
    const glm::vec3 place =
        random_direction(cluster, 0) * (0.35f + 0.6f * std::cbrt(random_unit(cluster, 2)));
    const glm::vec3 out = random_direction(key, 2);
    const float size = t.crown * (0.28f + 0.14f * random_unit(cluster, 3));
    const float depth = 0.5f * random_unit(key, 4) * random_unit(key, 5);
    const glm::vec3 crown = t.foot + glm::vec3(0, t.tall - 0.9f * t.crown, 0);
    splat.position = crown + place * t.crown * glm::vec3(1, 0.95f, 1) + out * (size * (1 - depth));
    splat.normal = glm::normalize(out + 0.8f * random_direction(key, 6));
    splat.albedo = t.leaf * (0.6f + 0.7f * random_unit(key, 8)) * (0.8f + 0.4f * random_unit(cluster, 4));
    splat.occlusion = std::clamp(depth + 0.35f - 0.35f * out.y - 0.25f * place.y, 0.0f, 0.85f);
    dress_leaf(splat, key, 0.0052f * t.tall);
    return splat;
}

// The far edge of the woods.
GardenSplat woods(std::uint64_t key, std::uint32_t index, std::uint32_t count, std::uint64_t) {
    const glm::vec2 uv = even_point(index);
    const float angle = kTau * uv.x;
    const glm::vec3 out(std::cos(angle), 0, std::sin(angle));
    const float tall = 4.0f + 6.0f * garden_noise(out * 6.0f) + 2.5f * garden_noise(out * 22.0f);
    const float h = uv.y;
    GardenSplat splat;
    splat.position = out * (44.0f - 3.0f * h + 2 * random_unit(key, 0)) + glm::vec3(0, h * tall, 0);
    splat.normal = glm::normalize(-out + 0.7f * random_direction(key, 1));
    const float tone = garden_noise(glm::vec3(out.x * 45, h * tall * 0.9f, out.z * 45));
    // Hazy with distance.
    splat.albedo = glm::mix(glm::mix(glm::vec3(0.03f, 0.07f, 0.025f), glm::vec3(0.11f, 0.17f, 0.05f), tone),
                            glm::vec3(0.4f, 0.5f, 0.6f), 0.18f);
    splat.occlusion = 0.5f * (1 - h);
    dress_surface(splat, key, std::sqrt(kTau * 44 * 8.5f / static_cast<float>(count)));
    splat.translucence = 0.3f;
    return splat;
}

}  // namespace

std::vector<GardenPart> garden_plants() {
    return {{0.045, bouquet_leaf}, {0.045, bouquet_flower}, {0.006, bouquet_stem},
            {0.17, grass},         {0.11, hedge},           {0.08, bush},
            {0.065, tree},         {0.015, woods}};
}

}  // namespace ropsim
