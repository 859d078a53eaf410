// Error against bytes for programs and for readers.
#include "analysis/tradeoff_output.h"

#include "analysis/comparison_table.h"
#include "analysis/standard_techniques.h"
#include "analysis/text_table.h"
#include "base/version.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

constexpr struct {
    const char* key;
    Measured TradeoffPoint::*member;
    const char* unit;
} kMeasured[] = {
    {"operation_worst_case_bytes_per_fragment", &TradeoffPoint::operation_bytes,
     "bytes read and written by the operations on one fragment in all passes over the fragments, each pass "
     "and surface on its costliest control path; without depth test, resolve and lists' walks; null where "
     "the technique refuses the trace"},
    {"rmse8", &TradeoffPoint::rmse8, "1/255 of linear full scale, all pixels"},
    {"rmse8_covered", &TradeoffPoint::rmse8_covered,
     "1/255 of linear full scale, pixels with a transparent fragment"},
    {"touched_bytes_per_fragment", &TradeoffPoint::touched,
     "bytes read and written by the whole frame before caches (depth test against the opaque layer, its "
     "copies into the technique's surfaces, every pass, resolve, the image; clears are fast and free), a "
     "fragment of the trace"},
    {"worst_case_bytes_per_fragment", &TradeoffPoint::worst_case,
     "the same if every operation took its pass's costliest control path; lists are resolved at the length "
     "they have"},
    {"pin_bytes_per_fragment", &TradeoffPoint::pins,
     "bytes on the DRAM pins, behind the ROP caches, in whole bursts, a fragment of the trace; null unless "
     "asked for"},
    {"storage_bits_per_pixel", &TradeoffPoint::storage_bits, "bits a pixel, the pool left out"},
    {"pool_bits_per_node", &TradeoffPoint::node_bits, "bits a node of the pool; null without a pool"},
    {"pool_bits_per_pixel", &TradeoffPoint::pool_bits,
     "bits of the pool that this trace filled, a pixel of the image"},
    {"pool_fragments_dropped", &TradeoffPoint::dropped, "fragments that found the pool full"},
    {"frame_ms", &TradeoffPoint::frame_ms, "simulated time of the frame, ms; null with fidelity count"},
};

Json number(const Measured& value) {
    return value && std::isfinite(*value) ? Json(*value) : Json(nullptr);
}

Json point_json(const TradeoffPoint& point, const std::string& scene) {
    Json json = {{"scene", scene}};
    for (const auto& m : kMeasured) json[m.key] = number(point.*m.member);
    json["front"] = point.front;
    json["front_fixed_memory"] = point.fixed_front;
    json["broken"] = point.broken;
    json["why_null"] = point.failure.empty() ? Json(nullptr) : Json(point.failure);
    return json;
}

// "32", or with lists "32 + 96/fragment".
std::string storage_text(const TradeoffPoint& point) {
    std::string pixel = format_measured(point.storage_bits, 0, ",", "");
    if (!point.storage_bits || !point.node_bits) return pixel;
    return fmt::format("{} + {}/fragment", pixel, format_measured(point.node_bits, 0, ",", ""));
}

std::string operation_text(const TradeoffPoint& point) {
    return format_measured(point.operation_bytes, 0, ",", "");
}

// Once where it is the same on all scenes that have it, else one after another in their order: it may depend
// on their spatial samples.
std::string over_scenes(const TradeoffTechnique& technique, std::string (*text)(const TradeoffPoint&)) {
    std::vector<std::string> texts;
    for (const TradeoffPoint& point : technique.at)
        if (std::string one = text(point); !one.empty()) texts.push_back(std::move(one));
    if (std::set<std::string>(texts.begin(), texts.end()).size() == 1) texts.resize(1);
    return fmt::format("{}", fmt::join(texts, " / "));
}

// A cell of Markdown: bars would end it.
std::string cell(const std::string& text) {
    std::string escaped;
    for (const char c : text) escaped += c == '|' ? std::string("\\|") : std::string(1, c);
    return escaped;
}

std::string shown(const TradeoffPoint& point, const Measured& value, int decimals) {
    std::string text = format_measured(value, decimals, ",", "");
    if (text.empty()) return text;
    return point.front ? "**" + text + "**" : point.fixed_front ? "*" + text + "*" : text;
}

std::string markdown_row(const TradeoffTechnique& technique, Measured TradeoffPoint::*bytes) {
    std::string row =
        fmt::format("| {} | {} | {} |", cell(technique.technique), over_scenes(technique, storage_text),
                    over_scenes(technique, operation_text));
    for (const TradeoffPoint& point : technique.at)
        row += fmt::format(" {} | {} |",
                           point.failure.empty() ? shown(point, point.rmse8, 3)
                                                 : std::string(point.broken ? "failed" : "refused"),
                           shown(point, point.*bytes, 1));
    return row + "\n";
}

