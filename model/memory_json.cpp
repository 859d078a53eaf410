#include "model/memory_json.h"

#include "model/breakdown_json.h"

#include <cmath>

#include <nlohmann/json.hpp>

namespace ropsim {

using Json = nlohmann::ordered_json;

namespace {

Json number(double value) {
    return std::isfinite(value) ? Json(value) : Json(nullptr);
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

}  // namespace

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
            {"fills_avoided_by_fast_clear", c.fills_avoided},
            {"writes_coalesced", r.machine->writes_coalesced}};
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
        for (const char* key : {"row_hits", "row_misses", "row_conflicts", "utilisation", "energy_joules"})
            json[key] = nullptr;
        return json;
    }
    const DramStatistics& d = m.dram;
    json["reads"] = d.reads;
    json["writes"] = d.writes;
    json["forwarded_reads"] = d.forwarded_reads;
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
    const DramEnergy& energy = m.dram_energy;
    json["energy_joules"] =
        energy.total() == 0
            ? Json(nullptr)
            : Json{{"activate", energy.activate * 1e-12},     {"read", energy.read * 1e-12},
                   {"write", energy.write * 1e-12},           {"refresh", energy.refresh * 1e-12},
                   {"background", energy.background * 1e-12}, {"total", energy.total() * 1e-12}};
    return json;
}

}  // namespace ropsim
