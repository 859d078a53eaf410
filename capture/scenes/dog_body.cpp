// A sable and white dog: trunk, head, legs and tail, and what is not covered by fur.
#include "capture/scenes/dog_body.h"

#include "capture/scenery/scene_parts.h"

#include <cmath>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

void add_legs(std::vector<DogPart>& parts) {
    const glm::vec3 down(-0.25f, -1, 0);
    for (float side : {-1.0f, 1.0f}) {
        // Left and right legs stand a little apart.
        const float ahead = 0.28f * side;
        const auto at = [&](float x, float y, float z) { return glm::vec3(x + ahead, y, side * z); };
        parts.push_back(
            {limb({2.0f, 4.3f, side * 0.5f}, at(1.6f, 3.0f, 0.6f), 0.62f, 0.34f, 0.3f), 0.4f, down});
        parts.push_back(
            {limb(at(1.6f, 3.0f, 0.6f), at(1.75f, 1.35f, 0.6f), 0.32f, 0.2f, 0.15f), 0.22f, down});
        parts.push_back(
            {limb(at(1.75f, 1.35f, 0.6f), at(1.85f, 0.3f, 0.6f), 0.2f, 0.19f, 0.1f), 0.14f, down});
        parts.push_back(
            {ellipsoid(at(2.05f, 0.2f, 0.6f), {0.38f, 0.21f, 0.27f}, 0.12f), 0.1f, {1, -0.4f, 0}});
        parts.push_back({limb({-1.8f, 4.2f, side * 0.42f}, at(-1.25f, 2.85f, 0.62f), 0.82f, 0.44f, 0.35f),
                         0.45f,
                         {-0.5f, -1, 0}});
        parts.push_back(
            {limb(at(-1.25f, 2.85f, 0.62f), at(-2.2f, 1.5f, 0.6f), 0.4f, 0.2f, 0.2f), 0.3f, down});
        parts.push_back(
            {limb(at(-2.2f, 1.5f, 0.6f), at(-2.05f, 0.3f, 0.6f), 0.19f, 0.19f, 0.1f), 0.14f, down});
        parts.push_back(
            {ellipsoid(at(-1.85f, 0.2f, 0.6f), {0.37f, 0.21f, 0.26f}, 0.12f), 0.1f, {1, -0.4f, 0}});
    }
}

void add_head(std::vector<DogPart>& parts) {
    parts.push_back({ellipsoid({3.72f, 6.55f, 0}, {0.72f, 0.58f, 0.58f}, 0.25f), 0.2f, {-1, 0.15f, 0}});
    parts.push_back({limb({4.1f, 6.42f, 0}, {5.02f, 6.24f, 0}, 0.38f, 0.25f, 0.22f), 0.09f, {-1, 0.1f, 0}});
    parts.push_back({limb({4.0f, 6.15f, 0}, {4.86f, 6.0f, 0}, 0.25f, 0.14f, 0.1f), 0.1f, {-1, -0.4f, 0}});
    for (float side : {-1.0f, 1.0f}) {
        parts.push_back({ellipsoid({3.8f, 6.3f, side * 0.34f}, {0.42f, 0.36f, 0.26f}, 0.2f),
                         0.3f,
                         {-1, -0.5f, side * 0.3f}});
        // Semi-erect ears with tips that fall forward.
        parts.push_back({limb({3.45f, 6.95f, side * 0.4f}, {3.42f, 7.5f, side * 0.6f}, 0.26f, 0.13f, 0.1f),
                         0.16f,
                         {-0.4f, 1, 0}});
        parts.push_back({limb({3.42f, 7.5f, side * 0.6f}, {3.72f, 7.42f, side * 0.72f}, 0.12f, 0.05f, 0.05f),
                         0.14f,
                         {1, -0.3f, 0}});
        Blob socket = ellipsoid({4.42f, 6.66f, side * 0.4f}, {0.2f, 0.13f, 0.16f}, 0.1f);
        socket.carved = true;
        parts.push_back({socket, 0.05f, {-1, 0, 0}});
    }
}

}  // namespace

const std::vector<DogPart>& dog_parts() {
    static const std::vector<DogPart> parts = [] {
        const glm::vec3 back(-1, -0.5f, 0);
        const glm::vec3 down(-0.4f, -1, 0);
        std::vector<DogPart> all = {
            {ellipsoid({1.2f, 4.2f, 0}, {1.65f, 1.08f, 0.86f}, 0.3f), 0.5f, back},
            {limb({0.8f, 4.25f, 0}, {-1.6f, 4.45f, 0}, 0.9f, 0.72f, 0.4f), 0.5f, back},
            {ellipsoid({-1.85f, 4.4f, 0}, {0.95f, 0.9f, 0.76f}, 0.4f), 0.55f, {-1, -0.7f, 0}},
            {ellipsoid({2.3f, 4.15f, 0}, {0.78f, 0.95f, 0.72f}, 0.4f), 0.85f, down},
            {limb({2.3f, 4.8f, 0}, {3.45f, 6.2f, 0}, 0.82f, 0.5f, 0.4f), 0.75f, {-0.8f, -1, 0}},
            {limb({-2.5f, 4.85f, 0}, {-3.5f, 4.25f, 0}, 0.26f, 0.2f, 0.2f), 0.8f, {-0.8f, -1, 0}},
            {limb({-3.5f, 4.25f, 0}, {-4.4f, 4.35f, 0}, 0.2f, 0.15f, 0.1f), 0.95f, {-1, -0.7f, 0}},
            {limb({-4.4f, 4.35f, 0}, {-5.0f, 4.85f, 0}, 0.15f, 0.08f, 0.1f), 0.8f, {-1, 0.1f, 0}},
        };
        add_legs(all);
        add_head(all);
        return all;
    }();
    return parts;
}

