// Bytes by screen tile as pictures.
#pragma once

#include "model/traffic_breakdown.h"

#include <string>

namespace ropsim {

// DIRECTORY/tiles.exr: a pixel a tile, channels read, write (bytes between ROP cache and memory); a float32
// holds them exactly up to 16 MiB. DIRECTORY/tiles.png: their sum as a heat map on a logarithmic scale in
// KiB a tile, rounded up; black where nothing moved. Throws UserError when they cannot be written.
void write_tiles(const TrafficBreakdown& breakdown, const std::string& directory);

}  // namespace ropsim
