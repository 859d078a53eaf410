// Pixels with a given number of layers of random colour and depth: what a claim about alpha and arrival order
// alone is measured on.
#pragma once

#include "analysis/claims_runs.h"

namespace ropsim {

// 64x64 pixels (quick: 32x32), over black: `layers` of trace.alpha (0: of random alphas) at random depths, in
// random order. Atomic.
void write_layers(const std::string& path, const ClaimTrace& trace, bool quick);

// trace.layers surfaces over the whole image, one after the other, each of small shaded rectangles at depths
// of their own, alpha about trace.alpha, in the trace's size and spatial samples. Atomic.
void write_surfaces(const std::string& path, const ClaimTrace& trace, bool quick);

}  // namespace ropsim
