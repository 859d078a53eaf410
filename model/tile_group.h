// Some tiles of the tiled engine with their fragments, which are run together.
#pragma once

#include "model/tiled_config.h"
#include "traces/trace.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ropsim {

struct TileGroup {
    std::vector<std::uint32_t> tiles;    // of the plan, each with fragments
    std::vector<std::size_t> first;      // of each one's fragments; one more for the end
    FragmentChunk fragments;             // tile by tile, in each in the order of the trace
    std::vector<std::uint8_t> selected;  // by 8x8 tile of the screen: part of one of the tiles

    // The 8x8 tiles of tile `tile` that lie on a screen so many of them across and down.
    static std::vector<std::size_t> small_tiles(const TilePlan& plan, std::uint32_t tile, int small_down);
};

// Reads the fragments of `tiles` with the `channels` that are wanted. The reader's selection is changed.
TileGroup read_tile_group(TraceReader& trace, const TilePlan& plan, std::vector<std::uint32_t> tiles,
                          unsigned channels);

// Tiles with fragments, shared out into groups that are read at once: whole regions of the trace where those
// have at most `most_fragments`, else parts of one; in order of regions and tiles, both row by row.
std::vector<std::vector<std::uint32_t>> tile_groups(const TraceReader& trace, const TilePlan& plan,
                                                    std::uint64_t most_fragments);

}  // namespace ropsim
