// `ropsim scenes`: captures the built-in scenes and measures them against their papers.
#include "analysis/scene_gallery.h"
#include "base/error.h"
#include "cli/commands.h"
#include "cli/image_size.h"

#include <memory>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

struct ScenesArguments {
    GalleryOptions options;
    std::string size;
    std::uint64_t fragments = 0;
    int samples = 0;
    bool json = false;
    std::string output;
};

template <typename T>
Json or_null(const std::optional<T>& value) {
    return value ? Json(*value) : Json(nullptr);
}

Json to_json(const SceneMeasurement& s) {
    return {{"name", s.scene},
            {"description", s.description},
            {"width", s.width},
            {"height", s.height},
            {"samples", s.samples},
            {"seed", s.seed},
            {"as_published", s.as_published},
            {"fragments", s.statistics.fragments},
            {"deepest", s.statistics.all.max},
            {"mean_layers", or_null(s.statistics.all.mean)},
            {"hidden_by_opaque", s.statistics.hidden_by_opaque},
            {"triangles", s.triangles},
            {"counted_primitives", s.counted_primitives > 0 ? Json(s.counted_primitives) : Json(nullptr)},
            {"trace_bytes", s.trace_bytes},
            {"hash", s.hash},
            {"published",
             {{"paper", s.published.paper},
              {"place", s.published.place},
              {"fragments", or_null(s.published_fragments())},
              {"deepest", or_null(s.published_deepest())},
              {"primitives", or_null(s.published.primitives)},
              {"primitive_name", s.published.primitive_name}}},
            {"host", {{"seconds", s.seconds}}}};
}

void run_scenes(const ScenesArguments& arguments) {
    const std::vector<SceneMeasurement> scenes =
        measure_scenes(arguments.options, arguments.output,
                       [](const std::string& what) { fmt::print(stderr, "{}\n", what); });
    if (!arguments.json) {
        fmt::print("{}", gallery_table(scenes));
        return;
    }
    Json list = Json::array();
    for (const SceneMeasurement& scene : scenes) list.push_back(to_json(scene));
    fmt::print("{}\n", list.dump(2));
}

}  // namespace

void add_scenes_command(CLI::App& app) {
    auto arguments = std::make_shared<ScenesArguments>();
    CLI::App* command = app.add_subcommand(
        "scenes", "Captures scenes, measures them against their papers, and draws a picture of each");
    command->add_option("SCENE", arguments->options.scenes, "Scenes; all of them if none is named");
    CLI::Option* size = command->add_option("--size", arguments->size,
                                            "Image size, WIDTHxHEIGHT; by default each scene's own");
    CLI::Option* fragments = command->add_option("--fragments", arguments->fragments,
                                                 "About so many fragments each; by default the scene's own");
    CLI::Option* samples = command->add_option(
        "--samples", arguments->samples,
        "Spatial samples a pixel; by default 1, and 4 as well where the paper has figures for it");
    for (CLI::Option* option : {size, fragments, samples}) option->default_str("");
    command->add_option("--seed", arguments->options.seed, "Seed of everything random in the scenes");
    command->add_flag("--keep-traces", arguments->options.keep_traces,
                      "Leave the traces beside the pictures");
    command->add_flag("--json", arguments->json, "As JSON on stdout, instead of a Markdown table");
    command->add_option("-o,--output", arguments->output, "Directory for the pictures")->required();
    command->callback([arguments, size, fragments, samples] {
        if (size->count() > 0) arguments->options.size = parse_size(arguments->size);
        if (fragments->count() > 0) arguments->options.fragments = arguments->fragments;
        if (samples->count() > 0) arguments->options.samples = arguments->samples;
        run_scenes(*arguments);
    });
}

}  // namespace ropsim
