#include "model/breakdown_json.h"

#include <algorithm>

#include <nlohmann/json.hpp>

namespace ropsim {

namespace {

using Json = nlohmann::ordered_json;

void add_bytes(Json& json, const ReadWriteBytes& bytes) {
    json["miss_port_read_bytes"] = bytes.read;
    json["miss_port_write_bytes"] = bytes.write;
}

// Of picoseconds, in nanoseconds.
Json latency_json(const LatencyHistogram& picoseconds) {
    Json json = {{"reads", picoseconds.count()}};
    const bool any = picoseconds.count() > 0;
    const auto nanoseconds = [any](double value) { return any ? Json(value * 1e-3) : Json(nullptr); };
    const auto largest = static_cast<double>(picoseconds.maximum());
    json["mean_ns"] = nanoseconds(picoseconds.mean());
    json["p50_ns"] = nanoseconds(std::min(largest, picoseconds.percentile(0.5)));
    json["p99_ns"] = nanoseconds(std::min(largest, picoseconds.percentile(0.99)));
    json["max_ns"] = nanoseconds(largest);
    json["histogram"] = Json::array();
    double below = 2e-3;
    for (const std::uint64_t count : picoseconds.octaves()) {
        if (count != 0) json["histogram"].push_back({{"below_ns", below}, {"reads", count}});
        below *= 2;
    }
    return json;
}

}  // namespace

Json traffic_by_pass_json(const RunResult& r) {
    if (!r.machine) return nullptr;
    Json json = Json::array();
    const auto& passes = r.machine->breakdown.passes();
    for (std::size_t p = 0; p < passes.size(); ++p) {
        Json entry = {{"pass", passes[p].name}};
        add_bytes(entry, passes[p].bytes);
        entry["seconds"] =
            r.machine->timed ? Json(1e-12 * static_cast<double>(r.machine->pass_times[p])) : Json(nullptr);
        json.push_back(entry);
    }
    return json;
}

Json traffic_by_draw_json(const RunResult& r) {
    if (!r.machine) return nullptr;
    Json json = Json::array();
    const std::vector<ReadWriteBytes>& draws = r.machine->breakdown.draws();
    for (std::size_t d = 0; d < draws.size(); ++d) {
        const bool none = d + 1 == draws.size();
        Json entry = {{"draw", none ? Json(nullptr) : Json(d)},
                      {"name", none ? Json(nullptr) : Json(r.trace.draws[d].name)}};
        add_bytes(entry, draws[d]);
        json.push_back(entry);
    }
    return json;
}

Json channels_json(const RunResult& r) {
    if (!r.machine) return nullptr;
    const MachineResult& m = *r.machine;
    Json json = Json::array();
    for (const ChannelReport& channel : m.channels) {
        const auto per_second = m.seconds > 0 ? static_cast<double>(channel.pins.sum()) / m.seconds : 0.0;
        const auto timed = [&m](auto value) { return m.timed ? Json(value) : Json(nullptr); };
        json.push_back({{"read_bytes", channel.pins.read},
                        {"write_bytes", channel.pins.write},
                        {"gigabytes_per_second", per_second * 1e-9},
                        {"percent_of_peak", 100 * per_second / m.channel_peak_bytes_per_second},
                        {"utilisation", timed(channel.utilisation)},
                        {"row_hits", timed(channel.row_hits)},
                        {"row_misses", timed(channel.row_misses)},
                        {"row_conflicts", timed(channel.row_conflicts)}});
    }
    return json;
}

Json read_latency_json(const RunResult& r) {
    if (!r.machine || !r.machine->timed) return nullptr;
    LatencyHistogram all;
    Json surfaces = Json::object();
    for (std::size_t s = 0; s < r.machine->read_latency.size(); ++s) {
        const LatencyHistogram& one = r.machine->read_latency[s];
        all.add(one);
        if (one.count() > 0) surfaces[r.surfaces[s]] = latency_json(one);
    }
    return {{"all", latency_json(all)}, {"surfaces", surfaces}};
}

}  // namespace ropsim
