// Runs, and the front of those that no other beats.
#include "analysis/tradeoff.h"

#include "analysis/comparison_table.h"
#include "analysis/pareto_front.h"
#include "analysis/standard_techniques.h"
#include "base/error.h"
#include "rop/registry.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

namespace ropsim {
namespace {

// From the control paths; empty where the technique refuses the trace.
Measured operation_bytes(const std::string& technique, const TraceHeader& header) {
    if (!refusal(technique, header).empty()) return {};
    TechniqueSpec spec = parse_technique(technique, "--technique");
    const auto operation = make_operation(spec, screen_of(header, 0));
    const ByteCount bytes = worst_case_bytes(operation->declaration(), operation->cost({}));
    return static_cast<double>(bytes.read + bytes.write);
}

// All that techniques ask of a trace.
TraceHeader header_of(const std::string& trace) {
    TraceHeader header = TraceReader(trace).header();
    header.opaque.reset();
    return header;
}

std::vector<std::string> techniques_of(const TradeoffOptions& options) {
    return options.techniques.empty() ? standard_techniques() : options.techniques;
}

Measured per(const Measured& bytes, const Measured& number) {
    if (!bytes || !number || *number <= 0) return {};
    return *bytes / *number;
}

TradeoffPoint point_of(const RunRecord& run, const TraceHeader& header) {
    TradeoffPoint point;
    point.failure = run.failure;
    point.operation_bytes = operation_bytes(run.technique, header);
    point.broken = !run.failure.empty() && point.operation_bytes;
    if (!run.failure.empty()) return point;
    point.rmse8 = run.rmse8;
    point.rmse8_covered = run.rmse8_covered;
    point.touched = per(sum_of(run.total.read, run.total.write), run.fragments);
    point.worst_case = per(sum_of(run.total.worst_case_read, run.total.worst_case_write), run.fragments);
    point.pins = per(sum_of(run.total.pin_read, run.total.pin_write), run.fragments);
    point.frame_ms = run.seconds;
    if (point.frame_ms) *point.frame_ms *= 1e3;
    point.storage_bits = run.storage_bits_per_pixel;
    if (!run.pool_node_bytes || !run.pool_nodes_used || !run.width || !run.height) return point;
    point.node_bits = 8 * *run.pool_node_bytes;
    point.pool_bits = *point.node_bits * *run.pool_nodes_used / (*run.width * *run.height);
    point.dropped = run.pool_nodes_overflowed;
    return point;
}

// Among all techniques, or among those without a pool.
std::vector<bool> front_of(const Tradeoff& tradeoff, std::size_t scene, TradeoffBytes kind, bool fixed) {
    std::vector<CostAndError> points;
    std::vector<std::size_t> owners;
    const auto bytes = bytes_kind(kind).member;
    for (std::size_t i = 0; i < tradeoff.techniques.size(); ++i) {
        const TradeoffPoint& point = tradeoff.techniques[i].at[scene];
        if (!point.rmse8 || !(point.*bytes) || (fixed && point.node_bits)) continue;
        points.push_back({*(point.*bytes), *point.rmse8});
        owners.push_back(i);
    }
    std::vector<bool> marks(tradeoff.techniques.size(), false);
    const std::vector<bool> front = pareto_front(points);
    for (std::size_t i = 0; i < owners.size(); ++i) marks[owners[i]] = front[i];
    return marks;
}

void mark_fronts(Tradeoff& tradeoff, std::size_t scene) {
    const std::vector<bool> front = scene_front(tradeoff, scene, tradeoff.options.bytes);
    const std::vector<bool> fixed = front_of(tradeoff, scene, tradeoff.options.bytes, true);
    for (std::size_t i = 0; i < front.size(); ++i) {
        tradeoff.techniques[i].at[scene].front = front[i];
        tradeoff.techniques[i].at[scene].fixed_front = fixed[i];
    }
}

}  // namespace

const TradeoffBytesKind& bytes_kind(TradeoffBytes bytes) {
    static const TradeoffBytesKind kinds[] = {
        {"touched", "count", &TradeoffPoint::touched, "bytes read and written a fragment, before caches",
         "touched"},
        {"worst_case", "count", &TradeoffPoint::worst_case,
         "bytes read and written a fragment if every one took its costliest path, before caches",
         "worst case"},
        {"pins", "cached", &TradeoffPoint::pins, "bytes on the DRAM pins a fragment, behind caches", "pins"},
        {"frame_ms", "timed", &TradeoffPoint::frame_ms, "simulated time of the frame, ms", "time"},
        {"pins_and_worst_case", "cached", &TradeoffPoint::pins,
         "bytes a fragment: on the DRAM pins behind caches (coloured), and in the worst case (grey)", "pins",
         TradeoffBytes::kWorstCase},
    };
    return kinds[static_cast<std::size_t>(bytes)];
}

std::vector<bool> scene_front(const Tradeoff& tradeoff, std::size_t scene, TradeoffBytes bytes) {
    return front_of(tradeoff, scene, bytes, false);
}

void check_tradeoff(const TradeoffOptions& options) {
    std::vector<TraceHeader> headers;
    for (const std::string& trace : options.traces) headers.push_back(header_of(trace));
    std::set<std::string> seen;
    for (const std::string& technique : options.techniques) {
        if (!seen.insert(technique).second)
            throw UserError("--technique", fmt::format("'{}' is given twice; leave one out", technique));
        std::string reason;
        const bool none = std::none_of(headers.begin(), headers.end(), [&](const TraceHeader& header) {
            reason = refusal(technique, header);
            return reason.empty();
        });
        if (none) throw UserError("--technique", reason);
    }
}

Tradeoff run_tradeoff(const TradeoffOptions& options) {
    check_tradeoff(options);
    ComparisonOptions runs;
    runs.traces = options.traces;
    runs.techniques = techniques_of(options);
    runs.run_options = {"--fidelity", bytes_kind(options.bytes).fidelity};
    runs.run_options.insert(runs.run_options.end(), options.run_options.begin(), options.run_options.end());
    runs.threads = options.threads;
    runs.directory = options.directory + "/runs";
    runs.program = options.program;
    if (!options.keep_images) runs.unwanted = {"image.exr", "tiles.exr", "tiles.png"};
    Tradeoff tradeoff{options, {}, {}};
    for (const std::string& technique : runs.techniques)
        tradeoff.techniques.push_back({technique, family_of(technique), {}});
    for (const ComparisonOfOneTrace& c : run_comparison(runs)) {
        tradeoff.scenes.push_back(
            {c.trace, c.name, c.scene, c.hash, c.width, c.height, c.samples, c.fragments});
        const TraceHeader header = header_of(c.trace);
        for (std::size_t i = 0; i < c.runs.size(); ++i)
            tradeoff.techniques[i].at.push_back(point_of(c.runs[i], header));
        mark_fronts(tradeoff, tradeoff.scenes.size() - 1);
    }
    return tradeoff;
}

std::vector<std::string> broken_runs(const Tradeoff& tradeoff) {
    std::vector<std::string> broken;
    for (std::size_t s = 0; s < tradeoff.scenes.size(); ++s)
        for (const TradeoffTechnique& technique : tradeoff.techniques)
            if (technique.at[s].broken)
                broken.push_back(fmt::format("{} {}", tradeoff.scenes[s].name, technique.technique));
    return broken;
}

}  // namespace ropsim
