// One ROP partition's cache without a clock, and what passed through it.
#pragma once

#include "memory/rop_cache.h"
#include "memory/untimed_l2.h"
#include "model/byte_counts.h"
#include "model/compressed_surfaces.h"
#include "model/machine_config.h"
#include "model/quad_operation.h"
#include "model/surface_map.h"
#include "model/traffic_breakdown.h"
#include "model/untimed_memory.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace ropsim {

// Takes a partition's quads in their order. Nothing is in flight: a line's fill is there at once. `config`
// and `map` must outlive it; several partitions of different cache sizes may take the same quads.
class CachedPartition final : public UntimedMemory {
 public:
    // `compressed`: of this partition, if anything is.
    // `breakdown`: counts for whom bytes move, if anyone asks; must outlive it.
    CachedPartition(const MachineConfig& config, const SurfaceMap& map,
                    std::unique_ptr<CompressedSurfaces> compressed = nullptr,
                    TrafficBreakdown* breakdown = nullptr);

    // A quad of the batch in this partition.
    void operate(const QuadOperation& q, const QuadBatch& batch);
    void read_for(const ByteSource& source, const MemoryRequest& request) override {
        moved_for_ = source;
        pass_on(request);
    }
    // The end of the frame: dirty bytes go to memory.
    void flush();

    const RopCache& cache() const { return cache_; }
    CompressedSurfaces* compressed() const override { return compressed_.get(); }
    const BytesByCause& port() const { return port_; }  // between cache and memory channel
    const BytesByCause& pins() const { return pins_; }  // whole bursts of the channel
    std::uint64_t tag_cycles() const { return tag_cycles_; }
    std::uint64_t operation_cycles() const { return operation_cycles_; }
    // Of the cache's memory port, whose directions work at the same time.
    std::uint64_t port_cycles() const { return std::max(port_cycles_[0], port_cycles_[1]); }
    // The slice below the cache, if there is one.
    const std::optional<UntimedL2>& l2() const { return l2_; }
    std::uint64_t bursts() const { return bursts_; }

 private:
    int allocate(const LineAccess& access);
    void fetch(const LineAccess& access, int line, MemoryCause cause, const ByteSource& source);
    void write_back(const Eviction& eviction, MemoryCause cause);
    void look_up_state(int surface, std::uint64_t address, bool changes);
    void move_metadata(const MetadataCache::Traffic& traffic, std::uint8_t surface);
    void move(std::uint64_t line_address, std::uint32_t sectors, bool write, std::uint8_t surface,
              MemoryCause cause, const Eviction* eviction = nullptr);
    void move_bytes(std::uint64_t address, std::uint32_t bytes, bool write, std::uint8_t surface,
                    MemoryCause cause);
    void move_runs(std::uint64_t line_address, std::uint32_t sectors, bool write, CauseBytes& port,
                   CauseBytes& pins);
    void move(const MemoryRequest& request);
    void pass_on(const MemoryRequest& request);
    void to_memory(const MemoryRequest& request);

    const MachineConfig& config_;
    RopCache cache_;
    std::unique_ptr<CompressedSurfaces> compressed_;
    std::optional<UntimedL2> l2_;
    TrafficBreakdown* breakdown_;
    ByteSource moved_for_;  // whose bytes move next
    BytesByCause port_;
    BytesByCause pins_;
    std::uint64_t tag_cycles_ = 0;
    std::uint64_t operation_cycles_ = 0;
    std::array<std::uint64_t, 2> port_cycles_{};  // data read, data written
    std::array<std::uint32_t, 33>
        run_port_cycles_{};  // of so many neighbouring sectors, of which a line has up to 32
    std::uint64_t bursts_ = 0;
    std::uint32_t burst_shift_;  // log2 of a burst's bytes
};

}  // namespace ropsim
