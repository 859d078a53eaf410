// What a machine measured beyond the functional frame: bytes on the pins, and for the timed one cycles.
#pragma once

#include "memory/dram_statistics.h"
#include "memory/l2_statistics.h"
#include "memory/memory_cause.h"
#include "memory/rop_cache.h"
#include "model/byte_counts.h"
#include "model/compressed_surfaces.h"
#include "model/front_end_counts.h"
#include "model/machine_observation.h"
#include "model/stage_account.h"
#include "model/traffic_breakdown.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ropsim {

// What compression did, all partitions together.
struct CompressionReport {
    std::vector<CompressionCounts> surfaces;  // by surface of the map; those that are compressed have counts
    RopCacheStatistics metadata;              // of the metadata caches

    void add(const CompressedSurfaces& partition, const SurfaceMap& map);
};

// One partition's memory channel.
struct ChannelReport {
    ReadWriteBytes pins;
    // The rest of the timed machine.
    std::uint64_t row_hits = 0, row_misses = 0, row_conflicts = 0;
    double utilisation = 0;  // share of the data bus' time, 0..1
};

// Engine `shader`: tries for a pixel's lock in memory, and those of them that found it taken.
struct InterlockReport {
    std::uint64_t tries = 0;
    std::uint64_t retries = 0;
};

struct StageReport {
    std::string name;
    StageAccount account;  // of `instances` stages added up
    std::uint32_t instances = 1;
};

struct MachineResult {
    bool timed = false;
    std::uint64_t rop_cycles = 0;  // simulated (timed) or by bottleneck analysis (cached)
    double seconds = 0;
    std::string bottleneck;              // cached: the resource whose time was longest
    RopCacheStatistics cache;            // all partitions
    std::uint64_t writes_coalesced = 0;  // lines whose write a later result joined (timed)
    CompressionReport compression;
    std::uint64_t quads = 0;  // that reached the partitions
    FrontEndCounts front_end;
    BytesByCause miss_port;          // bytes between ROP caches and what is below them
    std::optional<L2Statistics> l2;  // all slices; cached: without labels and cycles
    BytesByCause pins;               // bus bytes: whole bursts
    TrafficBreakdown breakdown;      // of what crossed the miss ports
    std::vector<ChannelReport> channels;
    double channel_peak_bytes_per_second = 0;
    // By surface (timed): picoseconds from a miss to the arrival of its sectors or block.
    std::vector<LatencyHistogram> read_latency;
    DramStatistics dram;          // all channels (timed)
    DramEnergy dram_energy;       // of all channels (timed), pJ
    double dram_utilisation = 0;  // share of the data bus' time, 0..1
    double alu_utilisation = 0;
    std::vector<StageReport> stages;
    std::vector<std::uint64_t> pass_times;     // picoseconds, by pass of the breakdown (timed)
    std::optional<InterlockReport> interlock;  // engine `shader`, timed
    MachineObservation observation;            // timed
};

}  // namespace ropsim
