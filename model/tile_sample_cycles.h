// Cycles of the frame from what the sample's stretches took.
#pragma once

#include "model/tile_sample_machine.h"
#include "model/tile_sample_squares.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace ropsim {

// 1. A stretch's cycles are regressed on its quads and its bytes on the pins, both known of the partition's
//    other quads, too: the partition's cycles, with the stretches' residuals as their variance.
// 2. The same prices on the quads and bytes of each square give the other partitions' cycles, and their
//    variance by the residuals of the squares.
// 3. Partitions work side by side, coupled through the window alone: the frame takes as long as the slowest,
//    or as the front end needs. The expectation and the interval of that largest of several uncertain numbers
//    come from draws (a function of the plan's seed).
struct CycleEstimate {
    Estimate frame;
    Estimate mean;  // of the partitions
};
CycleEstimate estimate_cycles(const std::vector<std::unique_ptr<SampleStream>>& streams,
                              const SampledTiming& timing, const SampleSquares& squares,
                              const SamplePlan& plan, double front_end_cycles);

}  // namespace ropsim
