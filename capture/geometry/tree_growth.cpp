// Trees: a trunk, branches to the middles of clumps, twigs about them.
#include "capture/geometry/tree_growth.h"

#include "base/parallel.h"
#include "base/random.h"
#include "capture/geometry/pipe_mesh.h"
#include "capture/scenery/scene_parts.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

glm::vec3 random_direction(std::uint64_t key, std::uint32_t draw) {
    const float y = 2 * random_unit(key, draw) - 1;
    const float phi = glm::two_pi<float>() * random_unit(key, draw + 1);
    const float r = std::sqrt(std::max(0.0f, 1 - y * y));
    return {r * std::cos(phi), y, r * std::sin(phi)};
}

struct Branch {
    glm::vec3 root;
    glm::vec3 tip;
    float spread;  // of the twigs about its outer part
};

Branch make_branch(const TreeForm& form, glm::vec3 foot, std::uint64_t seed, int index) {
    const std::uint64_t key = mix64(seed ^ (0x4272616Eull << 32) ^ static_cast<std::uint64_t>(index));
    const float angle = 2.4f * static_cast<float>(index) + 0.7f * random_unit(key, 0);
    const glm::vec3 out(std::cos(angle), 0, std::sin(angle));
    const float crown = form.height * (1 - form.crown_from);
    if (form.conifer) {
        const float t = (static_cast<float>(index) + 0.5f) / static_cast<float>(form.branches);
        const float length = form.crown_radius * (1.05f - t) * (0.75f + 0.35f * random_unit(key, 1));
        const glm::vec3 root = foot + glm::vec3(0, form.height * form.crown_from + crown * t, 0);
        return {root, root + length * (out + glm::vec3(0, 0.15f - 0.45f * (1 - t), 0)), 0.0f};
    }
    const float t = random_unit(key, 1);
    // Clumps stand on an egg about the middle of the crown.
    const float height = glm::mix(-0.8f, 0.95f, t);
    const float wide = form.crown_radius * std::sqrt(1 - 0.9f * height * height) *
                       (0.45f + 0.5f * std::sqrt(random_unit(key, 2)));
    const glm::vec3 middle = foot + glm::vec3(0, form.height * form.crown_from + 0.5f * crown, 0);
    const glm::vec3 tip = middle + wide * out + glm::vec3(0, 0.46f * crown * height, 0);
    const float leaves_trunk = form.height * glm::mix(0.7f * form.crown_from, 0.75f, 0.8f * t);
    return {foot + glm::vec3(0, leaves_trunk, 0), tip,
            form.crown_radius * (0.3f + 0.14f * random_unit(key, 3))};
}

void add_wood(const TreeForm& form, glm::vec3 foot, std::uint64_t seed, const std::vector<Branch>& branches,
              SceneryMesh& wood) {
    const std::uint64_t key = mix64(seed ^ (0x57006Full << 32));
    const float top = form.conifer ? 0.98f : 0.8f;
    std::vector<glm::vec3> path;
    std::vector<float> radii;
    for (int i = 0; i <= 8; ++i) {
        const float t = static_cast<float>(i) / 8;
        const auto draw = static_cast<std::uint32_t>(i);
        const float sway = form.conifer ? 0.01f : 0.035f * t;
        path.push_back(foot + glm::vec3(0, form.height * top * t - 0.1f, 0) +
                       sway * form.height *
                           glm::vec3(random_unit(key, draw) - 0.5f, 0, random_unit(key, 20 + draw) - 0.5f));
        radii.push_back(form.trunk_radius * (1.0f - 0.85f * t + 0.5f * std::exp(-14 * t)));
    }
    const glm::vec4 bark(form.bark, 1);
    wood.add(pipe_mesh(path, radii, {.sides = 10}), glm::mat4(1.0f), bark, Finish::kGround);
    for (const Branch& branch : branches) {
        const float length = glm::length(branch.tip - branch.root);
        const float radius = std::min(0.35f * form.trunk_radius, 0.011f * length + 0.006f);
        const glm::vec3 middle =
            glm::mix(branch.root, branch.tip, 0.5f) + glm::vec3(0, form.conifer ? 0.06f : -0.06f, 0) * length;
        const std::vector<glm::vec3> limb = {branch.root, middle, branch.tip};
        const std::vector<float> limb_radii = {radius, 0.7f * radius, 0.25f * radius};
        wood.add(pipe_mesh(limb, limb_radii, {.sides = 5}), glm::mat4(1.0f), bark, Finish::kGround);
    }
}

