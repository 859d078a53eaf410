#include "model/run_json.h"

#include "base/version.h"
#include "model/breakdown_json.h"
#include "model/front_end_json.h"
#include "model/memory_json.h"
#include "model/observation_json.h"
#include "model/skip_json.h"
#include "model/tile_sample_json.h"
#include "model/tiled_json.h"

#include <cmath>

#include <nlohmann/json.hpp>

namespace ropsim {

namespace {

using Json = nlohmann::ordered_json;

// JSON has no infinity and no NaN: null, as for anything not measured.
Json number(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
}

const char* fidelity_name(Fidelity fidelity) {
    switch (fidelity) {
        case Fidelity::kCount:
            return "count";
        case Fidelity::kCached:
            return "cached";
        case Fidelity::kTimed:
            return "timed";
    }
    return "";
}

const char* engine_name(Engine engine) {
    switch (engine) {
        case Engine::kRop:
            return "rop";
        case Engine::kShader:
            return "shader";
        case Engine::kTiled:
            return "tiled";
    }
    return "";
}

Json parameters_json(const Parameters& parameters) {
    Json json = Json::object();
    for (const auto& [key, resolved] : parameters.resolved()) json[key] = resolved.value;
    return json;
}

Json trace_json(const RunResult& r) {
    return {{"file", r.options.trace},  {"hash", r.trace_hash},         {"scene", r.trace.scene},
            {"width", r.trace.width},   {"height", r.trace.height},     {"samples", r.trace.samples},
            {"fragments", r.fragments}, {"draws", r.trace.draws.size()}};
}

int node_bytes(const Declaration& declaration) {
    int bytes = 0;
    for (const Surface& surface : declaration.surfaces)
        if (surface.layout == Layout::kPool) bytes += surface.element_bytes();
    return bytes;
}

Json stages_json(const RunResult& r) {
    if (!r.machine || !r.machine->timed) return nullptr;
    Json json = Json::object();
    for (const StageReport& stage : r.machine->stages) {
        Json entry = {{"instances", stage.instances},
                      {"busy", stage.account.cycles(StageLabel::kBusy)},
                      {"idle", stage.account.cycles(StageLabel::kIdle)}};
        Json stalls = Json::object();
        for (int l = static_cast<int>(StageLabel::kIdle) + 1; l < kStageLabels; ++l) {
            const std::uint64_t cycles = stage.account.cycles(static_cast<StageLabel>(l));
            if (cycles > 0) stalls[std::string(kStageLabelNames[static_cast<std::size_t>(l)])] = cycles;
        }
        entry["stall"] = stalls;
        json[stage.name] = entry;
    }
    return json;
}

Json operation_json(const RunResult& r) {
    Json json = Json::object();
    for (const OperationCount& op : r.operations) {
        Json units = Json::object();
        for (std::size_t u = 0; u < static_cast<std::size_t>(kUnitCount); ++u)
            if (op.cost.work.units[u] > 0) units[std::string(kUnitNames[u])] = op.cost.work.units[u];
        Json entry = {{"count", op.count},
                      {"latency_cycles", op.cost.latency()},
                      {"interval_cycles", op.cost.interval},
                      {"units", units}};
        for (std::size_t k = 0; k < 2; ++k)
            if (op.cost.has_step[k])
                entry[fmt::format("step_{}", k)] = {{"count", op.steps[k]},
                                                    {"latency_cycles", op.cost.step[k].latency},
                                                    {"interval_cycles", op.cost.step_interval[k]}};
        json[op.cost.name] = entry;
    }
    return json;
}

Json error_json(const RunResult& r) {
    if (!r.error) return nullptr;
    const ImageError& e = *r.error;
    return {{"reference", r.declaration.colored_transmission ? "colored transmission" : "alpha"},
            {"rmse8", number(e.rmse8)},
            {"rmse8_covered", number(e.rmse8_covered)},
            {"psnr_db", number(e.psnr_db)},
            {"max_abs", number(e.max_abs)},
            {"mean_signed8", number(e.mean_signed8)},
            {"ssim", number(e.ssim)},
            {"flip", number(e.flip)}};
}

}  // namespace

std::string run_json(const RunResult& r) {
    const SurfaceTraffic total = traffic_total(r);
    const double pixels = static_cast<double>(r.trace.width) * static_cast<double>(r.trace.height);
    Json json;
    json["ropsim"] = kVersion;
    json["technique"] = r.options.technique;
    json["technique_parameters"] = parameters_json(r.technique.parameters);
    json["trace"] = trace_json(r);
    json["hardware"] = r.options.hardware;
    json["hardware_parameters"] = parameters_json(r.hardware);
    json["fidelity"] = fidelity_name(r.options.fidelity);
    json["engine"] = engine_name(r.options.engine);
    json["order"] = r.options.order == Order::kTrace ? "trace" : "machine";
    json["seed"] = r.options.seed;
    json["cycles"] = r.machine ? Json(r.machine->rop_cycles) : Json(nullptr);
    json["seconds"] = r.machine ? Json(r.machine->seconds) : Json(nullptr);
    json["bottleneck"] = r.machine ? Json(r.machine->bottleneck) : Json(nullptr);
    json["bottlenecks"] = bottlenecks_json(r);
    json["fragments"] = {{"input", r.counts.input},           {"depth_culled", r.counts.depth_culled},
                         {"zero_alpha", r.counts.zero_alpha}, {"between_samples", r.counts.between},
                         {"joined", r.counts.joined},         {"operated", r.counts.operated}};
    json["skipped"] = skipped_json(r);
    json["passes"] = r.passes;
    json["touched_tiles"] = r.touched_tiles;
    json["storage_bits_per_pixel"] = r.declaration.storage_bits_per_pixel();
    if (r.declaration.node_words > 0)
        json["pool"] = {{"nodes_used", r.pool_nodes_used},
                        {"nodes_overflowed", r.pool_nodes_overflowed},
                        {"node_bytes", node_bytes(r.declaration)}};
    json["traffic"] = traffic_json(r);
    json["traffic_by_pass"] = traffic_by_pass_json(r);
    json["traffic_by_draw"] = traffic_by_draw_json(r);
    if (r.tiled) json["tiled"] = tiled_json(r);
    json["bytes_per_fragment"] =
        r.counts.input > 0
            ? number(static_cast<double>(total.read + total.write) / static_cast<double>(r.counts.input))
            : Json(nullptr);
    json["bits_per_pixel_write"] = number(8.0 * static_cast<double>(total.write) / pixels);
    json["front_end"] = front_end_json(r);
    json["interlock"] = r.machine && r.machine->interlock ? Json{{"tries", r.machine->interlock->tries},
                                                                 {"retries", r.machine->interlock->retries}}
                                                          : Json(nullptr);
    json["rop_cache"] = r.options.engine == Engine::kShader ? Json(nullptr) : cache_json(r);
    json["rop_cache_reuse"] = reuse_json(r);
    json["read_latency"] = read_latency_json(r);
    json["compression"] = compression_json(r);
    json["l2"] = l2_json(r);
    json["dram"] = dram_json(r);
    json["shader_alu_utilisation"] =
        r.machine && r.machine->timed ? Json(r.machine->alu_utilisation) : Json(nullptr);
    json["stages"] = stages_json(r);
    json["occupancy"] = occupancy_json(r);
    json["passes_in_machine"] = passes_json(r);
    json["operation"] = operation_json(r);
    if (r.order)
        json["machine_order"] = {{"inversions", r.order->inversions},
                                 {"pixels_different", r.order->pixels_different},
                                 {"rmse8_to_trace_order", number(r.order->rmse8)}};
    json["error"] = error_json(r);
    json["host"] = {{"seconds", r.host_seconds},
                    {"processor_seconds", r.host_processor_seconds},
                    {"fragments_per_second", number(static_cast<double>(r.fragments) / r.host_seconds)},
                    {"peak_rss_bytes", r.peak_rss_bytes},
                    {"threads", r.options.threads}};
    json["threads"] = r.options.threads;
    if (r.sample) put_estimates(*r.sample, json);
    return json.dump(2) + "\n";
}

}  // namespace ropsim
