// Captures a scene's transparent fragments, opaque layer and camera into a trace.
#pragma once

#include "capture/scene.h"
#include "traces/trace.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace ropsim {

struct CaptureOptions {
    std::string scene_or_file;  // a name of scene_list(), or the path of a mesh, .hair or splat .ply file
    std::optional<std::pair<int, int>> size;              // pixels, each 1 to 16384; absent: the scene's own
    int samples = 1;                                      // spatial samples a pixel: 1, 2, 4, 8 or 16
    ColorStorage color_storage = ColorStorage::kFloat16;  // the draws' export format; alpha and z are float32
    bool light_view = false;                              // from the scene's light instead of its camera
    std::optional<std::uint64_t>
        fragments;  // about so many transparent fragments; absent: the scene's own amount
    std::uint64_t seed = 1;
};

// What the options name, before OpenGL is needed.
struct SceneRequest {
    std::unique_ptr<SceneSource> source;
    int width = 0;  // pixels
    int height = 0;
};
// Throws UserError: unknown scene, bad file, options out of range.
SceneRequest find_scene(const CaptureOptions& options);
// At the scale that the options ask for, seen from the camera that they ask for. Needs a current GlContext.
Scene build_scene(const SceneRequest& request, const CaptureOptions& options);

struct CaptureSummary {
    std::string description;  // of the scene, as the trace records it
    std::string renderer;     // the OpenGL driver's name
    int width = 0;
    int height = 0;
    std::uint64_t fragments = 0;
    std::uint64_t triangles = 0;           // transparent, instances counted
    std::uint64_t counted_primitives = 0;  // Scene::counted_primitives
    std::uint64_t pieces = 0;
    double seconds = 0;          // from the start to the finished file
    double drawing_seconds = 0;  // from the first draw of transparent geometry to the finished file
};

// Writes `trace_path`, which appears only when complete. `progress` (may be empty) is called now and then
// with the fragments captured so far. Throws UserError: unknown scene, bad mesh, options out of range, no
// OpenGL 4.5, disk full.
CaptureSummary capture_scene(const CaptureOptions& options, const std::string& trace_path,
                             const std::function<void(std::uint64_t)>& progress = {});

}  // namespace ropsim
