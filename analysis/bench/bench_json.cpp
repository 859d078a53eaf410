// Everything measured, for programs.
#include "analysis/bench/bench_output.h"
#include "analysis/standard_techniques.h"
#include "base/version.h"

#include <cmath>

#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

constexpr struct {
    const char* key;
    const char* unit;
} kUnits[] = {
    {"wall_seconds", "s of the host, reading the trace and simulating; without the program's start"},
    {"processor_seconds", "s of the host's processors meanwhile, all threads together"},
    {"calibration_seconds",
     "processor s of a fixed loop in the same moment, mean of before and after the run"},
    {"peak_rss_bytes", "bytes, the most that the process had in memory"},
    {"cycles", "of the simulated ROP; of a sample, an estimate"},
    {"frame_ms", "simulated time of the frame, ms"},
    {"pin_bytes", "bytes on the DRAM pins of the whole frame"},
    {"touched_bytes", "bytes read and written before caches"},
    {"rmse8", "1/255 of linear full scale, all pixels"},
    {"rmse8_covered", "1/255 of linear full scale, pixels with a transparent fragment"},
    {"processor_ratio",
     "processor time over that of `timed` in the same repeat: median, and the interval of the median by "
     "ranks "
     "with its exact confidence"},
    {"wall_ratio", "the same of wall time"},
    {"cycles_error", "relative to `timed` on all tiles: root mean square and largest over the repeats"},
    {"pin_bytes_error", "the same of bytes on the pins"},
    {"held", "of the 95% intervals that the samples gave, how many held the value of all tiles"},
    {"exponent",
     "of x in a power law through all repeats, with the half width of its 95% interval from the scatter of "
     "repeats"},
    {"largest_departure_percent", "of a value's geometric mean from the law"},
    {"front", "whether nothing else of the same table has less of one quantity and no more of the other"},
};

Json number(const Measured& value) {
    return value && std::isfinite(*value) ? Json(*value) : Json(nullptr);
}

Json interval(const std::optional<RecordedInterval>& ends) {
    return ends ? Json{ends->low, ends->high} : Json(nullptr);
}

Json interval(const std::optional<RankInterval>& i) {
    if (!i) return nullptr;
    return {{"median", i->estimate}, {"interval", {i->low, i->high}}, {"confidence", i->confidence}};
}

Json host_json(const BenchHost& host) {
    return {{"processor", host.processor},       {"cores", host.cores},
            {"memory_bytes", host.memory_bytes}, {"system", host.system},
            {"load_before", host.load_before},   {"load_after", host.load_after}};
}

Json case_json(const BenchCase& c) {
    Json json = {{"id", c.id()},
                 {"part", c.part},
                 {"series", c.series},
                 {"technique", c.technique},
                 {"mode", c.mode},
                 {"x", c.x},
                 {"threads", c.threads},
                 {"fragments", c.fragments},
                 {"trace_hash", c.trace_hash},
                 {"why_null", c.failure.empty() ? Json(nullptr) : Json(c.failure)},
                 {"repeats", Json::array()}};
    for (const BenchRepeat& r : c.repeats)
        json["repeats"].push_back({{"wall_seconds", r.wall_seconds},
                                   {"processor_seconds", r.processor_seconds},
                                   {"calibration_seconds", r.calibration_seconds},
                                   {"peak_rss_bytes", r.peak_rss_bytes},
                                   {"cycles", number(r.cycles)},
                                   {"cycles_ci95", interval(r.cycles_interval)},
                                   {"frame_seconds", number(r.frame_seconds)},
                                   {"pin_bytes", number(r.pin_bytes)},
                                   {"pin_bytes_ci95", interval(r.pin_interval)},
                                   {"touched_bytes", number(r.touched_bytes)}});
    return json;
}

Json simulator_json(const SimulatorRow& row) {
    return {
        {"trace", row.trace},
        {"technique", row.technique},
        {"mode", row.mode},
        {"processor_seconds", row.seconds},
        {"processor_ratio", interval(row.processor_ratio)},
        {"wall_ratio", interval(row.wall_ratio)},
        {"cycles_error", {{"rms", number(row.cycles_rms)}, {"largest", number(row.cycles_largest)}}},
        {"pin_bytes_error", {{"rms", number(row.pins_rms)}, {"largest", number(row.pins_largest)}}},
        {"held", {{"intervals", row.intervals}, {"cycles", row.cycles_held}, {"pin_bytes", row.pins_held}}},
        {"front", row.front}};
}

Json fit_json(const PowerLawFit& fit) {
    if (!fit.law) return {{"exponent", nullptr}, {"why_null", fit.why_not}};
    return {{"exponent", fit.law->line.slope},
            {"exponent_half_width", number(fit.law->line.slope_half_width)},
            {"coefficient", fit.law->coefficient},
            {"largest_departure_percent", fit.law->largest_departure_percent}};
}

