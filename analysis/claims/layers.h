// Pixels with a given number of layers: what a claim about alpha and arrival order alone is measured on.
#pragma once

#include "analysis/claims/runs.h"

namespace ropsim {

// Every pixel over black has `trace.layers` of `trace.alpha` (0: of random alphas). Scene "layers": of random
// colour at random depths, in random order. Scene "black_before_white": black ones before a white one, which
// is the last to arrive. Atomic.
void write_layers(const std::string& path, const ClaimTrace& trace, bool quick);

// trace.layers surfaces over the whole image, one after the other, each of small shaded rectangles at depths
// of their own, alpha about trace.alpha, in the trace's size and spatial samples. Atomic.
void write_surfaces(const std::string& path, const ClaimTrace& trace, bool quick);

}  // namespace ropsim