BlobBody dog_body() {
    std::vector<Blob> blobs;
    for (const DogPart& part : dog_parts()) blobs.push_back(part.blob);
    return BlobBody(std::move(blobs));
}

glm::vec3 dog_color(glm::vec3 p, float noise) {
    const glm::vec3 gold(0.5f, 0.23f, 0.075f);
    const glm::vec3 dark(0.09f, 0.045f, 0.025f);
    const glm::vec3 white(0.85f, 0.8f, 0.72f);
    const auto inside = [&](float depth) { return glm::smoothstep(-0.1f, 0.1f, depth + 0.12f * noise); };
    // Dark hairs along the back and on the ears.
    float saddle =
        glm::smoothstep(4.4f, 5.4f, p.y) * glm::smoothstep(2.6f, 1.6f, p.x) * (0.55f + 0.4f * noise);
    saddle = std::max(saddle, 0.8f * glm::smoothstep(6.95f, 7.25f, p.y));
    glm::vec3 color = glm::mix(gold, dark, glm::clamp(saddle, 0.0f, 0.9f));
    const float along_neck = glm::dot(p - kCollarCentre, kCollarAxis);
    const bool on_head = p.x > 3.3f && p.y > 5.75f;
    float patch = inside(0.75f - std::fabs(along_neck + 0.35f)) * (on_head ? 0.0f : 1.0f);
    patch = std::max(patch, inside(std::min(p.x - 1.9f, 4.7f - p.y)));  // chest
    patch = std::max(patch, inside(1.5f - p.y));                        // socks
    patch = std::max(patch, inside(-4.45f - p.x));                      // tip of the tail
    if (on_head) {
        patch = std::max(patch, inside(p.x - 4.5f));                                           // muzzle
        patch = std::max(patch, inside(std::min(6.1f - p.y, p.x - 3.5f)));                     // chin
        patch = std::max(patch, inside(0.11f - std::fabs(p.z)) * (p.x > 3.6f ? 1.0f : 0.0f));  // blaze
    }
    return glm::mix(color, white, patch);
}

std::vector<SceneDraw> dog_details() {
    const TriangleMesh ball = sphere_mesh(24);
    std::vector<MeshInstance> parts = {
        {placed({5.23f, 6.32f, 0}, {0.16f, 0.13f, 0.19f}), {0.012f, 0.01f, 0.01f, 0}},            // nose
        {placed({4.9f, 5.9f, 0}, {0.3f, 0.05f, 0.14f}, 0.0f, -0.75f), {0.55f, 0.13f, 0.14f, 0}},  // tongue
        {placed({3.22f, 4.78f, 0.0f}, {0.05f, 0.17f, 0.17f}, 0, 0.5f), {0.75f, 0.5f, 0.1f, 0}},   // tag
    };
    for (float side : {-1.0f, 1.0f}) {
        parts.push_back(
            {placed({4.28f, 6.65f, side * 0.31f}, {0.12f, 0.115f, 0.11f}), {0.02f, 0.01f, 0.006f, 0}});
        parts.push_back({placed({4.38f, 6.7f, side * 0.375f}, {0.03f, 0.03f, 0.03f}), {1.2f, 1.2f, 1.2f, 0}});
    }
    std::vector<Blob> ring;
    constexpr int kPieces = 28;
    const glm::vec3 across(kCollarAxis.y, -kCollarAxis.x, 0);
    const auto around = [&](int i) {
        const float angle = glm::two_pi<float>() * static_cast<float>(i) / static_cast<float>(kPieces);
        return kCollarCentre + 0.76f * (std::cos(angle) * across + std::sin(angle) * glm::vec3(0, 0, 1));
    };
    for (int i = 0; i < kPieces; ++i) ring.push_back(limb(around(i), around(i + 1), 0.11f, 0.11f, 0.01f));
    const TriangleMesh collar =
        BlobBody(std::move(ring)).mesh(kCollarCentre - 1.1f, kCollarCentre + 1.1f, 0.045f);
    return {matte_draw("face", ball, parts),
            matte_draw("collar", collar, {{glm::mat4(1.0f), {0.5f, 0.02f, 0.03f, 0}}})};
}

}  // namespace ropsim
