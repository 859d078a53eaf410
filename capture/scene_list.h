// The scenes that can be captured by name, what published measurements they answer to, and files that become
// scenes.
#pragma once

#include "capture/scene.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ropsim {

// What a paper prints about its own version of a scene.
struct PublishedScene {
    std::string paper = "";                             // short title and year; empty: the scene is ours
    std::string place = "";                             // figure or table
    std::optional<double> fragments = std::nullopt;     // transparent
    std::optional<double> deepest = std::nullopt;       // fragments of the deepest pixel
    std::optional<double> fragments_4x = std::nullopt;  // the same two with 4 spatial samples
    std::optional<double> deepest_4x = std::nullopt;
    std::optional<std::uint64_t> primitives = std::nullopt;
    std::string primitive_name = "";  // what is counted: triangles, hairs, particles
};

struct SceneInfo {
    std::string name;
    std::string summary;
    PublishedScene published = {};
    int width = 1280;  // default size, pixels
    int height = 720;
    // `aspect` is width / height. Throws UserError where an asset is missing.
    std::unique_ptr<SceneSource> (*make)(double aspect, std::uint64_t seed) = nullptr;
};

// The built-in scenes.
const std::vector<SceneInfo>& scene_list();

// One source per scene, in capture/scenes/.
std::unique_ptr<SceneSource> make_horse_scene(double aspect, std::uint64_t seed);
std::unique_ptr<SceneSource> make_bunny_scene(double aspect, std::uint64_t seed);
std::unique_ptr<SceneSource> make_hair_scene(double aspect, std::uint64_t seed);
std::unique_ptr<SceneSource> make_dog_scene(double aspect, std::uint64_t seed);
std::unique_ptr<SceneSource> make_windy_hill_scene(double aspect, std::uint64_t seed);
std::unique_ptr<SceneSource> make_plume_scene(double aspect, std::uint64_t seed);
std::unique_ptr<SceneSource> make_smoke_scene(double aspect, std::uint64_t seed);
std::unique_ptr<SceneSource> make_forest_scene(double aspect, std::uint64_t seed);
std::unique_ptr<SceneSource> make_power_plant_scene(double aspect, std::uint64_t seed);
std::unique_ptr<SceneSource> make_splats_scene(double aspect, std::uint64_t seed);
std::unique_ptr<SceneSource> make_motor_scene(double aspect, std::uint64_t seed);
std::unique_ptr<SceneSource> make_cloth_scene(double aspect, std::uint64_t seed);
std::unique_ptr<SceneSource> make_glass_scene(double aspect, std::uint64_t seed);
std::unique_ptr<SceneSource> make_engine_scene(double aspect, std::uint64_t seed);
std::unique_ptr<SceneSource> make_bottles_scene(double aspect, std::uint64_t seed);
std::unique_ptr<SceneSource> make_fog_scene(double aspect, std::uint64_t seed);
std::unique_ptr<SceneSource> make_panes_scene(double aspect, std::uint64_t seed);

// Sources from files. Throw UserError when the file is missing, unreadable, or holds nothing to draw.
std::unique_ptr<SceneSource> make_splat_file_scene(const std::string& path, double aspect,
                                                   std::uint64_t seed);
std::unique_ptr<SceneSource> make_hair_file_scene(const std::string& path, double aspect, std::uint64_t seed);
std::unique_ptr<SceneSource> make_mesh_scene(const std::string& path, double aspect, std::uint64_t seed);

}  // namespace ropsim
