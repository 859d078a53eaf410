// From a scene's name to a finished trace.
#include "capture/capture.h"

#include "base/error.h"
#include "capture/fragment_capture.h"
#include "capture/gl_context.h"
#include "capture/opaque_pass.h"
#include "capture/scene.h"
#include "capture/scene_fit.h"
#include "traces/trace.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <string_view>

namespace ropsim {
namespace {

constexpr int kMaxSize = 16384;
constexpr const char* kModels = "/usr/share/glmark2/models";  // Debian's glmark2-data

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
    throw UserError(name, fmt::format("neither a scene nor a mesh file; {}scenes: {}", guess, names));
}

std::unique_ptr<SceneSource> find_scene(const CaptureOptions& options) {
    const std::string& name = options.scene_or_mesh;
    const double aspect = static_cast<double>(options.width) / options.height;
    if (name == "horse") return make_mesh_scene(std::string(kModels) + "/horse.3ds", aspect, options.seed);
    if (name == "bunny") return make_mesh_scene(std::string(kModels) + "/bunny.obj", aspect, options.seed);
    if (name == "hair") return make_hair_scene(aspect, options.seed);
    if (name == "plume") return make_plume_scene(aspect, options.seed);
    if (std::filesystem::is_regular_file(name)) return make_mesh_scene(name, aspect, options.seed);
    // Something with a directory or an ending was meant as a file: say that it is missing.
    if (name.find('/') != std::string::npos || std::filesystem::path(name).has_extension()) {
        return make_mesh_scene(name, aspect, options.seed);
    }
    refuse_scene(name);
}

void check_options(const CaptureOptions& options) {
    if (options.width < 1 || options.width > kMaxSize || options.height < 1 || options.height > kMaxSize) {
        throw UserError("--size", fmt::format("{}x{} is outside 1x1 to {}x{}", options.width, options.height,
                                              kMaxSize, kMaxSize));
    }
    if (options.samples != 1) {
        throw UserError("--samples",
                        fmt::format("{} asked for; this version captures 1 spatial sample a pixel: use "
                                    "--samples 1",
                                    options.samples));
    }
    if (options.fragments && *options.fragments == 0) {
        throw UserError("--fragments", "0 asks for an empty trace; give a positive number");
    }
}

TraceHeader make_header(const Scene& scene, const CaptureOptions& options) {
    TraceHeader header;
    header.width = options.width;
    header.height = options.height;
    header.samples = options.samples;
    header.background = scene.background;
    header.color_storage = ColorStorage::kFloat16;
    header.scene = fmt::format("{}, seed {}", scene.description, options.seed);
    header.camera = scene.camera;
    for (std::size_t i = 0; i < scene.transparent.size(); ++i) {
        header.draws.push_back(scene.transparent[i].state);
        header.draws.back().object_id = static_cast<std::uint32_t>(i);
    }
    header.opaque = draw_opaque_layer(scene, options.width, options.height);
    return header;
}

}  // namespace

const std::vector<SceneInfo>& scene_list() {
    static const std::vector<SceneInfo> scenes = {
        {"horse", "translucent copies of glmark2's horse, at least 8 layers deep, on a checkered floor"},
        {"bunny", "translucent copies of glmark2's bunny, at least 8 layers deep, on a checkered floor"},
        {"hair", "a head with long hair: thin translucent strands in order of growth, over 300 layers deep"},
        {"plume", "a plume of smoke from a chimney: 100,000 soft billboards, unsorted"},
    };
    return scenes;
}

CaptureSummary capture_scene(const CaptureOptions& options, const std::string& trace_path,
                             const std::function<void(std::uint64_t)>& progress) {
    const auto start = std::chrono::steady_clock::now();
    check_options(options);
    const std::unique_ptr<SceneSource> source = find_scene(options);
    const GlContext context;
    const SceneScale scale = fit_scene(*source, options.width, options.height, options.fragments);
    const Scene scene = source->build(scale);
    TraceWriter writer(trace_path, make_header(scene, options));
    std::uint64_t captured = 0;
    const FragmentCaptureCounts counts = capture_fragments(scene, options.width, options.height, {},
                                                           [&](const std::vector<Fragment>& fragments) {
                                                               writer.append(fragments);
                                                               captured += fragments.size();
                                                               if (progress) progress(captured);
                                                           });
    writer.finish();
    CaptureSummary summary;
    summary.description = scene.description;
    summary.renderer = context.renderer();
    summary.fragments = counts.fragments;
    summary.pieces = counts.pieces;
    summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return summary;
}

}  // namespace ropsim
