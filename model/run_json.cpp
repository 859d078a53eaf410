#include "model/run_json.h"

#include "base/version.h"
#include "model/breakdown_json.h"

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

struct PinBytes {
    std::uint64_t read = 0;
    std::uint64_t write = 0;
};

PinBytes pins_of(const MachineResult& machine, std::size_t surface) {
    PinBytes sum;
    for (const CauseBytes& cause : machine.pins[surface]) {
        sum.read += cause.read;
        sum.write += cause.write;
    }
    return sum;
}

Json traffic_entry(const SurfaceTraffic& t, const PinBytes* pins) {
    Json json = {{"worst_case_read_bytes", t.worst_read},
                 {"worst_case_write_bytes", t.worst_write},
                 {"read_bytes", t.read},
                 {"write_bytes", t.write}};
    json["pin_read_bytes"] = pins != nullptr ? Json(pins->read) : Json(nullptr);
    json["pin_write_bytes"] = pins != nullptr ? Json(pins->write) : Json(nullptr);
    return json;
}

Json cause_json(const MachineResult& machine, std::size_t surface) {
    Json json = Json::object();
    for (std::size_t c = 0; c < kMemoryCauses; ++c) {
        const CauseBytes& port = machine.miss_port[surface][c];
        const CauseBytes& pins = machine.pins[surface][c];
        const PortBytes below =
            machine.l2 ? machine.l2->memory[surface][c] : PortBytes{port.read, port.write};
        if (port.read + port.write + below.read + below.write == 0) continue;
        Json& entry = json[to_string(static_cast<MemoryCause>(c))];
        entry = {{"miss_port_read_bytes", port.read},
                 {"miss_port_write_bytes", port.write},
                 {"pin_read_bytes", pins.read},
                 {"pin_write_bytes", pins.write},
                 {"forwarded_bytes", pins.forwarded},
                 {"padding_bytes", pins.read + pins.forwarded + pins.write - below.read - below.write}};
        if (!machine.l2) continue;
        entry["l2_read_bytes"] = below.read;
        entry["l2_write_bytes"] = below.write;
    }
    return json;
}

SurfaceTraffic traffic_total(const RunResult& r) {
    SurfaceTraffic total;
    for (const SurfaceTraffic& t : r.traffic) {
        total.worst_read += t.worst_read;
        total.worst_write += t.worst_write;
        total.read += t.read;
        total.write += t.write;
    }
    return total;
}

Json traffic_json(const RunResult& r) {
    Json json = Json::object();
    PinBytes all;
    for (std::size_t s = 0; s < r.surfaces.size(); ++s) {
        PinBytes pins;
        if (r.machine) pins = pins_of(*r.machine, s);
        all.read += pins.read;
        all.write += pins.write;
        const SurfaceTraffic& t = r.traffic[s];
        // Surfaces that this run has no use for are not listed.
        if (t.worst_read + t.worst_write + t.read + t.write + pins.read + pins.write == 0) continue;
        json[r.surfaces[s]] = traffic_entry(t, r.machine ? &pins : nullptr);
        if (r.machine) json[r.surfaces[s]]["causes"] = cause_json(*r.machine, s);
    }
    json["total"] = traffic_entry(traffic_total(r), r.machine ? &all : nullptr);
    return json;
}

int node_bytes(const Declaration& declaration) {
    int bytes = 0;
    for (const Surface& surface : declaration.surfaces)
        if (surface.layout == Layout::kPool) bytes += surface.element_bytes();
    return bytes;
}

Json cache_json(const RunResult& r) {
    if (!r.machine) return nullptr;
    const RopCacheStatistics& c = r.machine->cache;
    return {{"hits", c.sector_hits},
            {"misses", c.sector_misses},
            {"merged_misses", c.sector_merges},
            {"line_allocations", c.line_allocations},
            {"line_evictions", c.line_evictions},
            {"sectors_written_back", c.sectors_written_back},
            {"bytes_written_back", c.bytes_written_back},
            {"fills_avoided_by_fast_clear", c.fills_avoided}};
}

// Blocks as they were written: how many fitted which size. Null where nothing is compressed.
Json compression_json(const RunResult& r) {
    if (!r.machine || !r.compression) return nullptr;
    Json surfaces = Json::object();
    for (std::size_t s = 0; s < r.machine->compression.surfaces.size(); ++s) {
        const CompressionCounts& counts = r.machine->compression.surfaces[s];
        if (counts.by_level.empty()) continue;
        Json blocks = Json::object();
        for (std::size_t l = 0; l < counts.by_level.size(); ++l)
            blocks[fmt::format("of_{}_bytes", r.compression->levels[l])] = counts.by_level[l];
        blocks["raw"] = counts.raw;
        blocks["kept_raw"] = counts.kept_raw;
        surfaces[r.surfaces[s]] = {
            {"blocks", blocks},
            {"repacks", counts.repacks},
            {"tried_bytes", counts.block_bytes},
            {"stored_bytes", counts.stored_bytes},
            {"ratio", counts.stored_bytes > 0 ? number(static_cast<double>(counts.block_bytes) /
                                                       static_cast<double>(counts.stored_bytes))
                                              : Json(nullptr)}};
    }
    Json json = {{"block_bytes", r.compression->block_bytes}, {"surfaces", surfaces}};
    const RopCacheStatistics& m = r.machine->compression.metadata;
    json["metadata_cache"] = r.compression->metadata.size_bytes == 0
                                 ? Json(nullptr)
                                 : Json{{"hits", m.sector_hits},
                                        {"misses", m.sector_misses},
                                        {"fills_avoided_by_fast_clear", m.fills_avoided},
                                        {"bytes_written_back", m.bytes_written_back}};
    return json;
}

