// From a scene's name to a finished trace.
#include "capture/capture.h"

#include "base/error.h"
#include "capture/files/splat_file.h"
#include "capture/fragment_capture.h"
#include "capture/gl_context.h"
#include "capture/opaque_pass.h"
#include "capture/scene_fit.h"
#include "capture/scene_list.h"
#include "capture/shader_cost/shader_cost.h"
#include "traces/trace.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <string_view>
#include <utility>

namespace ropsim {
namespace {

constexpr int kMaxSize = 16384;
constexpr int kLightViewSide = 1024;  // pixels; lights see squares

// Least number of single-character edits from one word to the other.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i - 1] != b[j - 1]);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
        }
    }
    return row[b.size()];
}

[[noreturn]] void refuse_scene(const std::string& name) {
    std::string names;
    std::string nearest;
    std::size_t least = name.size() / 2 + 1;
    for (const SceneInfo& scene : scene_list()) {
        names += (names.empty() ? "" : ", ") + scene.name;
        const std::size_t distance = edit_distance(name, scene.name);
        if (distance < least) {
            least = distance;
            nearest = scene.name;
        }
    }
    const std::string guess = nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest);
    throw UserError(name, fmt::format("neither a scene nor a file; {}scenes: {}", guess, names));
}

const SceneInfo* listed_scene(const std::string& name) {
    for (const SceneInfo& scene : scene_list())
        if (scene.name == name) return &scene;
    return nullptr;
}

// A file that is to be a scene: its ending, for .ply its header, says what it holds.
std::unique_ptr<SceneSource> make_file_scene(const std::string& path, double aspect, std::uint64_t seed) {
    // Something with a directory or an ending was meant as a file: it will be said to be missing.
    const bool meant_as_file = std::filesystem::is_regular_file(path) ||
                               path.find('/') != std::string::npos ||
                               std::filesystem::path(path).has_extension();
    if (!meant_as_file) refuse_scene(path);
    if (is_splat_ply(path)) return make_splat_file_scene(path, aspect, seed);
    if (path.ends_with(".hair")) return make_hair_file_scene(path, aspect, seed);
    return make_mesh_scene(path, aspect, seed);
}

void check_options(const CaptureOptions& options, int width, int height) {
    if (width < 1 || width > kMaxSize || height < 1 || height > kMaxSize) {
        throw UserError("--size",
                        fmt::format("{}x{} is outside 1x1 to {}x{}", width, height, kMaxSize, kMaxSize));
    }
    if (options.samples < 1 || options.samples > 16 || (options.samples & (options.samples - 1)) != 0)
        throw UserError("--samples", fmt::format("{} is not 1, 2, 4, 8 or 16", options.samples));
    if (options.fragments && *options.fragments == 0) {
        throw UserError("--fragments", "0 asks for an empty trace; give a positive number");
    }
}

TraceHeader make_header(const Scene& scene, const CaptureOptions& options, int width, int height) {
    TraceHeader header;
    header.width = width;
    header.height = height;
    header.samples = options.samples;
    header.background = scene.background;
    header.color_storage = options.color_storage;
    header.scene = fmt::format("{}, seed {}", scene.description, options.seed);
    header.view = options.light_view ? "light" : "camera";
    header.camera = scene.camera;
    header.light = scene.light;
    header.depth_slopes = options.samples > 1;
    header.materials = scene.materials;
    for (std::size_t i = 0; i < scene.transparent.size(); ++i) {
        Draw& draw = header.draws.emplace_back(scene.transparent[i].state);
        draw.object_id = static_cast<std::uint32_t>(i);
        ShaderCosts costs = measure_shader_cost(scene.transparent[i], scene.materials);
        draw.full = costs.full;
        draw.alpha = costs.alpha;
        draw.cost_source = std::move(costs.source);
    }
    header.opaque = draw_opaque_layer(scene, width, height, options.samples);
    return header;
}

}  // namespace

SceneRequest find_scene(const CaptureOptions& options) {
    const SceneInfo* info = listed_scene(options.scene_or_file);
    const auto own_size = info != nullptr ? std::pair(info->width, info->height) : std::pair(1280, 720);
    const auto [width, height] =
        options.size.value_or(options.light_view ? std::pair(kLightViewSide, kLightViewSide) : own_size);
    check_options(options, width, height);
    // The light sees what the camera's frame was made for.
    const auto [frame_width, frame_height] = options.light_view ? own_size : std::pair(width, height);
    const double aspect = static_cast<double>(frame_width) / frame_height;
    return {info != nullptr ? info->make(aspect, options.seed)
                            : make_file_scene(options.scene_or_file, aspect, options.seed),
            width, height};
}

Scene build_scene(const SceneRequest& request, const CaptureOptions& options) {
    const SceneScale scale =
        fit_scene(*request.source, request.width, request.height, options.samples, options.fragments);
    Scene scene = request.source->build(scale);
    if (options.light_view) scene.camera = scene.light;
    return scene;
}

CaptureSummary capture_scene(const CaptureOptions& options, const std::string& trace_path,
                             const std::function<void(std::uint64_t)>& progress) {
    const auto start = std::chrono::steady_clock::now();
    const SceneRequest request = find_scene(options);
    const auto [width, height] = std::pair(request.width, request.height);
    const GlContext context;
    const Scene scene = build_scene(request, options);
    TraceWriter writer(trace_path, make_header(scene, options, width, height));
    const auto first_draw = std::chrono::steady_clock::now();
    std::uint64_t captured = 0;
    const FragmentCaptureCounts counts =
        capture_fragments(scene, width, height, options.samples, {}, [&](const FragmentChunk& fragments) {
            writer.append(fragments);
            captured += fragments.size();
            if (progress) progress(captured);
        });
    writer.finish();
    CaptureSummary summary;
    summary.description = scene.description;
    summary.renderer = context.renderer();
    summary.width = width;
    summary.height = height;
    summary.fragments = counts.fragments;
    for (const SceneDraw& draw : scene.transparent)
        summary.triangles += std::uint64_t{draw.primitives} * draw.instances;
    summary.counted_primitives = scene.counted_primitives;
    summary.pieces = counts.pieces;
    const auto end = std::chrono::steady_clock::now();
    summary.seconds = std::chrono::duration<double>(end - start).count();
    summary.drawing_seconds = std::chrono::duration<double>(end - first_draw).count();
    return summary;
}

}  // namespace ropsim
