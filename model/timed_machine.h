// The whole machine in SystemC: shader cores, ROP partitions and memory channels on one event wheel.
#pragma once

#include "model/frame.h"
#include "model/machine_result.h"

namespace ropsim {

// Elaborates, simulates the frame to its end (flush included) and checks the conservation laws. Once a
// process, because SystemC elaborates once. `threads` > 1 runs the functional frame beside the timing.
MachineResult run_timed_machine(Frame& frame, const MachineConfig& config, int threads);

}  // namespace ropsim