Card make_twig(const TreeForm& form, std::uint64_t seed, int index, const std::vector<Branch>& branches) {
    const std::uint64_t key = mix64(seed ^ (0x43617264ull << 32) ^ static_cast<std::uint64_t>(index));
    const auto pick = static_cast<std::size_t>(random_unit(key, 0) * static_cast<float>(branches.size()));
    const Branch& branch = branches[pick];
    const glm::vec3 limb = branch.tip - branch.root;
    Card card{};
    card.light = 1;
    card.columns = random_unit(key, 10) < 0.5f ? -1.0f : 1.0f;
    card.rows = 1;
    const float size = form.card_size * (0.7f + 0.6f * random_unit(key, 1));
    glm::vec3 up;
    glm::vec3 right;
    if (form.conifer) {
        // Sprays lie along the branch, flat, hanging a little; longer ones near the trunk.
        const float t = std::sqrt(random_unit(key, 2));
        card.centre = branch.root + (0.12f + 0.9f * t) * limb;
        up = glm::normalize(glm::normalize(limb) + 0.75f * random_direction(key, 3) - glm::vec3(0, 0.25f, 0));
        right = glm::cross(up, glm::vec3(0, 1, 0) + 0.7f * random_direction(key, 5));
    } else {
        const glm::vec3 off = random_direction(key, 3) * std::cbrt(random_unit(key, 5));
        card.centre = branch.tip + branch.spread * off * glm::vec3(1, 0.75f, 1) -
                      0.25f * random_unit(key, 2) * limb * (glm::length(off));
        up = glm::normalize(0.8f * off + random_direction(key, 6) + glm::vec3(0, 0.25f, 0));
        right = glm::cross(up, random_direction(key, 8));
    }
    right = glm::normalize(right + 1e-4f * glm::vec3(up.y, up.z, up.x));
    card.right = size * right;
    card.up = size * up;
    const float tone = 0.75f + 0.45f * random_unit(key, 11);
    card.color = glm::vec4(tone * (0.9f + 0.2f * random_unit(key, 12)), tone, tone * 0.95f, 1.0f);
    return card;
}

}  // namespace

void grow_tree(const TreeForm& form, glm::vec3 foot, std::uint64_t seed, SceneryMesh& wood,
               std::vector<Card>& twigs) {
    std::vector<Branch> branches;
    for (int i = 0; i < form.branches; ++i) branches.push_back(make_branch(form, foot, seed, i));
    if (form.trunk_radius > 0) add_wood(form, foot, seed, branches, wood);
    for (int i = 0; i < form.cards; ++i) {
        twigs.push_back(make_twig(form, seed, i, branches));
        // A bush stands on the ground, not in it.
        Card& twig = twigs.back();
        if (form.trunk_radius == 0)
            twig.centre.y = std::max(twig.centre.y, foot.y + 0.5f * glm::length(twig.up));
    }
}

void deposit_cards(const std::vector<Card>& cards, float cover, LightVolume& volume) {
    for (const Card& card : cards)
        volume.deposit(card.centre, cover * 4 * glm::length(card.right) * glm::length(card.up));
}

void illuminate_cards(std::vector<Card>& cards, const LightVolume& volume, float strength) {
    constexpr std::size_t kBatch = 1024;
    const auto batches = static_cast<int>((cards.size() + kBatch - 1) / kBatch);
    const glm::vec3 sun = light_direction();
    parallel_for(default_threads(), batches, [&](int batch) {
        const std::size_t first = static_cast<std::size_t>(batch) * kBatch;
        for (std::size_t i = first; i < std::min(first + kBatch, cards.size()); ++i) {
            Card& card = cards[i];
            const float facing = std::abs(glm::dot(glm::normalize(glm::cross(card.right, card.up)), sun));
            card.light = volume.transmittance(card.centre, strength) * (0.35f + 0.65f * facing);
        }
    });
}

}  // namespace ropsim
