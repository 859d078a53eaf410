// Scene: a geared electric motor, all of it white and seen through.
#include "base/error.h"
#include "capture/scene_list.h"
#include "capture/scenery/scene_parts.h"
#include "capture/scenes/motor_parts.h"
#include "capture/shader_sources.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/matrix_transform.hpp>

namespace ropsim {
namespace {

constexpr std::uint32_t kTriangles = 322000;  // of the model of Enderton et al. 2011, Fig. 2
constexpr float kAlpha = 0.3f;
constexpr double kMaxMotors = 4000;
const glm::vec3 to_light = glm::normalize(glm::vec3(-0.6f, 0.75f, 0.4f));  // across the view, for relief

class MotorScene final : public SceneSource {
 public:
    explicit MotorScene(double aspect) : aspect_(aspect) {
        shrinks = true;
        assemblies_ = motor_assemblies();
        refine_to(assemblies_, kTriangles);
    }

    Scene build(const SceneScale& scale) const override {
        if (scale.count > kMaxMotors) {
            throw UserError("--fragments",
                            fmt::format("{:.0f} motors would be needed, more than {:.0f}; ask for fewer "
                                        "fragments or use a larger --size",
                                        scale.count, kMaxMotors));
        }
        const int count = std::max(static_cast<int>(std::lround(scale.count)), 1);
        Scene scene;
        scene.description = fmt::format("{} motor{} of {} triangles, alpha {}", count, count == 1 ? "" : "s",
                                        kTriangles, kAlpha);
        scene.camera = look_at({4.6f, 3.1f, 6.6f}, {0.42f, 0.02f, 0}, 33, aspect_, 1.0, 2.0f, 40);
        scene.camera.metres_per_unit = 0.1f;
        scene.light = light_camera(to_light, glm::vec3(0.4f, 0, 0), 3.6f);
        scene.background = {0.035f, 0.05f, 0.075f};
        for (const MotorAssembly& assembly : assemblies_) {
            std::vector<MeshInstance> copies;
            for (int i = 0; i < count; ++i) copies.push_back(copy(i, static_cast<float>(scale.size)));
            SceneDraw draw = matte_draw(assembly.name, assembly.mesh, copies);
            draw.shading = shader_source("diffuse_shading");
            draw.parameters = {glm::vec4(to_light, 0)};
            scene.transparent.push_back(std::move(draw));
        }
        return scene;
    }

 private:
    // More motors stand in one another, each turned a little further about the vertical.
    static MeshInstance copy(int index, float size) {
        MeshInstance result;
        result.model = placed(glm::vec3(0), glm::vec3(size), 0.7f * static_cast<float>(index));
        result.color = glm::vec4(1, 1, 1, kAlpha);
        return result;
    }

    double aspect_;
    std::vector<MotorAssembly> assemblies_;
};

}  // namespace

// The machine is the same for every seed.
std::unique_ptr<SceneSource> make_motor_scene(double aspect, std::uint64_t) {
    return std::make_unique<MotorScene>(aspect);
}

}  // namespace ropsim
