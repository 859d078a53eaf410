// Pixels with a given number of layers: what a claim about alpha and arrival order alone is measured on.
#pragma once

#include "analysis/claims_runs.h"

namespace ropsim {

// Every pixel over black has `trace.layers` of `trace.alpha` (0: of random alphas). Scene "layers": of random
// colour at random depths, in random order. Scene "black_before_white": black ones before a white one, which
// is the last to arrive. Atomic.
void write_layers(const std::string& path, const ClaimTrace& trace, bool quick);

}  // namespace ropsim
