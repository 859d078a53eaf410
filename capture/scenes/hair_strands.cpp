// Hair parted in the middle and tied into two bunches: each strand runs over the skull to its tie, then hangs
// down.
#include "capture/scenes/hair_strands.h"

#include "base/parallel.h"
#include "base/random.h"

#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

constexpr std::uint32_t kLocks = 420;
constexpr int kTiePoint = 14;   // of the points: where the bunch is tied
constexpr float kPart = 0.12f;  // where the hair is parted, x
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

// Looks of a lock that its strands share.
struct Style {
    float length;
    float lift;   // how far the strand stands off the head
    float wave;   // amplitude below the tie
    float turns;  // radians from tie to tip
    float phase;
    glm::vec3 place;  // in the bunch: a point of the unit ball
};

Style lock_style(std::uint64_t seed, std::uint32_t lock) {
    const std::uint64_t key = mix64(seed ^ (kLockStream << 32) ^ lock);
    const auto unit = [&](std::uint32_t draw) { return random_unit(key, draw); };
    return {0.85f + 0.3f * unit(0),         0.05f + 0.09f * unit(1),
            0.04f + 0.06f * unit(2),        6.0f + 5.0f * unit(3),
            glm::two_pi<float>() * unit(4), random_direction(key, 5) * std::cbrt(unit(7))};
}

// The shorter arc between two unit vectors, as a unit vector.
glm::vec3 arc(glm::vec3 from, glm::vec3 to, float t) {
    const float angle = std::acos(glm::clamp(glm::dot(from, to), -0.9995f, 0.9995f));
    return glm::normalize((from * std::sin((1 - t) * angle) + to * std::sin(t * angle)) / std::sin(angle));
}

// Middle of the bunch `s` in [0, 1] from the tie to the tips: behind the ear, forward over the shoulder,
// down.
glm::vec3 bunch_axis(float side, float s, float length) {
    const glm::vec3 tie =
        kSkullCentre + kSkullRadii * 1.1f * glm::normalize(glm::vec3(side * 0.85f, -0.62f, -0.12f));
    const float fall = length * s;
    return tie + glm::vec3(side * (0.3f * std::sin(2.2f * s) - 0.05f * s), -fall - 0.12f * (1 - s) * s,
                           1.0f * glm::smoothstep(0.0f, 0.75f, s) - 0.1f * s);
}

// Radius of the bunch: narrow at the tie, full below, tapering to the tips.
float bunch_radius(float s) {
    return 0.085f + 0.165f * glm::smoothstep(0.0f, 0.3f, s) - 0.14f * glm::smoothstep(0.5f, 1.0f, s);
}

void grow_strand(std::uint64_t seed, std::uint32_t index, const std::vector<Root>& roots, HairStrands& hair) {
    const std::uint64_t key = mix64(seed ^ (kStrandStream << 32) ^ index);
    const auto lock = static_cast<std::uint32_t>(random_unit(key, 0) * static_cast<float>(kLocks));
    const Style style = lock_style(seed, lock);
    const glm::vec3 scatter = random_direction(key, 1) * std::sqrt(random_unit(key, 3));
    // A strand stays on its lock's side of the parting.
    const float side = roots[lock].direction.x < kPart ? -1.0f : 1.0f;
    glm::vec3 direction = glm::normalize(roots[lock].direction + 0.13f * scatter);
    if (side * (direction.x - kPart) < 0) direction.x = 2 * kPart - direction.x;
    const Root root = make_root(direction);
    hair.locks[index] = lock;
    const bool stray = random_unit(key, 7) > 0.94f;
    const glm::vec3 loose = (stray ? 0.12f : 0.02f) * random_direction(key, 8);
    const float length = 1.85f * style.length * (0.8f + 0.25f * random_unit(key, 4));
    const float lift = style.lift * (0.3f + random_unit(key, 5)) + (stray ? 0.05f : 0.0f);
    const glm::vec3 place =
        glm::mix(style.place, random_direction(key, 10) * std::cbrt(random_unit(key, 12)), 0.45f);
    const float phase = style.phase + 0.9f * (random_unit(key, 6) - 0.5f);
    const glm::vec3 tie = (bunch_axis(side, 0, length) - kSkullCentre) / kSkullRadii;
    const glm::vec3 tie_direction = glm::normalize(tie);
    const float tie_height = glm::length(tie);
    for (int i = 0; i < kStrandPoints; ++i) {
        glm::vec3& point =
            hair.points[static_cast<std::size_t>(index) * kStrandPoints + static_cast<std::size_t>(i)];
        if (i <= kTiePoint) {
            const float t = static_cast<float>(i) / static_cast<float>(kTiePoint);
            const float height =
                glm::mix(1.0f, tie_height, t * t) + lift * std::sin(glm::pi<float>() * std::sqrt(t));
            point = kSkullCentre + kSkullRadii * height * arc(root.direction, tie_direction, t);
            point += t * t * bunch_radius(0) * place + t * (1 - t) * 3.0f * loose;
            continue;
        }
        const float s = static_cast<float>(i - kTiePoint) / static_cast<float>(kStrandPoints - 1 - kTiePoint);
        const float angle = phase + style.turns * s;
        point = bunch_axis(side, s, length) + bunch_radius(s) * place + s * loose +
                style.wave * std::min(3.0f * s, 1.0f) * glm::vec3(std::cos(angle), 0.0f, std::sin(angle));
    }
}

}  // namespace

HairStrands grow_hair(std::uint32_t count, std::uint64_t seed) {
    std::vector<Root> roots;
    for (std::uint32_t lock = 0; lock < kLocks; ++lock) roots.push_back(lock_root(seed, lock));
    HairStrands hair;
    hair.points.resize(static_cast<std::size_t>(count) * kStrandPoints);
    hair.locks.resize(count);
    constexpr std::uint32_t kBatch = 256;
    const auto batches = static_cast<int>((count + kBatch - 1) / kBatch);
    parallel_for(default_threads(), batches, [&](int batch) {
        const std::uint32_t first = static_cast<std::uint32_t>(batch) * kBatch;
        for (std::uint32_t i = first; i < std::min(first + kBatch, count); ++i) {
            grow_strand(seed, i, roots, hair);
        }
    });
    return hair;
}

}  // namespace ropsim
