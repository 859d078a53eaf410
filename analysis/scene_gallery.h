// Every scene captured and measured against what its paper prints, with a picture of each.
#pragma once

#include "capture/scene_list.h"
#include "traces/trace_statistics.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace ropsim {

struct SceneMeasurement {
    std::string scene;
    PublishedScene published;
    std::string description;
    int width = 0, height = 0, samples = 1;
    std::uint64_t seed = 1;
    bool as_published = false;  // captured at the scene's own size, amount and seed 1
    std::uint64_t triangles = 0;
    std::uint64_t counted_primitives = 0;
    TraceStatistics statistics;
    std::uint64_t trace_bytes = 0;
    std::string hash;
    double seconds = 0;  // of the capture, from the start to the finished file

    // What the paper prints for this number of samples.
    std::optional<double> published_fragments() const;
    std::optional<double> published_deepest() const;
};

struct GalleryOptions {
    std::vector<std::string> scenes;  // empty: all
    std::optional<std::pair<int, int>> size;
    std::optional<std::uint64_t> fragments;
    std::uint64_t seed = 1;
    std::optional<int> samples;  // absent: 1, and 4 too where the paper has figures for it
    bool pictures = true;
    bool keep_traces = false;
};

// Captures the scenes one after the other into `directory` (made if need be): NAME.png the exact image,
// NAME-overdraw.png the layers, and, if asked to, NAME.trace (NAME-4x for 4 samples). `progress` is told what
// comes next. Throws UserError.
std::vector<SceneMeasurement> measure_scenes(const GalleryOptions& options, const std::string& directory,
                                             const std::function<void(const std::string&)>& progress);

// A Markdown table: fragments, deepest pixel and primitives against the published ones, with the deviations.
std::string gallery_table(const std::vector<SceneMeasurement>& scenes);

}  // namespace ropsim
