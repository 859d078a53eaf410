// The machine's oracle: front end and ROP partitions as stages that do one cycle's work at every ROP cycle.
// Slow and obvious; shares with the machine only the tag store, the memory port, the DRAM channel and the
// quads that go in.
#pragma once

#include "model/frame.h"
#include "model/machine_config.h"
#include "model/machine_result.h"

namespace ropsim {

// Simulates the frame to its end. Cycles, miss-port bytes and cache counts are set, nothing else. Once a
// process, as run_timed_machine().
MachineResult run_event_twin(Frame& frame, const MachineConfig& config);

}  // namespace ropsim
