// Scene: a capture in 3D Gaussians, read from a .ply file.
#include "base/error.h"
#include "capture/files/splat_file.h"
#include "capture/scene_list.h"
#include "capture/scenery/scene_parts.h"
#include "capture/scenery/splat_draw.h"

#include <algorithm>
#include <cmath>

namespace ropsim {
namespace {

constexpr double kMaxSplats = 6.4e7;

// COLMAP's world, which training keeps, has y down and z away from the first camera; a turn about x makes it
// y up and z towards the viewer.
glm::vec3 turned(glm::vec3 v) {
    return {v.x, -v.y, -v.z};
}

class SplatFileScene final : public SceneSource {
 public:
    SplatFileScene(const std::string& path, double aspect, std::uint64_t seed)
        : path_(path), splats_(load_splats(path)), aspect_(aspect), seed_(seed) {
        // Captures have stray splats and a far background: the middle half of the centres says where the
        // subject is.
        for (int axis = 0; axis < 3; ++axis) {
            std::vector<float> values;
            values.reserve(splats_.size());
            for (const glm::vec3& p : splats_.positions) values.push_back(p[axis]);
            const auto quantile = [&](double q) {
                const auto at = static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
                std::nth_element(values.begin(), values.begin() + at, values.end());
                return values[static_cast<std::size_t>(at)];
            };
            centre_[axis] = quantile(0.5);
            half_[axis] = 0.5f * (quantile(0.75) - quantile(0.25));
        }
        // A single splat has no extent but its own.
        radius_ =
            std::max(glm::length(half_),
                     2 * std::max({splats_.scales[0].x, splats_.scales[0].y, splats_.scales[0].z, 1e-6f}));
        if (!std::isfinite(radius_) || !std::isfinite(glm::length(centre_))) {
            throw UserError(path, "the splats are too far apart for single precision; scale them down");
        }
    }

    Scene build(const SceneScale& scale) const override {
        if (scale.count * static_cast<double>(splats_.size()) > kMaxSplats) {
            throw UserError(
                "--fragments",
                fmt::format("'{}' would need {:.0f} splats, more than {:.0f}; ask for fewer "
                            "fragments or use a larger --size",
                            path_, scale.count * static_cast<double>(splats_.size()), kMaxSplats));
        }
        const SplatFile* shown = &splats_;
        SplatFile changed;
        if (scale.count != 1) {
            changed = thinned_or_cloned(splats_, scale.count, seed_);
            shown = &changed;
        }
        Scene scene;
        scene.description = fmt::format("{} splats of {}", shown->size(), path_);
        const glm::vec3 centre = turned(centre_);
        const glm::vec3 eye = centre + 3.0f * radius_ * glm::normalize(glm::vec3(0.35f, 0.35f, 1.0f));
        const auto turn = glm::mat4(1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1);
        scene.camera = look_at(eye, centre, 50, aspect_, 1.0, 0.05f * radius_, 400 * radius_);
        scene.camera.view = scene.camera.view * turn;
        scene.light = light_camera(light_direction(), centre, 40 * radius_);
        scene.light.view = scene.light.view * turn;
        scene.transparent = splat_draws("splats", *shown, turned(eye));
        return scene;
    }

 private:
    std::string path_;
    SplatFile splats_;
    double aspect_;
    std::uint64_t seed_;
    glm::vec3 centre_;  // of the subject, the file's world
    glm::vec3 half_;
    float radius_;
};

}  // namespace

std::unique_ptr<SceneSource> make_splat_file_scene(const std::string& path, double aspect,
                                                   std::uint64_t seed) {
    return std::make_unique<SplatFileScene>(path, aspect, seed);
}

}  // namespace ropsim
