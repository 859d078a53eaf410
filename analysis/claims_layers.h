// Pixels with a given number of layers of random colour and depth: what a claim about alpha and arrival order
// alone is measured on.
#pragma once

#include "analysis/claims_runs.h"

namespace ropsim {

// 64x64 pixels (quick: 32x32), over black: `layers` of trace.alpha (0: of random alphas) at random depths, in
// random order. Atomic.
void write_layers(const std::string& path, const ClaimTrace& trace, bool quick);

}  // namespace ropsim
