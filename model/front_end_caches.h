// The caches before the shader cores, timed and not: depth units of the partitions, textures of the cores.
#pragma once

#include "model/front_end.h"
#include "model/machine_result.h"
#include "model/read_cache.h"
#include "model/read_port.h"
#include "model/shader_cores.h"
#include "model/untimed_memory.h"

#include <memory>
#include <vector>

namespace ropsim {

ReadCacheConfig depth_unit_config(const MachineConfig& config);
ReadCacheConfig texture_cache_config(const MachineConfig& config);

// Whether depths are read before shading at all.
inline bool has_depth_units(const MachineConfig& config, bool opaque) {
    return config.front.depth.early && opaque;
}

// None where the frame has nothing to read: no opaque layer, no textures.
struct FrontEndCaches {
    std::vector<std::unique_ptr<ReadPort>> ports;      // by partition
    std::vector<std::unique_ptr<ReadCache>> depth;     // by partition
    std::vector<std::unique_ptr<ReadCache>> textures;  // by core

    // `compressed`: by partition, null where nothing is. Connects the front end; the ports' sockets are the
    // caller's to bind.
    FrontEndCaches(EventWheel& wheel, const MachineConfig& config, const SurfaceMap& map, bool opaque,
                   const std::vector<CompressedSurfaces*>& compressed, TrafficBreakdown& breakdown,
                   FrontEnd& front_end);
    // Adds what the ports moved.
    void add_bytes(BytesByCause& bytes) const;
    // Closes the accounts; adds the stages that are there.
    void add_stages(std::uint64_t total_cycles, std::vector<StageReport>& stages);
    RopCacheStatistics depth_statistics() const;
    RopCacheStatistics texture_statistics() const;
};

// The same caches without a clock, over the partitions that their misses go to. Warps are dealt to the cores
// in turn, as the timed ones are while all cores have room.
class UntimedFrontEndCaches {
 public:
    // `partitions`: one for each that the configuration has.
    UntimedFrontEndCaches(const MachineConfig& config, const SurfaceMap& map,
                          std::vector<UntimedMemory*> partitions);
    void read_depths(const QuadOperation& q, const QuadBatch& batch);
    // Looked up in the core of the quad's warp.
    void fetch_texels(const QuadOperation& q, const QuadBatch& batch, std::size_t core);
    // Of the next warp.
    std::size_t next_core() {
        const std::size_t core = next_core_;
        next_core_ = core + 1 == textures_.size() ? 0 : core + 1;
        return core;
    }
    RopCacheStatistics depth_statistics() const;
    RopCacheStatistics texture_statistics() const;

 private:
    void look_up(RopCache& cache, const LineRead& read, const ReadCacheConfig& config,
                 const ByteSource& source, UntimedMemory* owner);

    const MachineConfig& config_;
    const SurfaceMap& map_;
    std::vector<UntimedMemory*> partitions_;
    ReadCacheConfig depth_config_;
    ReadCacheConfig texture_config_;
    std::vector<RopCache> depth_;
    std::vector<RopCache> textures_;
    std::size_t next_core_ = 0;
};

// What a frame's quads read before they reach the partitions, packed into warps as the front end does.
class UntimedFrontEnd {
 public:
    // `partitions`: pointers to UntimedMemory, one for each that the configuration has.
    template <class Partition>
    UntimedFrontEnd(const MachineConfig& config, const SurfaceMap& map,
                    const std::vector<Partition*>& partitions)
        : warp_quads_(config.front.shader.warp_quads),
          depth_bytes_(std::uint64_t{4} * map.pixel_bytes(map.opaque_depth())),
          packing_(config),
          caches_(config, map, {partitions.begin(), partitions.end()}),
          open_(packing_.warps()) {}
    // rasterise(), read_depths() and, of what reaches a partition, shade().
    void read(const QuadOperation& q, const QuadBatch& batch) {
        rasterise(q);
        read_depths(q, batch);
        if (reaches_partition(q)) shade(q, batch);
    }
    // In raster order, as shade().
    void rasterise(const QuadOperation& q) { counts_.rasterise(q, depth_bytes_); }
    void read_depths(const QuadOperation& q, const QuadBatch& batch) {
        if (q.depth_lines != 0) caches_.read_depths(q, batch);
    }
    void shade(const QuadOperation& q, const QuadBatch& batch);
    // Ends the warps that are being filled.
    void finish();

    FrontEndCounts counts() const;
    // Lanes' cycles that the warps take of the ALUs.
    std::uint64_t lane_cycles() const { return lane_cycles_; }

 private:
    struct Packer {
        OpenWarp open;
        std::size_t core = 0;
    };
    void close_warp(Packer& packer);

    std::uint32_t warp_quads_;
    std::uint64_t depth_bytes_;  // of a quad
    WarpPacking packing_;
    UntimedFrontEndCaches caches_;
    std::vector<Packer> open_;
    FrontEndCounts counts_;
    std::uint64_t lane_cycles_ = 0;
};

}  // namespace ropsim
