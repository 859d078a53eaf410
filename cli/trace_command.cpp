// `ropsim trace info|import|export`: looks at traces and converts them.
#include "base/error.h"
#include "cli/commands.h"
#include "traces/csv.h"
#include "traces/trace.h"
#include "traces/trace_statistics.h"

#include <cstdio>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {

namespace {

using Json = nlohmann::ordered_json;

bool ends_with(const std::string& text, const std::string& end) {
    return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

template <typename T>
Json or_null(const std::optional<T>& value) {
    return value ? Json(*value) : Json(nullptr);
}

Json depth_complexity_json(const DepthComplexity& depth) {
    return {{"mean", or_null(depth.mean)},
            {"max", depth.max},
            {"covered_pixels", depth.covered_pixels},
            {"histogram", depth.histogram}};
}

std::optional<double> bytes_per_fragment(const TraceReader& reader) {
    if (reader.fragment_count() == 0) return std::nullopt;
    return static_cast<double>(reader.file_bytes()) / static_cast<double>(reader.fragment_count());
}

const char* color_name(const TraceHeader& header) {
    return header.color_storage == ColorStorage::kFloat16 ? "float16" : "float32";
}

Json info_json(const TraceReader& reader, const TraceStatistics& statistics) {
    const TraceHeader& header = reader.header();
    Json result{{"file", reader.path()},
                {"width", header.width},
                {"height", header.height},
                {"samples", header.samples},
                {"fragments", reader.fragment_count()},
                {"draws", header.draws.size()},
                {"depth_complexity", depth_complexity_json(statistics.all)},
                {"visible_depth_complexity", depth_complexity_json(statistics.visible)},
                {"hidden_by_opaque", statistics.hidden_by_opaque},
                {"alpha",
                 {{"mean", or_null(statistics.alpha_mean)},
                  {"histogram", statistics.alpha_histogram},
                  {"zero", statistics.zero_alpha},
                  {"one", statistics.full_alpha}}},
                {"bytes", reader.file_bytes()},
                {"bytes_per_fragment", or_null(bytes_per_fragment(reader))},
                {"hash", reader.hash()},
                {"scene", header.scene},
                {"color_storage", color_name(header)},
                {"opaque_layer", header.opaque.has_value()},
                {"camera", nullptr},
                {"draw_list", Json::array()}};
    if (header.camera)
        result["camera"] = {{"near_plane", header.camera->near_plane},
                            {"far_plane", header.camera->far_plane},
                            {"fovy_degrees", header.camera->fovy_degrees},
                            {"metres_per_unit", header.camera->metres_per_unit}};
    for (std::size_t i = 0; i < header.draws.size(); ++i)
        result["draw_list"].push_back({{"name", header.draws[i].name},
                                       {"object_id", header.draws[i].object_id},
                                       {"fragments", statistics.draw_fragments[i]}});
    return result;
}

std::string depth_text(const DepthComplexity& depth, std::size_t pixels) {
    if (!depth.mean) return "no pixel is covered";
    return fmt::format("mean {:.2f}, max {} fragments a pixel, over {} covered pixels ({:.1f}% of the image)",
                       *depth.mean, depth.max, depth.covered_pixels,
                       100.0 * static_cast<double>(depth.covered_pixels) / static_cast<double>(pixels));
}

// Pixels by fragments a pixel, in ranges that double: short for any trace.
std::string histogram_text(const DepthComplexity& depth, std::size_t pixels) {
    std::string text;
    for (std::size_t first = 0; first < depth.histogram.size();) {
        const std::size_t last = first == 0 ? 0 : 2 * first - 1;
        std::uint64_t count = 0;
        for (std::size_t k = first; k <= last && k < depth.histogram.size(); ++k) count += depth.histogram[k];
        const std::string range =
            first == last ? fmt::format("{}", first) : fmt::format("{}-{}", first, last);
        text += fmt::format("    {:>11}  {:>10} pixels  {:5.1f}%\n", range, count,
                            100.0 * static_cast<double>(count) / static_cast<double>(pixels));
        first = last + 1;
    }
    return text;
}

std::string info_text(const TraceReader& reader, const TraceStatistics& statistics) {
    const TraceHeader& header = reader.header();
    const std::size_t pixels =
        static_cast<std::size_t>(header.width) * static_cast<std::size_t>(header.height);
    const auto percent = [&](std::uint64_t count) {
        return statistics.fragments
                   ? 100.0 * static_cast<double>(count) / static_cast<double>(statistics.fragments)
                   : 0.0;
    };
    std::string text = fmt::format("{}\n", reader.path());
    const auto line = [&](const char* name, const std::string& value) {
        text += fmt::format("  {:<18}{}\n", name, value);
    };
    line("scene", header.scene.empty() ? "(unnamed)" : header.scene);
    line("size", fmt::format("{}x{} pixels, {} sample{} a pixel", header.width, header.height, header.samples,
                             header.samples == 1 ? "" : "s"));
    line("fragments", fmt::format("{} in {} draw{}", reader.fragment_count(), header.draws.size(),
                                  header.draws.size() == 1 ? "" : "s"));
    line("depth complexity", depth_text(statistics.all, pixels));
    text += histogram_text(statistics.all, pixels);
    line("visible", depth_text(statistics.visible, pixels));
    line("opaque layer", header.opaque
                             ? fmt::format("hides {} fragments ({:.1f}%)", statistics.hidden_by_opaque,
                                           percent(statistics.hidden_by_opaque))
                             : "none");
    if (statistics.alpha_mean)
        line("alpha",
             fmt::format("mean {:.3f}; exactly 0: {:.1f}%, exactly 1: {:.1f}%", *statistics.alpha_mean,
                         percent(statistics.zero_alpha), percent(statistics.full_alpha)));
    if (header.camera)
        line("camera", fmt::format("near {}, far {} scene units, {} degrees high", header.camera->near_plane,
                                   header.camera->far_plane, header.camera->fovy_degrees));
    const auto bytes = bytes_per_fragment(reader);
    line("file", fmt::format("{} bytes{}, colour as {}", reader.file_bytes(),
                             bytes ? fmt::format(", {:.2f} a fragment", *bytes) : "", color_name(header)));
    line("hash", reader.hash());
    return text;
}

void refuse_deep_exr(const std::string& path) {
    if (ends_with(path, ".exr"))
        throw UserError(path, "deep OpenEXR is not supported by this version; use a .csv file");
}

void add_info(CLI::App& trace) {
    struct Options {
        std::string path;
        bool json = false;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command =
        trace.add_subcommand("info", "Describe a trace: fragments, depth complexity, alpha, hash");
    command->add_option("TRACE", options->path, "trace file")->required();
    command->add_flag("--json", options->json, "write JSON to stdout");
    command->callback([options] {
        TraceReader reader(options->path);
        const TraceStatistics statistics = measure_trace(reader);
        const std::string text =
            options->json ? info_json(reader, statistics).dump(2) + "\n" : info_text(reader, statistics);
        std::fputs(text.c_str(), stdout);
    });
}

void add_import(CLI::App& trace) {
    const auto paths = std::make_shared<std::pair<std::string, std::string>>();
    CLI::App* command = trace.add_subcommand("import", "Make a trace from CSV fragments in arrival order");
    command->add_option("FILE", paths->first, "CSV file")->required();
    command->add_option("-o,--output", paths->second, "trace file to write")->required();
    command->callback([paths] {
        refuse_deep_exr(paths->first);
        import_csv(paths->first, paths->second);
    });
}

void add_export(CLI::App& trace) {
    const auto paths = std::make_shared<std::pair<std::string, std::string>>();
    CLI::App* command = trace.add_subcommand("export", "Write a trace's fragments as CSV, losslessly");
    command->add_option("TRACE", paths->first, "trace file")->required();
    command->add_option("-o,--output", paths->second, "file to write, .csv")->required();
    command->callback([paths] {
        refuse_deep_exr(paths->second);
        if (!ends_with(paths->second, ".csv"))
            throw UserError(paths->second, "unknown kind of file; name it .csv");
        export_csv(paths->first, paths->second);
        if (TraceReader(paths->first).header().opaque)
            std::fprintf(stderr, "ropsim: %s: the opaque layer is not part of a CSV file and was left out\n",
                         paths->second.c_str());
    });
}

}  // namespace

void add_trace_command(CLI::App& app) {
    CLI::App* trace = app.add_subcommand("trace", "Look at traces and convert them");
    trace->require_subcommand(1);
    add_info(*trace);
    add_import(*trace);
    add_export(*trace);
}

}  // namespace ropsim
