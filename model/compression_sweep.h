// Machines that differ in what they compress on one frame: its quads pass all of their ROP caches at once.
#pragma once

#include "model/frame.h"
#include "model/machine_result.h"

#include <vector>

namespace ropsim {

// What the cached machine measures with one configuration.
struct CompressionOutcome {
    BytesByCause pins;
    CompressionReport report;
};

// Configurations may differ in compression.*, metadata.* and the size of caches: they agree on everything
// that shapes the frame's quads (CHECK for lines and partitions). `frame` is of one that compresses all
// classes of surface, so that it tells every value written. Each gives what run_cached_machine() gives with
// it: each has a map of its own, since surfaces that compress are placed by blocks.
std::vector<CompressionOutcome> sweep_compression(Frame& frame, const std::vector<MachineConfig>& configs,
                                                  int threads);

}  // namespace ropsim
