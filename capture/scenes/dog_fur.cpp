// Every hair leaves the skin between its normal and the way it is smoothed, bends down, and gathers with its
// neighbours into tufts.
#include "capture/scenes/dog_fur.h"

#include "base/parallel.h"
#include "base/random.h"
#include "capture/scenes/dog_body.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

constexpr std::uint64_t kFurStream = 0x446F6746u;
constexpr float kTuft = 0.24f;  // side of the cells that hold a tuft each, decimetres
constexpr float kHalfWidth = 0.0075f;
constexpr std::uint32_t kMostPoints = 8;

struct Kind {
    const char* name;
    std::uint32_t points;
    float longest;  // hairs up to this length, decimetres
};
constexpr Kind kKinds[] = {{"short fur", 4, 0.28f}, {"coat", 6, 0.62f}, {"feathering", kMostPoints, 1e6f}};
constexpr std::size_t kKindCount = std::size(kKinds);

// Draws places on a mesh evenly by area.
class SkinSampler {
 public:
    explicit SkinSampler(const TriangleMesh& mesh) : mesh_(mesh) {
        double sum = 0;
        for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
            const auto corner = [&](std::size_t k) { return mesh.positions[mesh.indices[i + k]]; };
            sum += glm::length(glm::cross(corner(1) - corner(0), corner(2) - corner(0)));
            areas_.push_back(sum);
        }
    }
    // Position and normal for a random key.
    std::pair<glm::vec3, glm::vec3> place(std::uint64_t key) const {
        const double wanted = (random_bits(key, 0) + 0.5) * 0x1p-32 * areas_.back();
        const auto found = std::lower_bound(areas_.begin(), areas_.end(), wanted);
        const auto triangle = static_cast<std::size_t>(found - areas_.begin());
        float u = random_unit(key, 1);
        float v = random_unit(key, 2);
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        const std::uint32_t* i = &mesh_.indices[3 * triangle];
        const auto blend = [&](const std::vector<glm::vec3>& of) {
            return (1 - u - v) * of[i[0]] + u * of[i[1]] + v * of[i[2]];
        };
        return {blend(mesh_.positions), glm::normalize(blend(mesh_.normals))};
    }

 private:
    const TriangleMesh& mesh_;
    std::vector<double> areas_;  // running sums
};

// The middle of the tuft that a place belongs to: the nearest of one random point a cell.
glm::vec3 tuft_of(glm::vec3 position) {
    const glm::ivec3 cell(glm::floor(position / kTuft));
    glm::vec3 nearest(0);
    float least = std::numeric_limits<float>::infinity();
    for (int i = 0; i < 27; ++i) {
        const glm::ivec3 c = cell + glm::ivec3(i % 3, i / 3 % 3, i / 9) - 1;
        const std::uint64_t key =
            mix64((static_cast<std::uint64_t>(c.x + 512) << 40) ^
                  (static_cast<std::uint64_t>(c.y + 512) << 20) ^ static_cast<std::uint64_t>(c.z + 512));
        const glm::vec3 centre =
            kTuft * (glm::vec3(c) + glm::vec3(random_unit(key, 0), random_unit(key, 1), random_unit(key, 2)));
        const glm::vec3 away = centre - position;
        const float distance = glm::dot(away, away);
        if (distance < least) {
            least = distance;
            nearest = centre;
        }
    }
    return nearest;
}

struct Growth {
    float length;
    glm::vec3 flow;
};

// Length and direction of the fur at a place: a blend over the parts nearby, and what tells front from rear.
Growth growth_at(const std::vector<BlobBody>& bodies, glm::vec3 position, glm::vec3 normal) {
    const std::vector<DogPart>& parts = dog_parts();
    float weights = 1e-6f;
    Growth growth{0, glm::vec3(0)};
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const float weight = std::exp(-std::max(bodies[i].distance(position), 0.0f) / 0.12f);
        weights += weight;
        growth.length += weight * parts[i].fur;
        growth.flow += weight * parts[i].flow;
    }
    growth.length /= weights;
    growth.flow = glm::normalize(growth.flow - normal * glm::dot(growth.flow, normal) + 1e-4f);
    const glm::vec3& p = position;
    const bool on_leg = p.y < 3.6f && p.y > 0.6f;
    // Feathering behind the legs and breeches, a fringe under belly and tail.
    if (on_leg)
        growth.length *=
            1.0f + 1.8f * glm::smoothstep(0.2f, 0.9f, -normal.x) * glm::smoothstep(0.6f, 2.2f, p.y);
    if (p.y > 3 && p.y < 4.6f && p.x < 2.4f)
        growth.length *= 1.0f + 0.5f * glm::smoothstep(0.3f, 0.9f, -normal.y);
    // Shorn under the collar and around the eyes.
    const float along_neck = glm::dot(p - kCollarCentre, kCollarAxis);
    if (glm::distance(p, kCollarCentre) < 1.2f)
        growth.length *= 0.3f + 0.7f * glm::smoothstep(0.1f, 0.4f, std::fabs(along_neck));
    const float eye = glm::distance(glm::vec3(p.x, p.y, std::fabs(p.z)), glm::vec3(4.28f, 6.65f, 0.31f));
    growth.length *= 0.25f + 0.75f * glm::smoothstep(0.15f, 0.3f, eye);
    const float nose = glm::distance(p, glm::vec3(5.23f, 6.32f, 0));
    growth.length *= 0.3f + 0.7f * glm::smoothstep(0.2f, 0.4f, nose);
    return growth;
}