Json technique_plot(const Tradeoff& tradeoff, std::size_t s) {
    Json plot = {{"title", "Techniques on " + tradeoff.scenes[s].name + ": simulated time against error"},
                 {"x", "frame_ms"},
                 {"y", "rmse8_covered"},
                 {"columns",
                  {"technique", "family", "frame_ms", "pin_bytes_per_fragment", "touched_bytes_per_fragment",
                   "rmse8", "rmse8_covered", "front_time", "front_pin_bytes"}},
                 {"rows", Json::array()}};
    const std::vector<bool> time = scene_front(tradeoff, s, TradeoffBytes::kFrameTime);
    const std::vector<bool> pins = scene_front(tradeoff, s, TradeoffBytes::kPins);
    for (std::size_t i = 0; i < tradeoff.techniques.size(); ++i) {
        const TradeoffTechnique& technique = tradeoff.techniques[i];
        const TradeoffPoint& point = technique.at[s];
        if (!point.failure.empty()) continue;
        plot["rows"].push_back({technique.technique, technique_families()[technique.family],
                                number(point.frame_ms), number(point.pins), number(point.touched),
                                number(point.rmse8), number(point.rmse8_covered), bool(time[i]),
                                bool(pins[i])});
    }
    return plot;
}

// One of the plots that have a title; made when first asked for.
Json& plot_of(Json& plots, const std::string& title, const Json& empty) {
    for (Json& plot : plots)
        if (plot["title"] == title) return plot;
    plots.push_back(empty);
    plots.back()["title"] = title;
    plots.back()["rows"] = Json::array();
    return plots.back();
}

void add_simulator_plots(Json& plots, const Bench& bench) {
    const Json empty = {{"title", ""},
                        {"x", "processor_seconds"},
                        {"y", "cycles_error_rms"},
                        {"columns",
                         {"technique", "mode", "processor_seconds", "processor_ratio", "cycles_error_rms",
                          "pin_bytes_error_rms", "front"}}};
    for (const SimulatorRow& row : bench.simulator)
        plot_of(plots, "Simulator on " + row.trace + ": run time against error", empty)["rows"].push_back(
            {row.technique, row.mode, row.seconds,
             row.processor_ratio ? Json(row.processor_ratio->estimate) : Json(nullptr),
             number(row.cycles_rms), number(row.pins_rms), row.front});
}

void add_scaling_plots(Json& plots, const Bench& bench) {
    for (const BenchCase& c : bench.cases) {
        if (c.part != "scaling" || c.repeats.empty()) continue;
        const Json empty = {{"title", ""},
                            {"x", c.series},
                            {"y", "processor_seconds"},
                            {"columns",
                             {"technique", "mode", c.series, "fragments", "processor_seconds", "wall_seconds",
                              "peak_rss_bytes"}}};
        const auto middle = [&](double BenchRepeat::*quantity) {
            return median_interval(over_repeats(c, quantity)).estimate;
        };
        plot_of(plots, "Simulator: run time against " + c.series, empty)["rows"].push_back(
            {c.technique, c.mode, c.x, c.fragments, middle(&BenchRepeat::processor_seconds),
             middle(&BenchRepeat::wall_seconds), middle(&BenchRepeat::peak_rss_bytes)});
    }
}

Json against_json(const Against& against) {
    Json json = {{"baseline", against.file},
                 {"confidence", against.options.confidence},
                 {"least_effect", against.options.least_effect},
                 {"other_processor", against.other_processor},
                 {"only_there", against.only_then},
                 {"only_here", against.only_now},
                 {"rows", Json::array()}};
    for (const AgainstRow& row : against.rows)
        json["rows"].push_back({{"id", row.id},
                                {"verdict", name_of(row.verdict)},
                                {"time_ratio", interval(row.ratio)},
                                {"changed", row.changed}});
    return json;
}

}  // namespace

std::string bench_json(const Bench& bench, const std::optional<Against>& against) {
    Json json;
    json["ropsim"] = kVersion;
    json["host"] = host_json(bench.host);
    json["configuration"] = {{"quick", bench.options.quick},
                             {"repeats", bench.options.repeats},
                             {"fragments", bench.options.fragments},
                             {"largest", bench.options.largest}};
    for (const auto& unit : kUnits) json["units"][unit.key] = unit.unit;
    json["simulator"] = Json::array();
    for (const SimulatorRow& row : bench.simulator) json["simulator"].push_back(simulator_json(row));
    json["scaling"] = Json::array();
    for (const ScalingFit& fit : bench.fits)
        json["scaling"].push_back({{"series", fit.series},
                                   {"technique", fit.technique},
                                   {"mode", fit.mode},
                                   {"processor_seconds", fit_json(fit.time)},
                                   {"peak_rss_bytes", fit_json(fit.memory)}});
    json["threads"] = Json::array();
    for (const ThreadRow& row : bench.threads)
        json["threads"].push_back({{"technique", row.technique},
                                   {"mode", row.mode},
                                   {"threads", row.threads},
                                   {"speed_up", interval(std::optional(row.speed_up))},
                                   {"processor_ratio", interval(std::optional(row.processor_ratio))}});
    json["plots"] = Json::array();
    if (bench.techniques)
        for (std::size_t s = 0; s < bench.techniques->scenes.size(); ++s)
            json["plots"].push_back(technique_plot(*bench.techniques, s));
    add_simulator_plots(json["plots"], bench);
    add_scaling_plots(json["plots"], bench);
    json["against"] = against ? against_json(*against) : Json(nullptr);
    json["cases"] = Json::array();
    for (const BenchCase& c : bench.cases) json["cases"].push_back(case_json(c));
    return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace ropsim
