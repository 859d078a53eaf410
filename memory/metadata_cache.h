// The states of memory's blocks (clear, raw, compressed at a level), kept in memory and cached by the ROP
// partition.
#pragma once

#include "memory/rop_cache.h"

#include <cstdint>

namespace ropsim {

struct MetadataConfig {
    std::uint32_t size_bytes = 0;  // of the cache; 0: all states are kept on chip and cost no traffic
    std::uint32_t ways = 4;
    std::uint32_t bits = 4;  // a block
};

// Sectors of 32 bytes in lines of 64. Times are the caller's.
class MetadataCache {
 public:
    static constexpr std::uint32_t kSectorBytes = 32;
    static constexpr std::uint32_t kLineBytes = 64;

    // States of `blocks` blocks of `block_bytes` lie from `base` on, a multiple of kLineBytes.
    MetadataCache(const MetadataConfig& config, std::uint64_t base, std::uint32_t block_bytes);
    static std::uint64_t bytes_for(const MetadataConfig& config, std::uint64_t memory_bytes,
                                   std::uint32_t block_bytes);

    // What a look-up moves; an address of 0 bytes stands for nothing.
    struct Traffic {
        std::uint64_t read_address = 0;
        std::uint32_t read_bytes = 0;
        std::uint64_t write_address = 0;
        std::uint32_t write_bytes = 0;
    };
    // The states of blocks in [first, first + bytes) need no fetch: one clear covers them all.
    void set_clear(std::uint64_t first, std::uint64_t bytes);
    // The block's state is here without a fetch.
    bool holds(std::uint64_t address) const;
    // Brings the state of the block at `address` here; `changes`: and it is written.
    Traffic look_up(std::uint64_t address, bool changes);
    // Whether anything is left to write back, and a write-back of some of it.
    bool dirty() const { return cache_.next_dirty(0) != RopCache::kMiss; }
    Traffic write_back();

    const RopCacheStatistics& statistics() const { return cache_.statistics(); }

 private:
    std::uint64_t state_address(std::uint64_t address) const {
        return base_ + address / block_bytes_ * bits_ / 8;
    }
    static Traffic written(const Eviction& eviction);

    RopCache cache_;
    std::uint64_t base_;
    std::uint32_t block_bytes_;
    std::uint32_t bits_;
};

}  // namespace ropsim
