// What the tiled engine reports of a run.
#pragma once

#include "model/tiled_config.h"

#include <cstdint>

namespace ropsim {

// What the tiled engine did besides operating on fragments.
struct TiledReport {
    TilePlan plan;
    std::uint64_t tiles = 0;        // with primitives
    std::uint64_t primitives = 0;   // binned
    std::uint64_t bin_entries = 0;  // of all tiles
    std::uint64_t bin_written = 0;  // bytes
    std::uint64_t bin_read = 0;     // bytes, of every pass over every tile
    std::uint64_t loaded = 0;       // bytes of the opaque layer loaded into tile memory
    std::uint64_t stored = 0;       // bytes of finished colours stored from it
};

}  // namespace ropsim
