// Hair by growing each strand step by step: it bends under its weight, slides off the head, and gathers into locks.
#include "capture/scenes/hair_strands.h"

#include <cmath>

#include <glm/gtc/constants.hpp>

#include "base/parallel.h"
#include "base/random.h"

namespace ropsim {
namespace {

constexpr std::uint32_t kLocks = 420;
constexpr float kStep = 0.115f;  // between points, decimetres, before the lock's own length
constexpr float kPart = 0.12f;   // where the hair is parted, x
constexpr std::uint64_t kStrandStream = 0x48616972u;
constexpr std::uint64_t kLockStream = 0x4C6F636Bu;

struct Root {
    glm::vec3 direction;  // from the skull's centre, in units of its radii; unit length
    glm::vec3 position;
    glm::vec3 normal;
};

Root make_root(glm::vec3 direction) {
    Root root;
    root.direction = glm::normalize(direction);
    root.position = kSkullCentre + kSkullRadii * root.direction;
    root.normal = glm::normalize(root.direction / kSkullRadii);
    return root;
}

glm::vec3 random_direction(std::uint64_t key, std::uint32_t draw) {
    const float y = 2 * random_unit(key, draw) - 1;
    const float phi = glm::two_pi<float>() * random_unit(key, draw + 1);
    const float r = std::sqrt(std::max(0.0f, 1 - y * y));
    return {r * std::cos(phi), y, r * std::sin(phi)};
}

// Hair grows above a line that runs from the nape up over the ears to the forehead.
bool on_scalp(glm::vec3 direction) {
    const float front = glm::smoothstep(-0.25f, 0.75f, direction.z);
    return direction.y > glm::mix(-0.42f, 0.6f, front);
}

Root lock_root(std::uint64_t seed, std::uint32_t lock) {
    const std::uint64_t key = mix64(seed ^ (kLockStream << 32) ^ lock);
    for (std::uint32_t draw = 16;; draw += 2) {
        const glm::vec3 direction = random_direction(key, draw);
        if (on_scalp(direction)) return make_root(direction);
    }
}

// Keeps a point out of an ellipsoid: moves it to the surface and takes the inward part from its direction.
void push_out(glm::vec3 centre, glm::vec3 radii, glm::vec3& point, glm::vec3& direction) {
    const glm::vec3 local = (point - centre) / radii;
    const float distance = glm::length(local);
    if (distance >= 1.0f || distance == 0.0f) return;
    point = centre + radii * (local / distance);
    const glm::vec3 normal = glm::normalize(local / radii);
    direction -= normal * std::min(glm::dot(direction, normal), 0.0f);
}

// Looks of a lock that its strands share.
struct Style {
    float length;
    float lift;   // how far the strand stands off the head
    float wave;   // amplitude at the tip
    float turns;  // radians from root to tip
    float phase;
};

Style lock_style(std::uint64_t seed, std::uint32_t lock) {
    const std::uint64_t key = mix64(seed ^ (kLockStream << 32) ^ lock);
    return {0.85f + 0.3f * random_unit(key, 0), 0.05f + 0.13f * random_unit(key, 1), 0.05f + 0.06f * random_unit(key, 2),
            7.0f + 5.0f * random_unit(key, 3), glm::two_pi<float>() * random_unit(key, 4)};
}

// Walks from the root: outwards and away from the parting at first, ever more downwards.
void grow(const Root& root, const Style& style, float lift, glm::vec3* points) {
    const float side = root.position.x < kPart ? -1.0f : 1.0f;
    glm::vec3 direction =
        glm::normalize(root.normal * 0.55f + glm::vec3(side * 0.75f, 0.15f, root.position.z > 0.1f ? -0.35f : -0.25f));
    glm::vec3 point = root.position;
    points[0] = point;
    for (int i = 1; i < kStrandPoints; ++i) {
        direction = glm::normalize(direction + glm::vec3(0, -0.3f, 0));
        point += direction * (kStep * style.length);
        push_out(kSkullCentre, kSkullRadii * (1.0f + lift), point, direction);
        // The face stays free: hair that would fall over it is turned aside.
        const glm::vec3 face = (point - glm::vec3(0.05f, -0.2f, 0.75f)) / glm::vec3(0.72f, 0.85f, 0.8f);
        if (glm::dot(face, face) < 1.0f) {
            const float room = std::sqrt(std::max(0.0f, 1 - face.y * face.y - face.z * face.z)) * 0.72f;
            point.x = side * std::max(side * point.x, room);
            direction.x = side * std::max(side * direction.x, 0.1f);
        }
        push_out({0, -1.9f, -0.15f}, glm::vec3(1.62f, 0.62f, 0.66f) * (1.0f + lift), point, direction);
        points[i] = point;
    }
}

void grow_strand(std::uint64_t seed, std::uint32_t index, const std::vector<Root>& roots,
                 const std::vector<glm::vec3>& guides, HairStrands& hair) {
    const std::uint64_t key = mix64(seed ^ (kStrandStream << 32) ^ index);
    const auto lock = static_cast<std::uint32_t>(random_unit(key, 0) * static_cast<float>(kLocks));
    const Style style = lock_style(seed, lock);
    const glm::vec3 scatter = random_direction(key, 1) * std::sqrt(random_unit(key, 3));
    const Root root = make_root(roots[lock].direction + 0.17f * scatter);
    glm::vec3* points = &hair.points[static_cast<std::size_t>(index) * kStrandPoints];
    hair.locks[index] = lock;
    Style own = style;
    own.length *= 0.88f + 0.2f * random_unit(key, 4);
    grow(root, own, style.lift * (0.3f + 1.0f * random_unit(key, 5)), points);
    const glm::vec3* guide = &guides[static_cast<std::size_t>(lock) * kStrandPoints];
    const float gather = 0.55f + 0.35f * random_unit(key, 6);
    const float stray = random_unit(key, 7) > 0.93f ? 0.16f : 0.045f;
    const glm::vec3 offset = stray * random_direction(key, 8);
    const float own_phase = style.phase + 0.9f * (random_unit(key, 10) - 0.5f);
    for (int i = 0; i < kStrandPoints; ++i) {
        const float t = static_cast<float>(i) / static_cast<float>(kStrandPoints - 1);
        const float pull = gather * glm::smoothstep(0.05f, 0.8f, t);
        const float angle = own_phase + style.turns * t;
        const glm::vec3 wave = style.wave * t * glm::vec3(std::cos(angle), 0.0f, std::sin(angle));
        points[i] = glm::mix(points[i], guide[i], pull) + wave + offset * t;
    }
}

}  // namespace

HairStrands grow_hair(std::uint32_t count, std::uint64_t seed) {
    std::vector<Root> roots;
    std::vector<glm::vec3> guides(static_cast<std::size_t>(kLocks) * kStrandPoints);
    for (std::uint32_t lock = 0; lock < kLocks; ++lock) {
        roots.push_back(lock_root(seed, lock));
        const Style style = lock_style(seed, lock);
        grow(roots[lock], style, style.lift, &guides[static_cast<std::size_t>(lock) * kStrandPoints]);
    }
    HairStrands hair;
    hair.points.resize(static_cast<std::size_t>(count) * kStrandPoints);
    hair.locks.resize(count);
    constexpr std::uint32_t kBatch = 256;
    const auto batches = static_cast<int>((count + kBatch - 1) / kBatch);
    parallel_for(default_threads(), batches, [&](int batch) {
        const std::uint32_t first = static_cast<std::uint32_t>(batch) * kBatch;
        for (std::uint32_t i = first; i < std::min(first + kBatch, count); ++i) {
            grow_strand(seed, i, roots, guides, hair);
        }
    });
    return hair;
}

}  // namespace ropsim
