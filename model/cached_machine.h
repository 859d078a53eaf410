// The caches without the clock: bytes on the DRAM pins, and the frame's time as its slowest resource would
// allow.
#pragma once

#include "model/frame.h"
#include "model/machine_result.h"

namespace ropsim {

class TiledQuads;

// Same caches, same order of accesses within a partition as the timed machine without delays; nothing is in
// flight, so a line's fill is there at once. Time is the largest of: shading, rasterising, export, the
// busiest partition's tag checks and operations, and the busiest channel's bursts at their peak rate.
// `tiled`: the frame's quads as the tiled engine comes to them.
MachineResult run_cached_machine(Frame& frame, const MachineConfig& config, int threads,
                                 TiledQuads* tiled = nullptr);

}  // namespace ropsim
