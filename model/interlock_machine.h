// Engine `shader` as a whole: what its partitions measured, and the machine without a clock.
#pragma once

#include "model/frame.h"
#include "model/interlock_partition.h"
#include "model/machine_result.h"

#include <memory>
#include <vector>

namespace ropsim {

using InterlockPartitions = std::vector<std::unique_ptr<InterlockPartition>>;

// Adds quads, bytes, latencies and tries to the result, whose vectors by surface have their sizes.
void collect_interlocks(const InterlockPartitions& partitions, MachineResult& result);

// Where the places for quads in the shader cores spent their cycles after shading, and the ports to the L2.
// `total`: ROP cycles of the run.
std::vector<StageReport> interlock_stages(const InterlockPartitions& partitions, const MachineConfig& config,
                                          std::uint64_t total);

// `cached` fidelity: the L2 slices in raster order without a clock. Its time is that of the slowest of
// shading with the operations' instructions, the grants (export), the busiest port, slice and channel, and
// the longest chain of critical sections on one pixel. Nobody is found waiting for a lock.
MachineResult run_cached_interlock(Frame& frame, const MachineConfig& config, int threads);

}  // namespace ropsim
