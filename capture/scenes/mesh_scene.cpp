// Scene: many translucent copies of one mesh, standing in each other on a checkered floor.
#include "base/error.h"
#include "base/random.h"
#include "capture/scene_list.h"
#include "capture/scenery/scene_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/gtc/constants.hpp>

namespace ropsim {
namespace {

constexpr const char* kModels = "/usr/share/glmark2/models";  // Debian's glmark2-data
constexpr double kBaseInstances = 10;
constexpr double kMaxInstances = 4e6;
constexpr float kMeshSize = 1.5f;  // longest side of a copy, metres
constexpr float kSpreadX = 0.4f;   // how far copies stand from the middle, metres
constexpr float kSpreadZ = 0.8f;
constexpr float kFacing = -0.5f;  // turn of every copy from its pose in the file, radians
constexpr float kYaw = 0.22f;     // how far copies turn from that or its opposite, radians

// Colour of a hue in [0, 1), full saturation softened, linear.
glm::vec3 hue_color(float hue) {
    const auto channel = [&](float shift) {
        return 0.5f + 0.5f * std::cos(glm::two_pi<float>() * (hue + shift));
    };
    return glm::vec3(0.06f) + 0.84f * glm::vec3(channel(0.0f), channel(-1.0f / 3), channel(1.0f / 3));
}

class MeshScene final : public SceneSource {
 public:
    MeshScene(const std::string& path, double aspect, std::uint64_t seed)
        : path_(path), mesh_(load_mesh(path)), aspect_(aspect), seed_(seed) {
        minimum_fragments_per_pixel = 1.25e6 / (1280.0 * 720.0);
        minimum_mean_layers = 8.4;
        shrinks = true;
        float highest = -std::numeric_limits<float>::infinity();
        lowest_ = -highest;
        for (const glm::vec3& position : mesh_.positions) {
            lowest_ = std::min(lowest_, position.y);
            highest = std::max(highest, position.y);
        }
        height_ = highest - lowest_;
    }

    Scene build(const SceneScale& scale) const override {
        const double wanted = std::round(kBaseInstances * scale.count);
        if (wanted > kMaxInstances) {
            throw UserError("--fragments",
                            fmt::format("'{}' would need {:.0f} copies, more than {:.0f}; ask for fewer "
                                        "fragments or use a larger --size",
                                        path_, wanted, kMaxInstances));
        }
        const auto count = static_cast<std::uint32_t>(std::max(wanted, 1.0));
        Scene scene;
        scene.description = fmt::format("{} translucent copies of {}", count, path_);
        scene.camera = look_at({0.5f, 0.9f + height_, 4.8f}, {0, 0.46f * height_ * kMeshSize, 0},
                               18 + 9 * height_, aspect_, 1.5, 0.5f, 20);
        scene.light = light_camera(light_direction(), {0, 0.5f * kMeshSize, 0}, 2.2f * kMeshSize);
        scene.background = {0.55f, 0.62f, 0.7f};
        const TriangleMesh box = box_mesh();
        scene.opaque.push_back(
            matte_draw("room", box,
                       {{placed({0, -0.05f, 0}, {9, 0.05f, 5}), {0.62f, 0.6f, 0.56f, 0.5f}},
                        {placed({0, 2.0f, -5}, {9, 2.1f, 0.05f}), {0.5f, 0.55f, 0.6f, 0.0f}},
                        {placed({-1.25f, 0.5f, -0.75f}, {0.13f, 0.5f, 0.13f}), {0.75f, 0.7f, 0.62f, 0.0f}},
                        {placed({1.2f, 0.35f, -0.9f}, {0.13f, 0.35f, 0.13f}), {0.75f, 0.7f, 0.62f, 0.0f}}}));
        scene.opaque.push_back(
            matte_draw("ball", sphere_mesh(48),
                       {{placed({0.38f, 0.22f, -0.15f}, glm::vec3(0.22f)), {0.8f, 0.32f, 0.1f, 0.0f}}}));
        std::vector<MeshInstance> copies;
        copies.reserve(count);
        for (std::uint32_t i = 0; i < count; ++i) copies.push_back(copy(i, static_cast<float>(scale.size)));
        scene.transparent.push_back(glass_draw("copies", mesh_, copies));
        return scene;
    }

 private:
    MeshInstance copy(std::uint32_t index, float size) const {
        const std::uint64_t key = mix64(seed_ * 0x100000001B3ull + index);
        const float angle = glm::two_pi<float>() * random_unit(key, 0);
        const float radius = std::sqrt(random_unit(key, 1));
        const float side = size * kMeshSize * (0.8f + 0.3f * random_unit(key, 2));
        const glm::vec3 position(size * kSpreadX * radius * std::cos(angle), -lowest_ * side,
                                 size * kSpreadZ * radius * std::sin(angle));
        const float turn = kYaw * (2 * random_unit(key, 3) - 1);
        const float yaw = kFacing + turn + (random_unit(key, 6) < 0.1f ? glm::pi<float>() : 0.0f);
        MeshInstance result;
        result.model = placed(position, glm::vec3(side), yaw);
        // Golden-ratio steps give neighbours in the list distant hues.
        const float hue =
            std::fmod(0.61803399f * static_cast<float>(index % 4096) + random_unit(key, 4) * 0.1f, 1.0f);
        result.color = glm::vec4(hue_color(hue), 0.1f + 0.3f * random_unit(key, 5));
        return result;
    }

    std::string path_;
    TriangleMesh mesh_;
    double aspect_;
    std::uint64_t seed_;
    float lowest_;  // of the mesh, y
    float height_;
};

}  // namespace

std::unique_ptr<SceneSource> make_mesh_scene(const std::string& path, double aspect, std::uint64_t seed) {
    return std::make_unique<MeshScene>(path, aspect, seed);
}

std::unique_ptr<SceneSource> make_horse_scene(double aspect, std::uint64_t seed) {
    return make_mesh_scene(std::string(kModels) + "/horse.3ds", aspect, seed);
}

std::unique_ptr<SceneSource> make_bunny_scene(double aspect, std::uint64_t seed) {
    return make_mesh_scene(std::string(kModels) + "/bunny.obj", aspect, seed);
}

}  // namespace ropsim