std::string markdown_notes(const Tradeoff& tradeoff) {
    std::string text;
    for (std::size_t s = 0; s < tradeoff.scenes.size(); ++s)
        for (const TradeoffTechnique& technique : tradeoff.techniques) {
            const TradeoffPoint& point = technique.at[s];
            if (!point.failure.empty())
                text += fmt::format("- {} on {}{}: {}\n", technique.technique, tradeoff.scenes[s].name,
                                    point.broken ? ", failed" : "", point.failure);
            if (point.dropped.value_or(0) > 0)
                text += fmt::format("- {} on {}: the pool was full and dropped {} fragments\n",
                                    technique.technique, tradeoff.scenes[s].name,
                                    format_measured(point.dropped, 0, ",", ""));
        }
    return text.empty() ? text : "\n" + text;
}

}  // namespace

std::string tradeoff_json(const Tradeoff& tradeoff, bool plotted) {
    Json json;
    json["ropsim"] = kVersion;
    const TradeoffOptions& options = tradeoff.options;
    json["configuration"] = {{"fidelity", bytes_kind(options.bytes).fidelity},
                             {"bytes", bytes_kind(options.bytes).name},
                             {"run_options", options.run_options}};
    Json units;
    for (const auto& m : kMeasured) units[m.key] = m.unit;
    units["front"] =
        "whether no other technique of the scene has less of one of rmse8 and the configuration's bytes "
        "and no more of the other";
    units["front_fixed_memory"] =
        "the same among techniques without a pool, whose memory is known beforehand";
    units["broken"] = "whether the run failed although the technique does not refuse the trace";
    json["units"] = units;
    json["scenes"] = Json::array();
    for (const TradeoffScene& s : tradeoff.scenes)
        json["scenes"].push_back({{"name", s.name},
                                  {"trace", s.trace},
                                  {"hash", s.hash},
                                  {"scene", s.scene},
                                  {"width", s.width},
                                  {"height", s.height},
                                  {"samples", s.samples},
                                  {"fragments", s.fragments}});
    json["techniques"] = Json::array();
    for (const TradeoffTechnique& technique : tradeoff.techniques) {
        Json entry = {{"technique", technique.technique},
                      {"family", technique_families()[technique.family]},
                      {"at", Json::array()}};
        for (std::size_t s = 0; s < technique.at.size(); ++s)
            entry["at"].push_back(point_json(technique.at[s], tradeoff.scenes[s].name));
        json["techniques"].push_back(entry);
    }
    json["plot"] = plotted ? Json{"tradeoff.svg", "tradeoff.png"} : Json(nullptr);
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string tradeoff_csv(const Tradeoff& tradeoff) {
    std::string text = "scene,technique,family";
    for (const auto& m : kMeasured) text += fmt::format(",{}", m.key);
    text += ",front,front_fixed_memory,failure\n";
    for (std::size_t s = 0; s < tradeoff.scenes.size(); ++s)
        for (const TradeoffTechnique& technique : tradeoff.techniques) {
            const TradeoffPoint& point = technique.at[s];
            text +=
                fmt::format("{},{},{}", csv_field(tradeoff.scenes[s].name), csv_field(technique.technique),
                            csv_field(technique_families()[technique.family]));
            for (const auto& m : kMeasured) {
                const Measured& value = point.*m.member;
                text += value && std::isfinite(*value) ? fmt::format(",{}", *value) : ",";
            }
            text += fmt::format(",{},{},{}\n", point.front ? 1 : 0, point.fixed_front ? 1 : 0,
                                csv_field(point.failure));
        }
    return text;
}

std::string tradeoff_markdown(const Tradeoff& tradeoff) {
    std::string heading = "| technique | storage, bit/px | operation at worst, B/fragment |";
    std::string rule = "|---|---|--:|";
    const TradeoffBytesKind& bytes = bytes_kind(tradeoff.options.bytes);
    for (const TradeoffScene& scene : tradeoff.scenes) {
        heading += fmt::format(" {0} RMSE, /255 | {0} {1}, B/fragment |", cell(scene.name), bytes.column);
        rule += "--:|--:|";
    }
    std::string text = heading + "\n" + rule + "\n";
    for (const TradeoffTechnique& technique : tradeoff.techniques)
        text += markdown_row(technique, bytes.member);
    text += fmt::format(
        "\nBold: on the scene's Pareto front of error and {0} bytes; italic: on that of the techniques "
        "without a pool. The operation at worst is what its costliest control paths move\nfor one fragment "
        "in all passes over the fragments, before caches. Where it or storage depends on the scene there is "
        "a number for each, in order. The {0} bytes\nare of the whole frame: depth test, passes, resolve, "
        "image.\n",
        bytes.column);
    return text + markdown_notes(tradeoff);
}

}  // namespace ropsim
