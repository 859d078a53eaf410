// Bytes between ROP caches and memory by pass, draw and screen tile: who moved them, next to why.
#pragma once

#include "model/byte_counts.h"
#include "model/quad_operation.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

// A read belongs to the quad that missed, a write to the one that last wrote the line, whenever it leaves;
// a compressed block to the line that leaves, a read or write of states to what they were looked up for.
class TrafficBreakdown {
 public:
    TrafficBreakdown() = default;
    // `passes`: names by ByteSource::pass. `across`, `down`: tiles of the screen.
    TrafficBreakdown(const std::vector<std::string>& passes, std::size_t draws, int across, int down);

    void add(const ByteSource& source, std::uint32_t bytes, bool write) {
        (write ? passes_[source.pass].bytes.write : passes_[source.pass].bytes.read) += bytes;
        ReadWriteBytes& draw = draws_[std::min<std::size_t>(source.draw, draws_.size() - 1)];
        (write ? draw.write : draw.read) += bytes;
        if (source.scale == 1 && source.tile != ByteSource::kNoTile)
            (write ? tiles_[source.tile].write : tiles_[source.tile].read) += bytes;
        else
            add_elsewhere(source, bytes, write);
    }

    // What is left to move when every pass is over: states of blocks, which lie in no tile.
    ByteSource end_of_frame() const {
        return {ByteSource::kNoTile, ByteSource::kNoDraw, static_cast<std::uint8_t>(passes_.size() - 1), 1};
    }

    struct OfPass {
        std::string name;
        ReadWriteBytes bytes;
    };
    const std::vector<OfPass>& passes() const { return passes_; }
    // By draw of the trace; the last is what no draw did (initial contents, image passes, resolve).
    const std::vector<ReadWriteBytes>& draws() const { return draws_; }
    // Row by row. Bytes of a tile at a lower resolution are shared out over the tiles that it covers.
    const std::vector<ReadWriteBytes>& tiles() const { return tiles_; }
    ReadWriteBytes without_tile() const { return without_tile_; }
    int across() const { return across_; }
    int down() const { return down_; }
    // Aborts unless passes, draws, and tiles with what has none, each sum to what crossed the miss ports.
    void check(const BytesByCause& miss_port) const;

 private:
    void add_elsewhere(const ByteSource& source, std::uint32_t bytes, bool write);

    std::vector<OfPass> passes_;
    std::vector<ReadWriteBytes> draws_;
    std::vector<ReadWriteBytes> tiles_;
    ReadWriteBytes without_tile_;
    int across_ = 0;
    int down_ = 0;
};

}  // namespace ropsim
