// Reads the deep OpenEXR files of other programs as fragments without an arrival order, and gives them one.
#pragma once

#include "traces/interchange/deep_exr.h"
#include "traces/interchange/deep_exr_file.h"
#include "traces/trace.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace ropsim {

struct ForeignDeepImage {
    TraceHeader header;
    std::vector<Fragment> fragments;   // pixel after pixel in rows, within a pixel as in the file
    std::vector<std::uint32_t> start;  // of each pixel in `fragments`, row-major, and the end
    std::vector<std::string> notes;    // what the user should know, a line each
};

// Throws UserError on what a trace cannot hold: negative or NaN depth, alpha outside [0, 1], colours that are
// not finite, volumes that overlap, more than 2^32 - 1 samples.
ForeignDeepImage read_foreign_deep_exr(DeepExrFile& file);

// Hands the fragments on in rounds: the first arrival of every pixel, tile by tile and quad by quad, then the
// second, ...; in pieces of at most 2^16.
void emit_in_rounds(const ForeignDeepImage& image, DeepOrder order, std::uint64_t seed,
                    const std::function<void(const std::vector<Fragment>&)>& sink);

}  // namespace ropsim
