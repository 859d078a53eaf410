// Captures a scene's transparent fragments, opaque layer and camera into a trace.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace ropsim {

struct CaptureOptions {
    std::string scene_or_mesh;  // a name of scene_list(), or the path of a mesh file
    int width = 1280;           // pixels, 1 to 16384
    int height = 720;
    int samples = 1;  // spatial samples a pixel
    std::optional<std::uint64_t>
        fragments;  // about so many transparent fragments; absent: the scene's own amount
    std::uint64_t seed = 1;
};

struct CaptureSummary {
    std::string description;  // of the scene, as the trace records it
    std::string renderer;     // the OpenGL driver's name
    std::uint64_t fragments = 0;
    std::uint64_t pieces = 0;
    double seconds = 0;  // from the start to the finished file
};

struct SceneInfo {
    std::string name;
    std::string summary;
};

// The built-in scenes.
const std::vector<SceneInfo>& scene_list();

// Writes `trace_path`, which appears only when complete. `progress` (may be empty) is called now and then
// with the fragments captured so far. Throws UserError: unknown scene, bad mesh, options out of range, no
// OpenGL 4.5, disk full.
CaptureSummary capture_scene(const CaptureOptions& options, const std::string& trace_path,
                             const std::function<void(std::uint64_t)>& progress = {});

}  // namespace ropsim
