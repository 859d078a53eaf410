// Loose long hair: each strand leaves the scalp as it is combed, then slides down the head, neck and
// shoulders under its weight, a layer's height above them, in locks that gather towards their tips.
#include "capture/scenes/hair_strands.h"

#include "base/parallel.h"
#include "base/random.h"
#include "capture/scenes/hair_head.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

constexpr std::uint32_t kLocks = 700;
constexpr float kPart = 0.1f;  // where the hair is parted, x
constexpr std::uint64_t kStrandStream = 0x48616972u;
constexpr std::uint64_t kLockStream = 0x4C6F636Bu;

using Strand = std::array<glm::vec3, kStrandPoints>;

glm::vec3 random_direction(std::uint64_t key, std::uint32_t draw) {
    const float y = 2 * random_unit(key, draw) - 1;
    const float phi = glm::two_pi<float>() * random_unit(key, draw + 1);
    const float r = std::sqrt(std::max(0.0f, 1 - y * y));
    return {r * std::cos(phi), y, r * std::sin(phi)};
}

// Hair grows above a line that runs from the nape up over the ears to the forehead.
bool on_scalp(glm::vec3 direction) {
    const float front = glm::smoothstep(-0.25f, 0.75f, direction.z);
    return direction.y > glm::mix(-0.42f, 0.52f, front);
}

std::uint64_t lock_key(std::uint64_t seed, std::uint32_t lock) {
    return mix64(seed ^ (kLockStream << 32) ^ lock);
}

// Where a lock grows, as a direction in units of the skull's radii.
glm::vec3 lock_root(std::uint64_t seed, std::uint32_t lock) {
    for (std::uint32_t draw = 16;; draw += 2) {
        const glm::vec3 direction = random_direction(lock_key(seed, lock), draw);
        if (on_scalp(direction)) return direction;
    }
}

// How the hair at a root is combed: away from the parting, off the forehead, and down.
glm::vec3 combed(glm::vec3 direction, glm::vec3 normal) {
    const float side = direction.x < kPart ? -1.0f : 1.0f;
    const float top = glm::smoothstep(-0.2f, 0.8f, direction.y);
    const float front = glm::smoothstep(0.0f, 0.8f, direction.z);
    const glm::vec3 wish(side * (0.25f + 0.9f * top), -0.7f, -0.25f - 0.35f * front);
    return glm::normalize(wish - normal * glm::dot(wish, normal));
}

// How a strand falls.
struct Fall {
    glm::vec3 direction;  // of its root from the skull's centre, in units of the skull's radii
    float length;
    float layer;     // its height above the bust
    glm::vec2 rest;  // x and z that it is swept to below the chin: all hair lies before the shoulders
};

Strand fall(const BlobBody& bust, const HairStyle& style, const Fall& how) {
    const auto& [direction, length, layer, rest] = how;
    const float step = length / static_cast<float>(kStrandPoints - 1);
    const glm::vec3 normal = glm::normalize(direction / kSkullRadii);
    Strand strand;
    strand[0] = kSkullCentre + kSkullRadii * direction;
    glm::vec3 heading = glm::normalize(combed(direction, normal) + (0.2f + 2.2f * layer) * normal);
    for (std::size_t i = 1; i < strand.size(); ++i) {
        const glm::vec3 before = strand[i - 1];
        const glm::vec2 sweep = style.sweep * step * glm::smoothstep(0.1f, -1.0f, before.y) *
                                (rest - glm::vec2(before.x, before.z));
        heading =
            glm::normalize(heading + glm::vec3(sweep.x, -style.weight * step, sweep.y) + step * style.wind);
        glm::vec3 next = before + step * heading;
        // The layer is reached gradually from the root.
        const float height = layer * std::min(1.0f, static_cast<float>(i) / 5.0f);
        const float inside = height - bust.distance(next);
        if (inside > 0) next += inside * bust.normal(next);
        heading = glm::normalize(next - before);
        strand[i] = before + step * heading;
    }
    return strand;
}

// Looks of a lock that its strands share.
struct Lock {
    glm::vec3 direction;
    float length;
    float layer;
    glm::vec2 rest;
    float wave;   // amplitude at the tips
    float turns;  // radians from root to tip
    float phase;
    float gather;  // how much the tips come together
    Strand guide;
};