struct Hair {
    std::size_t kind;
    std::array<glm::vec3, kMostPoints> points;
    glm::vec4 look;
};

Hair grow_hair(const SkinSampler& skin, const std::vector<BlobBody>& bodies, std::uint64_t key) {
    const auto [root, normal] = skin.place(key);
    const Growth growth = growth_at(bodies, root, normal);
    const float length = growth.length * (0.6f + 0.5f * random_unit(key, 3));
    Hair hair;
    hair.kind = 0;
    while (length > kKinds[hair.kind].longest) ++hair.kind;
    const std::uint32_t points = kKinds[hair.kind].points;
    const float step = length / static_cast<float>(points - 1);
    const glm::vec3 stray = glm::vec3(random_unit(key, 4), random_unit(key, 5), random_unit(key, 6)) - 0.5f;
    const glm::vec3 tuft = tuft_of(root);
    // Waves of the coat: smooth over the body, and the same within a tuft.
    const glm::vec3 wave(std::sin(5 * tuft.y + 3 * tuft.z), std::sin(4 * tuft.x + 2 * tuft.y),
                         std::sin(6 * tuft.x - 3 * tuft.y));
    const float lift = 0.65f + 0.4f * random_unit(key, 7);
    glm::vec3 heading = glm::normalize(growth.flow + lift * normal + 0.45f * stray + 0.22f * wave);
    glm::vec3 at = root;
    for (std::uint32_t i = 0; i < points; ++i) {
        hair.points[i] = at;
        const float t = static_cast<float>(i) / static_cast<float>(points - 1);
        const glm::vec3 gather = tuft - root - normal * glm::dot(tuft - root, normal);
        at += step * heading + (0.55f * t / static_cast<float>(points - 1)) * gather;
        heading = glm::normalize(heading + (1.1f * step) * glm::vec3(0, -1, 0) +
                                 (0.35f * t) * (growth.flow - 0.3f * normal) +
                                 0.12f * std::sin(6.0f * t + 9.0f * tuft.x) * wave);
    }
    const float shade =
        0.75f + 0.35f * random_unit(key, 8) +
        0.2f * (random_unit(mix64(static_cast<std::uint64_t>(static_cast<std::int64_t>(1e4f * tuft.x))), 0) -
                0.5f);
    const float noise = dog_noise(root) + 0.8f * (random_unit(key, 9) - 0.5f);
    hair.look = glm::vec4(shade * dog_color(root, noise), 0.25f + 0.35f * random_unit(key, 10));
    return hair;
}

}  // namespace

float dog_noise(glm::vec3 p) {
    return 0.5f * (std::sin(3.1f * p.x + 2.3f * p.y) * std::cos(2.7f * p.z - 1.9f * p.x) +
                   std::sin(7.3f * p.y - 5.9f * p.z + 1) * std::cos(6.1f * p.x + 4.3f * p.z));
}

std::vector<StrandGroup> groom_dog(const TriangleMesh& skin, std::uint32_t count, std::uint64_t seed) {
    const SkinSampler sampler(skin);
    std::vector<BlobBody> bodies;
    for (const DogPart& part : dog_parts()) bodies.emplace_back(std::vector<Blob>{part.blob});
    std::vector<Hair> hairs(count);
    constexpr std::uint32_t kBatch = 1024;
    const auto batches = static_cast<int>((count + kBatch - 1) / kBatch);
    parallel_for(default_threads(), batches, [&](int batch) {
        const std::uint32_t first = static_cast<std::uint32_t>(batch) * kBatch;
        for (std::uint32_t i = first; i < std::min(first + kBatch, count); ++i)
            hairs[i] = grow_hair(sampler, bodies, mix64(seed ^ (kFurStream << 32) ^ i));
    });
    std::array<std::size_t, kKindCount> of_kind{};
    for (const Hair& hair : hairs) ++of_kind[hair.kind];
    std::vector<StrandGroup> groups(kKindCount);
    for (std::size_t k = 0; k < kKindCount; ++k) {
        groups[k].name = kKinds[k].name;
        groups[k].points_a_strand = kKinds[k].points;
        groups[k].half_width = kHalfWidth;
        groups[k].points.reserve(of_kind[k] * kKinds[k].points);
        groups[k].looks.reserve(of_kind[k]);
    }
    for (const Hair& hair : hairs) {
        StrandGroup& group = groups[hair.kind];
        group.points.insert(group.points.end(), hair.points.begin(),
                            hair.points.begin() + static_cast<std::ptrdiff_t>(group.points_a_strand));
        group.looks.push_back(hair.look);
    }
    std::erase_if(groups, [](const StrandGroup& group) { return group.looks.empty(); });
    return groups;
}

}  // namespace ropsim
