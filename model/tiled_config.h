// The tile-based engine as data: tile size, on-chip tile memory, bins; and where one technique's surfaces go.
#pragma once

#include "base/parameters.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ropsim {

struct Declaration;
struct TraceHeader;

// Keys `tiled.*` of a hardware preset or file (docs/hardware.md).
struct TiledConfig {
    std::uint32_t tile = 16;                  // pixels on a side of a tile: 8, 16 or 32
    std::uint32_t memory_bytes = 32768;       // on-chip pixel state of a partition: of one tile
    bool shrink = true;                       // halve the tile while the pixel state does not fit
    std::uint32_t hit_latency = 4;            // ROP cycles from tag check to operands on chip
    std::uint32_t bytes_per_cycle = 128;      // of tile memory, read and, besides, written a ROP cycle
    std::uint32_t entry_bytes = 8;            // of a primitive in a tile's bin
    std::uint32_t primitive_bytes = 32;       // a primitive's transformed vertices, kept once
    std::uint32_t bin_entries_per_cycle = 8;  // binned a ROP cycle, of the whole machine
    bool overlap_binning = false;             // in the time of the frame before
};

// Throws UserError for values out of range.
TiledConfig read_tiled(Parameters& parameters);

// What a technique on a trace makes of it: the tile's size and the place of each surface.
struct TilePlan {
    bool tiled = false;  // false: the engine is another one, nothing is on chip
    int side = 0;        // of a tile, pixels
    int across = 0;      // tiles of the screen
    int down = 0;
    int small_across = 0;  // tiles of 8x8 pixels
    // The technique's passes up to here go tile by tile; the rest, and resolve when it is not among them, go
    // over the whole screen, since they read pixels around their own or draw at another resolution.
    int tiled_passes = 0;
    bool tiled_resolve = true;
    std::vector<std::uint8_t> on_chip;       // by surface of the SurfaceMap, the bins excepted
    std::vector<std::uint32_t> pixel_bytes;  // by technique's surface; pools 0
    std::uint64_t state_bytes = 0;           // of a tile, on chip
    std::uint64_t wanted_bytes = 0;          // of a tile, all that could be on chip
    std::uint64_t bin_bytes = 0;             // memory for bins, of the partition that needs most

    // The tile that a tile of 8x8 pixels is part of.
    std::size_t tile_of(std::size_t small) const {
        const auto wide = static_cast<std::size_t>(small_across);
        const auto each = static_cast<std::size_t>(side / 8);
        return small / wide / each * static_cast<std::size_t>(across) + small % wide / each;
    }
    bool anything_on_chip() const { return state_bytes != 0; }
};

// Surfaces come on chip in this order, up to the first that does not fit: opaque depth, the technique's by
// declaration (not pools), colour (of the opaque layer, in whose place the image is resolved). With `shrink`
// the tile is halved first, down to 8x8 pixels, until all fit. A technique of which `tiled_passes` or resolve
// reads pixels around its own has nothing on chip.
TilePlan plan_tiles(const TiledConfig& config, const Declaration& declaration, const TraceHeader& trace);

}  // namespace ropsim
