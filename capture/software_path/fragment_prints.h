// Fingerprints of each pixel's visible fragments, to tell a difference of operations from one of their input.
#pragma once

#include "capture/software_path/arrivals.h"

#include <cstdint>
#include <vector>

namespace ropsim {

// By pixel, row by row: the sums, each modulo 2^32, over its visible fragments of two hashes of all that a
// fragment is (shaders/software_path/fragment_prints.glsl); the second sum is the upper half. 0 where there
// is none. Draws all fragments once.
std::vector<std::uint64_t> drawn_fragment_prints(Arrivals& arrivals);
// The same of a trace's fragments, without OpenGL. Reads the trace once.
std::vector<std::uint64_t> traced_fragment_prints(TraceReader& trace);

}  // namespace ropsim
