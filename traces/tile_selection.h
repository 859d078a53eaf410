// Which regions of a trace file hold tiles that a reader wants.
#pragma once

#include "traces/trace.h"
#include "traces/trace_index.h"

#include <cstdint>
#include <utility>
#include <vector>

namespace ropsim {

class TileSelection {
 public:
    // No flags: all tiles. `tiles`, else, holds one for each tile of the image.
    void select(std::vector<std::uint8_t> tiles, const TraceIndex& index) {
        tiles_ = std::move(tiles);
        regions_.clear();
        if (tiles_.empty()) return;
        const TraceHeader& header = index.stored.header;
        const int side = index.stored.region_side;
        const auto columns = static_cast<std::size_t>((header.width + side - 1) / side);
        const auto rows = static_cast<std::size_t>((header.height + side - 1) / side);
        const auto tile_columns = static_cast<std::size_t>(tiles_across(header.width));
        const auto tiles_a_side = static_cast<std::size_t>(side / kTileSize);
        regions_.assign(columns * rows, 0);
        for (std::size_t tile = 0; tile < tiles_.size(); ++tile)
            if (tiles_[tile])
                regions_[tile / tile_columns / tiles_a_side * columns + tile % tile_columns / tiles_a_side] =
                    1;
    }

    bool all() const { return tiles_.empty(); }
    const std::vector<std::uint8_t>& tiles() const { return tiles_; }
    bool tile(std::size_t number) const { return tiles_[number] != 0; }
    bool region(std::uint32_t number) const { return regions_.empty() || regions_[number] != 0; }

    // Whether most fragments of the wanted regions are not of wanted tiles.
    bool decodes_mostly_others(const TraceIndex& index) const {
        if (all()) return false;
        std::uint64_t selected = 0;
        for (std::size_t t = 0; t < tiles_.size(); ++t) selected += tile(t) ? index.tiles[t] : 0;
        std::uint64_t decoded = 0;
        for (const BlockRecord& record : index.blocks)
            decoded += region(record.region) ? record.fragments : 0;
        return 2 * selected < decoded;
    }

 private:
    std::vector<std::uint8_t> tiles_;
    std::vector<std::uint8_t> regions_;
};

}  // namespace ropsim
