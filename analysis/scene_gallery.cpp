#include "analysis/scene_gallery.h"

#include "base/error.h"
#include "base/outputs.h"
#include "base/parallel.h"
#include "capture/capture.h"
#include "rop/reference.h"
#include "traces/image.h"
#include "traces/overdraw_picture.h"
#include "traces/trace.h"

#include <algorithm>
#include <filesystem>

namespace ropsim {
namespace {

SceneMeasurement measure(const SceneInfo& info, int samples, const GalleryOptions& options,
                         const std::string& directory) {
    CaptureOptions capture;
    capture.scene_or_file = info.name;
    capture.size = options.size;
    capture.fragments = options.fragments;
    capture.seed = options.seed;
    capture.samples = samples;
    const std::string name = samples == 1 ? info.name : fmt::format("{}-{}x", info.name, samples);
    const std::string path = directory + "/" + name + ".trace";
    const CaptureSummary summary = capture_scene(capture, path);
    SceneMeasurement result;
    result.scene = info.name;
    result.published = info.published;
    result.description = summary.description;
    result.width = summary.width;
    result.height = summary.height;
    result.samples = samples;
    result.seed = options.seed;
    result.as_published = !options.size && !options.fragments && options.seed == 1;
    result.triangles = summary.triangles;
    result.counted_primitives =
        info.published.primitive_name == "triangles" ? summary.triangles : summary.counted_primitives;
    result.seconds = summary.seconds;
    TraceReader trace(path);
    PixelLayers layers;
    result.statistics = measure_trace(trace, &layers);
    result.trace_bytes = trace.file_bytes();
    result.hash = trace.hash();
    if (options.pictures) {
        write_png(directory + "/" + name + ".png",
                  reference_image(trace, default_threads(), DisplayFilter::kBox, kReferenceBandFragments,
                                  Transmission::kColored));
        write_png(directory + "/" + name + "-overdraw.png",
                  overdraw_picture(layers.all, summary.width, summary.height));
    }
    if (!options.keep_traces) std::filesystem::remove(path);
    return result;
}

std::vector<int> sample_counts(const SceneInfo& info, const GalleryOptions& options) {
    if (options.samples) return {*options.samples};
    return info.published.fragments_4x ? std::vector<int>{1, 4} : std::vector<int>{1};
}

std::string deviation(double ours, double published) {
    return fmt::format("{:+.1f} %", 100 * (ours / published - 1));
}

// "ours (published, deviation)"
std::string against(std::uint64_t ours, const std::optional<double>& published, const std::string& shown,
                    bool comparable) {
    std::string text = fmt::format("{}", ours);
    if (published && comparable)
        text += fmt::format(" ({}, {})", shown, deviation(static_cast<double>(ours), *published));
    return text;
}

}  // namespace

std::optional<double> SceneMeasurement::published_fragments() const {
    if (samples == 1) return published.fragments;
    return samples == 4 ? published.fragments_4x : std::nullopt;
}

std::optional<double> SceneMeasurement::published_deepest() const {
    if (samples == 1) return published.deepest;
    return samples == 4 ? published.deepest_4x : std::nullopt;
}

std::vector<SceneMeasurement> measure_scenes(const GalleryOptions& options, const std::string& directory,
                                             const std::function<void(const std::string&)>& progress) {
    std::vector<const SceneInfo*> chosen;
    for (const SceneInfo& info : scene_list())
        if (options.scenes.empty() || std::ranges::count(options.scenes, info.name) > 0)
            chosen.push_back(&info);
    for (const std::string& name : options.scenes)
        if (std::ranges::none_of(chosen, [&](const SceneInfo* info) { return info->name == name; }))
            throw UserError(name, "no such scene; `ropsim list scenes` prints them");
    start_directory(directory);
    std::vector<SceneMeasurement> results;
    for (const SceneInfo* info : chosen)
        for (const int samples : sample_counts(*info, options)) {
            progress(samples == 1 ? info->name : fmt::format("{}, {} samples", info->name, samples));
            results.push_back(measure(*info, samples, options, directory));
        }
    return results;
}

std::string gallery_table(const std::vector<SceneMeasurement>& scenes) {
    std::string text =
        "| Scene | Size | Fragments (published) | Deepest pixel (published) | Mean layers | Hidden | "
        "Primitives "
        "(published) | Bytes a fragment |\n|---|---|---|---|---|---|---|---|\n";
    for (const SceneMeasurement& s : scenes) {
        const TraceStatistics& t = s.statistics;
        const auto fragments = s.published_fragments();
        const auto deepest = s.published_deepest();
        std::string primitives = fmt::format("{} triangles", s.triangles);
        if (s.published.primitives && s.counted_primitives > 0)
            primitives = fmt::format("{} {}{}", s.counted_primitives, s.published.primitive_name,
                                     s.as_published ? fmt::format(" ({})", *s.published.primitives) : "");
        const double count = std::max<double>(static_cast<double>(t.fragments), 1);
        text += fmt::format(
            "| `{}`{} | {}x{} | {} | {} | {:.1f} | {:.1f} % | {} | {:.1f} |\n", s.scene,
            s.samples == 1 ? "" : fmt::format(", {} samples", s.samples), s.width, s.height,
            against(t.fragments, fragments, fragments ? fmt::format("{:.4g} M", *fragments / 1e6) : "",
                    s.as_published),
            against(t.all.max, deepest, deepest ? fmt::format("{:.0f}", *deepest) : "", s.as_published),
            t.all.mean.value_or(0), 100 * static_cast<double>(t.hidden_by_opaque) / count, primitives,
            static_cast<double>(s.trace_bytes) / count);
    }
    return text;
}

}  // namespace ropsim