Lock make_lock(std::uint64_t seed, std::uint32_t index, const HairStyle& style, const BlobBody& bust) {
    const std::uint64_t key = lock_key(seed, index);
    const auto unit = [&](std::uint32_t draw) { return random_unit(key, draw); };
    Lock lock;
    lock.direction = lock_root(seed, index);
    lock.length = style.length * (0.82f + 0.3f * unit(0));
    lock.layer = style.layer * unit(1);
    lock.wave = 0.025f + 0.045f * unit(2);
    lock.turns = 9.0f + 6.0f * unit(3);
    lock.phase = glm::two_pi<float>() * unit(4);
    lock.gather = 0.6f + 0.35f * unit(5);
    const float side = lock.direction.x < kPart ? -1.0f : 1.0f;
    lock.rest = {side * (0.6f + 0.12f * unit(6)), 0.46f + 0.14f * unit(7)};
    // The way from the back of the head to the chest is longer.
    lock.length += 0.5f * glm::smoothstep(0.2f, -0.8f, lock.direction.z);
    lock.guide = fall(bust, style, {lock.direction, lock.length, lock.layer, lock.rest});
    return lock;
}

void grow_strand(std::uint64_t seed, std::uint32_t index, const std::vector<Lock>& locks,
                 const HairStyle& style, const BlobBody& bust, HairStrands& hair) {
    const std::uint64_t key = mix64(seed ^ (kStrandStream << 32) ^ index);
    const auto chosen = static_cast<std::uint32_t>(random_unit(key, 0) * static_cast<float>(kLocks));
    const Lock& lock = locks[chosen];
    hair.locks[index] = chosen;
    // A strand stays on its lock's side of the parting.
    const float side = lock.direction.x < kPart ? -1.0f : 1.0f;
    const glm::vec3 scatter = random_direction(key, 1) * std::sqrt(random_unit(key, 3));
    glm::vec3 direction = glm::normalize(lock.direction + 0.11f * scatter);
    if (side * (direction.x - kPart) < 0) direction.x = 2 * kPart - direction.x;
    direction = glm::normalize(direction);
    const bool stray = random_unit(key, 7) > 0.95f;
    const float length = lock.length * (0.78f + 0.26f * random_unit(key, 4));
    const float layer = std::max(
        0.02f, lock.layer + style.layer * 0.5f * (random_unit(key, 5) - 0.5f) + (stray ? 0.12f : 0.0f));
    const Strand strand =
        fall(bust, style, {direction, length, layer, lock.rest + 0.05f * glm::vec2(scatter)});
    const glm::vec3 place = random_direction(key, 8) * std::cbrt(random_unit(key, 10));
    const float phase = lock.phase + 1.1f * (random_unit(key, 6) - 0.5f);
    const float gather = stray ? 0.0f : lock.gather;
    for (std::size_t i = 0; i < strand.size(); ++i) {
        const float t = static_cast<float>(i) / static_cast<float>(strand.size() - 1);
        const float angle = phase + lock.turns * t;
        const float wave = lock.wave * glm::smoothstep(0.15f, 0.7f, t);
        glm::vec3 point =
            glm::mix(strand[i], lock.guide[i] + 0.07f * place, gather * glm::smoothstep(0.25f, 1.0f, t));
        point += wave * glm::vec3(std::cos(angle), 0.0f, std::sin(angle));
        point += (stray ? 0.25f : 0.05f) * t * place;
        // The sway runs down the strand as a wave that all locks see at their own time.
        point += style.gust * t * t *
                 glm::vec3(0, std::sin(5.0f * t + lock.phase), std::cos(4.0f * t + 2.0f * lock.phase));
        hair.points[static_cast<std::size_t>(index) * kStrandPoints + i] = point;
    }
}

}  // namespace

HairStrands grow_hair(std::uint32_t count, std::uint64_t seed, const HairStyle& style) {
    const BlobBody bust = bust_obstacle();
    std::vector<Lock> locks(kLocks);
    parallel_for(default_threads(), static_cast<int>(kLocks), [&](int lock) {
        locks[static_cast<std::size_t>(lock)] =
            make_lock(seed, static_cast<std::uint32_t>(lock), style, bust);
    });
    HairStrands hair;
    hair.points.resize(static_cast<std::size_t>(count) * kStrandPoints);
    hair.locks.resize(count);
    constexpr std::uint32_t kBatch = 256;
    const auto batches = static_cast<int>((count + kBatch - 1) / kBatch);
    parallel_for(default_threads(), batches, [&](int batch) {
        const std::uint32_t first = static_cast<std::uint32_t>(batch) * kBatch;
        for (std::uint32_t i = first; i < std::min(first + kBatch, count); ++i)
            grow_strand(seed, i, locks, style, bust, hair);
    });
    return hair;
}

}  // namespace ropsim
