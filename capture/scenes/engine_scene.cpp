// Scene: a car engine in the manner of a CAD program, every part translucent (McGuire and Mara 2017, Fig.
// 20).
//
// Materials: partial coverage only, as the paper says of this scene: nothing transmitted by the covered part,
// no refraction, no diffusion; colour is the part's own, lit.
#include "base/error.h"
#include "capture/geometry/swept_mesh.h"
#include "capture/scene_list.h"
#include "capture/scenery/scene_parts.h"
#include "capture/scenes/engine_parts.h"
#include "capture/shader_sources.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

constexpr double kMaxEngines = 20'000;
constexpr float kFloor = -0.21f;
constexpr glm::vec3 kMiddle(-0.01f, 0.12f, 0.01f);  // of the engine

class EngineScene final : public SceneSource {
 public:
    EngineScene(double aspect, std::uint64_t /*seed*/) : aspect_(aspect) {
        shrinks = true;
        for (const EnginePart& part :
             joined({engine_outside(), engine_castings(), engine_manifolds(), engine_train()})) {
            for (const EnginePlace& place : part.copies)
                append_mesh(group_of(place.finish).mesh, part.mesh, place.model);
        }
    }

    Scene build(const SceneScale& scale) const override {
        if (scale.count > kMaxEngines) {
            throw UserError("--fragments",
                            fmt::format("'engine' would need {:.0f} engines, more than {:.0f}; ask for fewer "
                                        "fragments or use a larger --size",
                                        scale.count, kMaxEngines));
        }
        const int engines = std::max(1, static_cast<int>(std::lround(scale.count)));
        Scene scene;
        scene.description =
            fmt::format("{} car engine{} of translucent parts", engines, engines > 1 ? "s" : "");
        scene.materials = true;
        scene.camera = look_at({-0.78f, 0.55f, 0.86f}, {0.0f, 0.118f, 0.03f}, 33, aspect_, 1.3, 0.2f, 12);
        scene.light = light_camera(light_direction(), kMiddle, 0.6f);
        scene.background = {0.62f, 0.68f, 0.74f};
        scene.opaque.push_back(
            matte_draw("floor", box_mesh(),
                       {{placed({0, kFloor - 0.02f, 0}, {3.0f, 0.02f, 3.0f}), {0.72f, 0.75f, 0.78f, 0.0f}}}));
        for (const Group& group : groups_) {
            std::vector<MeshInstance> copies;
            for (int i = 0; i < engines; ++i)
                copies.push_back({engine_place(i, static_cast<float>(scale.size)), group.finish.color});
            scene.transparent.push_back(matte_draw(group.finish.name, group.mesh, copies));
            scene.transparent.back().shading = shader_source("cad_shading");
        }
        return scene;
    }

 private:
    // All parts of a finish, merged: there are many, and small.
    struct Group {
        EngineFinish finish;
        TriangleMesh mesh;
    };

    Group& group_of(const EngineFinish& finish) {
        for (Group& group : groups_)
            if (std::string_view(group.finish.name) == finish.name) return group;
        groups_.push_back({finish, {}});
        return groups_.back();
    }

    // About its middle; further engines stand about the first.
    static glm::mat4 engine_place(int index, float size) {
        const float angle = 2.4f * static_cast<float>(index);
        const float away = 0.16f * std::sqrt(static_cast<float>(index));
        const glm::vec3 aside(away * std::cos(angle), 0, away * std::sin(angle));
        return glm::scale(glm::translate(glm::mat4(1.0f), kMiddle + size * aside), glm::vec3(size)) *
               glm::translate(glm::mat4(1.0f), -kMiddle);
    }

    double aspect_;
    std::vector<Group> groups_;
};

}  // namespace

std::unique_ptr<SceneSource> make_engine_scene(double aspect, std::uint64_t seed) {
    return std::make_unique<EngineScene>(aspect, seed);
}

}  // namespace ropsim
