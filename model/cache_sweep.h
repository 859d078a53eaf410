// ROP caches of many sizes on one frame: its quads pass all of them at once.
#pragma once

#include "model/frame.h"
#include "model/machine_result.h"

#include <cstdint>
#include <vector>

namespace ropsim {

// What the cached machine measures with caches of one size.
struct SweptCache {
    std::uint32_t size_bytes = 0;  // of a partition
    RopCacheStatistics cache;      // all partitions
    BytesByCause miss_port;
    BytesByCause pins;
};

// A fully associative LRU cache in each partition, of the same lines and sectors: no conflicts between
// lines that share a set, and no compression. Bytes are those of the miss port: whole sectors.
struct IdealCache {
    std::uint64_t size_bytes = 0;          // of a partition; 0: without end
    std::vector<ReadWriteBytes> surfaces;  // of the map
    double line_hit_share = 0;             // of the uses of lines, 0..1
};

struct CacheSweep {
    std::vector<SweptCache> caches;  // as asked for
    std::vector<IdealCache> ideal;   // ascending, four an octave and the sizes asked for; without end last
    // By surface: bursts on the pins if nothing were kept from one quad to the next.
    std::vector<ReadWriteBytes> uncached;
    std::uint64_t line_uses = 0;          // by quads, all partitions
    std::uint64_t largest_footprint = 0;  // bytes of the lines that the partition with most of them uses
};

// Machines that differ in the size of their caches alone, by rising size; the frame was made with any of
// them. Each gives what run_cached_machine() gives with it.
CacheSweep sweep_cache_sizes(Frame& frame, const std::vector<MachineConfig>& configs, int threads);

}  // namespace ropsim
