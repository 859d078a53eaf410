// The whole machine in SystemC: shader cores, ROP partitions and memory channels on one event wheel.
#pragma once

#include "model/frame.h"
#include "model/interlock_order.h"
#include "model/machine_result.h"

namespace ropsim {

class TiledQuads;

// Elaborates, simulates the frame to its end (flush included) and checks the conservation laws. Once a
// process, because SystemC elaborates once. `threads` > 1 runs the functional frame beside the timing.
// `observe`: what to look at on the way; the sentences of the summary are left to the caller. `order`, if
// any, is told in which order operations came to the pixels; only shaders that spin do not keep the trace's.
MachineResult run_timed_machine(Frame& frame, const MachineConfig& config, int threads,
                                const ObservationOptions& observe = {}, TiledQuads* tiled = nullptr,
                                InterlockOrder* order = nullptr);

}  // namespace ropsim