Json l2_json(const RunResult& r) {
    if (!r.machine || !r.machine->l2) return nullptr;
    const L2Statistics& l2 = *r.machine->l2;
    PortBytes above;
    PortBytes below;
    for (std::size_t s = 0; s < kMaxSurfaces; ++s) {
        for (std::size_t c = 0; c < kMemoryCauses; ++c) {
            above.read += l2.looked_up[s][c].read;
            above.write += l2.looked_up[s][c].write;
            below.read += l2.memory[s][c].read;
            below.write += l2.memory[s][c].write;
        }
    }
    return {{"reads", l2.reads},
            {"writes", l2.writes},
            {"read_bytes", above.read},
            {"write_bytes", above.write},
            {"hits", l2.cache.sector_hits},
            {"misses", l2.cache.sector_misses},
            {"merged_misses", l2.cache.sector_merges},
            {"line_allocations", l2.cache.line_allocations},
            {"line_evictions", l2.cache.line_evictions},
            {"sectors_written_back", l2.cache.sectors_written_back},
            {"bytes_written_back", l2.cache.bytes_written_back},
            {"memory_read_bytes", below.read},
            {"memory_write_bytes", below.write}};
}

Json dram_json(const RunResult& r) {
    if (!r.machine) return nullptr;
    const MachineResult& m = *r.machine;
    std::uint64_t read = 0;
    std::uint64_t write = 0;
    for (std::size_t s = 0; s < m.pins.size(); ++s) {
        read += pins_of(m, s).read;
        write += pins_of(m, s).write;
    }
    Json json = {{"read_bytes", read}, {"write_bytes", write}, {"channels", channels_json(r)}};
    if (!m.timed) {
        for (const char* key : {"row_hits", "row_misses", "row_conflicts", "utilisation"})
            json[key] = nullptr;
        return json;
    }
    const DramStatistics& d = m.dram;
    json["row_hits"] = d.row_hits;
    json["row_misses"] = d.row_misses;
    json["row_conflicts"] = d.row_conflicts;
    json["utilisation"] = m.dram_utilisation;
    json["activations"] = d.activations;
    json["precharges"] = d.precharges;
    json["refreshes"] = d.refreshes;
    json["turnarounds"] = d.turnarounds;
    json["bytes_per_second"] = number(static_cast<double>(read + write) / m.seconds);
    Json labels = Json::object();
    for (int l = 0; l < kDramLabels; ++l) {
        const auto label = static_cast<DramLabel>(l);
        labels[to_string(label)] = d.label(label);
    }
    json["channel_cycles"] = labels;
    return json;
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
    json["engine"] = "rop";
    json["order"] = "trace";
    json["seed"] = r.options.seed;
    json["cycles"] = r.machine ? Json(r.machine->rop_cycles) : Json(nullptr);
    json["seconds"] = r.machine ? Json(r.machine->seconds) : Json(nullptr);
    json["bottleneck"] = r.machine && !r.machine->timed ? Json(r.machine->bottleneck) : Json(nullptr);
    json["fragments"] = {{"input", r.counts.input},           {"depth_culled", r.counts.depth_culled},
                         {"zero_alpha", r.counts.zero_alpha}, {"between_samples", r.counts.between},
                         {"joined", r.counts.joined},         {"operated", r.counts.operated}};
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
    json["bytes_per_fragment"] =
        r.counts.input > 0
            ? number(static_cast<double>(total.read + total.write) / static_cast<double>(r.counts.input))
            : Json(nullptr);
    json["bits_per_pixel_write"] = number(8.0 * static_cast<double>(total.write) / pixels);
    json["rop_cache"] = cache_json(r);
    json["read_latency"] = read_latency_json(r);
    json["compression"] = compression_json(r);
    json["l2"] = l2_json(r);
    json["dram"] = dram_json(r);
    json["shader_alu_utilisation"] =
        r.machine && r.machine->timed ? Json(r.machine->alu_utilisation) : Json(nullptr);
    json["stages"] = stages_json(r);
    json["operation"] = operation_json(r);
    json["error"] = error_json(r);
    json["host"] = {{"seconds", r.host_seconds},
                    {"fragments_per_second", number(static_cast<double>(r.fragments) / r.host_seconds)},
                    {"peak_rss_bytes", r.peak_rss_bytes},
                    {"threads", r.options.threads}};
    json["threads"] = r.options.threads;
    return json.dump(2) + "\n";
}

}  // namespace ropsim
