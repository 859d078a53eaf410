// Reads run.json, forgiving about what is absent.
#include "analysis/run_record.h"

#include "analysis/comparison_table.h"
#include "base/error.h"

#include <cmath>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using Json = nlohmann::ordered_json;

// The entry at a dotted path, or null.
const Json& at(const Json& json, std::string_view path) {
    static const Json null;
    const Json* here = &json;
    while (!path.empty()) {
        const std::size_t dot = path.find('.');
        const std::string key(path.substr(0, dot));
        path = dot == std::string_view::npos ? std::string_view{} : path.substr(dot + 1);
        if (!here->is_object()) return null;
        const auto found = here->find(key);
        if (found == here->end()) return null;
        here = &*found;
    }
    return *here;
}

Measured number(const Json& json) {
    if (json.is_number()) return json.get<double>();
    if (json.is_object()) {
        const auto value = json.find("value");
        if (value != json.end() && value->is_number()) return value->get<double>();
    }
    return {};
}

Measured number(const Json& json, std::string_view path) {
    return number(at(json, path));
}

// Of an estimate.
std::optional<RecordedInterval> interval(const Json& estimate) {
    const Json& ends = at(estimate, "ci95");
    if (!ends.is_array() || ends.size() != 2) return {};
    const Measured low = number(ends[0]);
    const Measured high = number(ends[1]);
    if (!low || !high) return {};
    return RecordedInterval{*low, *high};
}

RecordedTraffic traffic_of(const std::string& surface, const Json& json) {
    return {surface,
            number(json, "worst_case_read_bytes"),
            number(json, "worst_case_write_bytes"),
            number(json, "read_bytes"),
            number(json, "write_bytes"),
            number(json, "pin_read_bytes"),
            number(json, "pin_write_bytes")};
}

void read_traffic(RunRecord& record, const Json& traffic) {
    if (!traffic.is_object()) return;
    for (const auto& [surface, bytes] : traffic.items()) {
        if (!bytes.is_object()) continue;
        if (surface == "total")
            record.total = traffic_of(surface, bytes);
        else
            record.surfaces.push_back(traffic_of(surface, bytes));
    }
}

void read_stages(RunRecord& record, const Json& stages) {
    if (!stages.is_object()) return;
    for (const auto& [name, cycles] : stages.items()) {
        RecordedStage stage{name, number(cycles, "busy"), number(cycles, "idle"), {}};
        const Json& stalls = at(cycles, "stall");
        std::map<std::string, double> reasons;
        if (stalls.is_object()) {
            for (const auto& [reason, count] : stalls.items()) {
                const Measured value = number(count);
                if (value && *value > 0) reasons[reason] += *value;
            }
        }
        stage.stalls.assign(reasons.begin(), reasons.end());
        if (stage.busy || stage.idle || !stage.stalls.empty()) record.stages.push_back(std::move(stage));
    }
}

void read_paths(RunRecord& record, const Json& operation) {
    if (!operation.is_object()) return;
    for (const auto& [path, cost] : operation.items()) {
        if (!cost.is_object()) continue;
        record.paths.push_back(
            {path, number(cost, "count"), number(cost, "latency_cycles"), number(cost, "interval_cycles")});
    }
}

void read_pass_seconds(RunRecord& record, const Json& passes) {
    if (!passes.is_array()) return;
    for (const Json& entry : passes) {
        const Json& name = at(entry, "pass");
        const Measured seconds = number(entry, "seconds");
        if (name.is_string() && seconds) record.pass_seconds[name.get<std::string>()] += *seconds;
    }
}

// Resolved values are TOML, whose strings have quotes.
std::string unquoted(const std::string& text) {
    const bool quoted = text.size() >= 2 && text.front() == '"' && text.back() == '"';
    return quoted ? text.substr(1, text.size() - 2) : text;
}

void flatten(std::map<std::string, std::string>& out, const std::string& key, const Json& json) {
    if (json.is_object()) {
        for (const auto& [name, value] : json.items())
            flatten(out, key.empty() ? name : fmt::format("{}.{}", key, name), value);
    } else if (json.is_string()) {
        out[key] = unquoted(json.get<std::string>());
    } else if (!json.is_null()) {
        out[key] = json.dump();
    }
}

// "4.9 % of the fragments timed; with 95 % confidence cycles 45,100,000 to 48,200,000": estimates that
// matter.
std::string sample_of(const Json& json) {
    const Json& sample = at(json, "sample");
    if (!sample.is_object()) return {};
    Measured share = number(sample, "timed_share");  // of `timed` only
    if (!share) share = number(sample, "fragment_share");
    if (share) *share *= 100;
    std::string text =
        fmt::format("estimated from {} % of the fragments", format_measured(share, 1, ",", "?"));
    const std::pair<const char*, const char*> estimates[] = {
        {"cycles", "cycles"},
        {"traffic.total.pin_read_bytes", "bytes read"},
        {"traffic.total.pin_write_bytes", "bytes written"}};
    std::string intervals;
    for (const auto& [path, what] : estimates) {
        const std::optional<RecordedInterval> ends = interval(at(json, path));
        if (!ends) continue;
        intervals +=
            fmt::format("{}{} {} to {}", intervals.empty() ? "; with 95 % confidence " : ", ", what,
                        format_measured(ends->low, 0, ",", "?"), format_measured(ends->high, 0, ",", "?"));
    }
    return text + intervals;
}

