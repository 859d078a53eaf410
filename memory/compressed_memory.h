// What a partition's memory holds of its compressed surfaces: their bytes as they are now, and how each block
// is stored.
#pragma once

#include "memory/block_codec.h"
#include "memory/rop_cache.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace ropsim {

// Bytes that nobody has written yet. Called once a block, when it is first looked at.
class InitialContents {
 public:
    virtual ~InitialContents() = default;
    // `bytes` bytes of the surface in this partition, from `offset` on.
    virtual void fill(int surface, std::uint64_t offset, std::uint32_t bytes, std::uint8_t* out) const = 0;
};

// Blocks stored in memory since construction.
struct CompressionCounts {
    std::vector<std::uint64_t> by_level;  // compressed blocks written, by level of the codec
    std::uint64_t raw = 0;                // blocks that fitted no level
    std::uint64_t kept_raw = 0;      // write-backs to raw blocks that were not tried, for want of the rest
    std::uint64_t repacks = 0;       // compressed blocks read because some of them was written back
    std::uint64_t block_bytes = 0;   // of all blocks tried, as they are
    std::uint64_t stored_bytes = 0;  // and as stored

    void add(const CompressionCounts& other);
};

// The bytes that a cache holds dirty are here already: between them, cache and memory have one value of each
// byte, and a block is packed when some of it leaves the cache. So one copy of the bytes serves both.
class CompressedMemory {
 public:
    CompressedMemory(std::uint32_t block_bytes, const InitialContents& initial);

    struct SurfaceBlocks {
        int surface = 0;
        std::uint64_t first = 0;  // address range: whole blocks
        std::uint64_t bytes = 0;
        std::uint64_t tile_bytes = 0;   // whole blocks; of a pool, all
        std::uint64_t used_bytes = 0;   // of a tile: what follows is padding, always 0
        bool starts_unwritten = false;  // cleared on chip, or never read before it is written
    };
    void add(const SurfaceBlocks& blocks, BlockCodec codec);
    bool holds(int surface) const {
        return static_cast<std::size_t>(surface) < surfaces_.size() &&
               surfaces_[static_cast<std::size_t>(surface)];
    }
    std::uint32_t block_bytes() const { return block_bytes_; }
    std::uint64_t block_of(std::uint64_t address) const { return address & ~std::uint64_t{block_bytes_ - 1}; }

    // Sectors of a line that hold nothing but padding: known without being read.
    std::uint32_t padding(int surface, std::uint64_t line_address, std::uint32_t line_bytes,
                          std::uint32_t sector_bytes) const;

    // Bytes of a line change. `values` has a byte for each of the line's.
    void write(int surface, std::uint64_t line_address, const LineMask& bytes, const std::uint8_t* values);
    // As they are now.
    void read(int surface, std::uint64_t address, std::uint32_t bytes, std::uint8_t* out);

    enum class State : std::uint8_t { kUnwritten, kRaw, kCompressed };
    State state(int surface, std::uint64_t address);
    // How many bytes a block takes in memory: a level's, or all.
    std::uint32_t stored_bytes(int surface, std::uint64_t address);
    // Compresses a block as it is now, checks that it decompresses to its bytes, and stores it so. Returns
    // stored_bytes().
    std::uint32_t pack(int surface, std::uint64_t address);
    // The block is stored as it is; counted as not tried.
    void keep_raw(int surface, std::uint64_t address);
    void count_repack(int surface) { ++at(surface).counts.repacks; }

    const CompressionCounts& counts(int surface) const {
        return surfaces_[static_cast<std::size_t>(surface)]->counts;
    }
    const BlockCodec& codec(int surface) const { return surfaces_[static_cast<std::size_t>(surface)]->codec; }

 private:
    static constexpr std::uint8_t kUnknown = 0xFF;  // not looked at yet
    static constexpr std::uint8_t kUnwrittenState = 0;
    static constexpr std::uint8_t kRawState = 1;
    static constexpr std::uint8_t kFirstLevel = 2;
    static constexpr std::uint32_t kPageBlocks = 16;
    struct Stored {
        SurfaceBlocks place;
        BlockCodec codec;
        std::vector<std::uint8_t> state;                     // by block
        std::vector<std::unique_ptr<std::uint8_t[]>> pages;  // kPageBlocks blocks each, as they are now
        CompressionCounts counts;
    };
    Stored& at(int surface) { return *surfaces_[static_cast<std::size_t>(surface)]; }
    std::uint8_t* bytes_of(Stored& stored, std::size_t block);
    std::uint8_t& state_of(Stored& stored, std::size_t block);
    std::size_t number(const Stored& stored, std::uint64_t address) const;
    std::uint8_t packed_state(const Stored& stored, std::size_t block, const std::uint8_t* bytes) const;

    std::uint32_t block_bytes_;
    const InitialContents& initial_;
    std::vector<std::optional<Stored>> surfaces_;  // by number
};

}  // namespace ropsim
