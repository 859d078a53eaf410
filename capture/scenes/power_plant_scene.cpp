// Scene: the designer's model of a power plant: frame, floors, boiler, pipework, ducts, all see-through.
#include "base/error.h"
#include "capture/scene_list.h"
#include "capture/scenery/scene_parts.h"
#include "capture/scenery/sky_dome.h"
#include "capture/scenes/power_plant_parts.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ropsim {
namespace {

constexpr double kPipes = 63;
constexpr double kMaxPipes = 15000;  // what fits into a GPU buffer of 128 MiB
// All fragments over those of the pipework, at scale 1: beyond it only pipes are added.
constexpr double kPipesForAll = 5.32;

// A share of the parts, spread over all of them: of the last one, a share of its triangles. A smaller share
// is part of a larger one.
SceneryMesh first_parts(const PlantParts& parts, double share) {
    std::vector<std::size_t> order(parts.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    if (share < 1) {
        const auto rank = [](std::size_t i) { return std::fmod(0.6180339887 * static_cast<double>(i), 1.0); };
        std::sort(order.begin(), order.end(),
                  [&](std::size_t a, std::size_t b) { return rank(a) < rank(b); });
    }
    const double wanted = share * static_cast<double>(parts.size());
    SceneryMesh mesh;
    for (std::size_t i = 0; i < parts.size() && static_cast<double>(i) < wanted; ++i) {
        mesh.add(parts[order[i]], glm::mat4(1.0f));
        const double of_this = std::min(wanted - static_cast<double>(i), 1.0);
        const std::uint32_t all = parts[order[i]].triangles();
        const auto kept = static_cast<std::uint32_t>(std::lround(of_this * all));
        mesh.indices.resize(mesh.indices.size() - std::size_t{3} * (all - kept));
    }
    return mesh;
}

class PowerPlantScene final : public SceneSource {
 public:
    PowerPlantScene(double aspect, std::uint64_t seed) : aspect_(aspect), seed_(seed) {
        daylight_.haze = {0.74f, 0.77f, 0.8f};
        daylight_.haze_extinction = 0.0006f;
        daylight_.sun = {0.95f, 0.9f, 0.8f};
        daylight_.sky = {0.36f, 0.39f, 0.44f};
    }

    Scene build(const SceneScale& scale) const override {
        const double more = scale.count > 1 ? 1 + (scale.count - 1) * kPipesForAll : 1.0;
        const double pipes = std::round(kPipes * more);
        if (pipes > kMaxPipes) {
            throw UserError("--fragments",
                            fmt::format("the plant would need {:.0f} pipes, more than {:.0f}; ask for fewer "
                                        "fragments or use a larger --size",
                                        pipes, kMaxPipes));
        }
        const double share = std::min(scale.count, 1.0);
        Scene scene;
        scene.camera = look_at({26.0f, 27.0f, 66.0f}, {-0.5f, 12.2f, 0.0f}, 31.0f, aspect_, 1.5, 20.0f, 400);
        scene.light = light_camera(light_direction(), {0, 14, 0}, 52.0f);
        scene.background = daylight_.haze;
        scene.opaque.push_back(
            scenery_draw("sky", sky_dome(daylight_, {0.42f, 0.55f, 0.72f}, 300, seed_), daylight_, seed_));
        scene.opaque.push_back(scenery_draw("ground", ground(), daylight_, seed_));
        std::uint32_t triangles = 0;
        const auto add = [&](const char* name, const PlantParts& parts) {
            const SceneryMesh mesh = first_parts(parts, share);
            triangles += mesh.triangles();
            scene.transparent.push_back(film_draw(name, mesh, daylight_));
        };
        // System by system, as such models are kept: in no order of depth.
        add("hall", make_hall());
        add("pipework", make_pipework(static_cast<std::uint32_t>(pipes), seed_));
        add("frame", make_frame());
        add("vessels", make_vessels());
        add("boiler", make_boiler());
        add("cladding", make_cladding());
        add("ducts", make_ducts());
        add("floors", make_floors(seed_));
        // Of few things, none may be of a kind.
        std::erase_if(scene.transparent, [](const SceneDraw& draw) { return draw.primitives == 0; });
        scene.description = fmt::format("a power plant, {} triangles", triangles);
        return scene;
    }

 private:
    static SceneryMesh ground() {
        SceneryMesh mesh;
        const glm::vec4 grass(0.2f, 0.235f, 0.11f, 1);
        mesh.add_quad({-280, -0.05f, 100}, {280, -0.05f, 100}, {280, -0.05f, -280}, {-280, -0.05f, -280},
                      grass, Finish::kPlain);
        mesh.add_quad({-42, -0.02f, 26}, {44, -0.02f, 26}, {44, -0.02f, -22}, {-42, -0.02f, -22},
                      {0.36f, 0.355f, 0.345f, 1});
        return mesh;
    }

    double aspect_;
    std::uint64_t seed_;
    Daylight daylight_;
};

}  // namespace

std::unique_ptr<SceneSource> make_power_plant_scene(double aspect, std::uint64_t seed) {
    return std::make_unique<PowerPlantScene>(aspect, seed);
}

}  // namespace ropsim