// Everything at the top that is not a result; the keys of the hardware stand as the user writes them.
void read_configuration(RunRecord& record, const Json& json) {
    static const std::set<std::string> results{"technique",
                                               "trace",
                                               "cycles",
                                               "seconds",
                                               "fragments",
                                               "storage_bits_per_pixel",
                                               "traffic",
                                               "traffic_by_pass",
                                               "traffic_by_draw",
                                               "read_latency",
                                               "stages",
                                               "error",
                                               "dram",
                                               "rop_cache",
                                               "operation",
                                               "bytes_per_fragment",
                                               "host",
                                               "bottleneck",
                                               "bottlenecks",
                                               "occupancy",
                                               "passes_in_machine",
                                               "rop_cache_reuse",
                                               "passes",
                                               "touched_tiles",
                                               "pool",
                                               "bits_per_pixel_write",
                                               "shader_alu_utilisation",
                                               "front_end",
                                               "skipped",
                                               "interlock",
                                               "machine_order",
                                               "tiled",
                                               "sample"};
    for (const auto& [key, value] : json.items()) {
        if (results.count(key) != 0) continue;
        const bool bare = key == "configuration" || key == "hardware_parameters";
        flatten(record.configuration, bare ? "" : key == "technique_parameters" ? "technique" : key, value);
    }
}

}  // namespace

void read_run_json(RunRecord& record, const std::string& text, const std::string& name) {
    const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
    if (!json.is_object()) throw UserError(name, "is not a JSON object; run the technique again");
    const std::pair<const char*, Measured RunRecord::*> numbers[] = {
        {"trace.width", &RunRecord::width},
        {"trace.height", &RunRecord::height},
        {"trace.samples", &RunRecord::samples},
        {"trace.fragments", &RunRecord::fragments},
        {"cycles", &RunRecord::cycles},
        {"seconds", &RunRecord::seconds},
        {"storage_bits_per_pixel", &RunRecord::storage_bits_per_pixel},
        {"bits_per_pixel_write", &RunRecord::bits_per_pixel_write},
        {"error.rmse8", &RunRecord::rmse8},
        {"error.rmse8_covered", &RunRecord::rmse8_covered},
        {"error.psnr_db", &RunRecord::psnr_db},
        {"error.max_abs", &RunRecord::max_abs},
        {"error.mean_signed8", &RunRecord::mean_signed8},
        {"error.ssim", &RunRecord::ssim},
        {"error.flip", &RunRecord::flip},
        {"host.seconds", &RunRecord::host_seconds},
        {"host.processor_seconds", &RunRecord::host_processor_seconds},
        {"host.fragments_per_second", &RunRecord::host_fragments_per_second},
        {"host.peak_rss_bytes", &RunRecord::host_peak_rss_bytes},
        {"rop_cache.hits", &RunRecord::cache_hits},
        {"rop_cache.misses", &RunRecord::cache_misses},
        {"dram.read_bytes", &RunRecord::dram_read_bytes},
        {"dram.write_bytes", &RunRecord::dram_write_bytes},
        {"dram.row_hits", &RunRecord::dram_row_hits},
        {"dram.row_misses", &RunRecord::dram_row_misses},
        {"dram.row_conflicts", &RunRecord::dram_row_conflicts},
        {"dram.utilisation", &RunRecord::dram_utilisation},
        {"pool.nodes_used", &RunRecord::pool_nodes_used},
        {"pool.nodes_overflowed", &RunRecord::pool_nodes_overflowed},
        {"pool.node_bytes", &RunRecord::pool_node_bytes},
    };
    for (const auto& [path, member] : numbers) record.*member = number(json, path);
    record.cycles_interval = interval(at(json, "cycles"));
    record.pin_read_interval = interval(at(json, "traffic.total.pin_read_bytes"));
    record.pin_write_interval = interval(at(json, "traffic.total.pin_write_bytes"));
    record.sample = sample_of(json);
    const Json& bottleneck = at(json, "bottleneck");
    if (bottleneck.is_string()) record.bottleneck = bottleneck.get<std::string>();
    // An infinite PSNR has no JSON number.
    if (!record.psnr_db && record.rmse8 && *record.rmse8 == 0.0) record.psnr_db = HUGE_VAL;
    read_traffic(record, at(json, "traffic"));
    read_stages(record, at(json, "stages"));
    read_paths(record, at(json, "operation"));
    read_pass_seconds(record, at(json, "traffic_by_pass"));
    read_configuration(record, json);
}

}  // namespace ropsim
