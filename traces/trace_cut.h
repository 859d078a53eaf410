// Cuts a smaller trace out of a trace: by screen region, tiles, draws, or number.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ropsim {

// Pixels [x, x + width) by [y, y + height).
struct CutRegion {
    int x = 0, y = 0, width = 0, height = 0;
};

// A fragment is kept where everything that is given here keeps it.
struct CutOptions {
    std::optional<CutRegion> region;     // must lie inside the image
    std::string draws;                   // numbers, ranges A-B and names, with commas between; empty: all
    int every_nth_tile = 1;              // 1 or more: one 8x8 tile in so many, spread evenly
    std::optional<std::uint64_t> first;  // of the fragments that the others keep, in arrival order
};

// Copies what is kept, in arrival order, with values as stored. All else stays as it is: size, camera, draws,
// opaque layer, pixel coordinates and primitives; so what depends on a pixel's place or a primitive's number,
// randomness above all, is the same as in the whole trace. Tiles outside are not decoded. Throws UserError on
// options that do not fit the trace.
void cut_trace(const std::string& trace_path, const std::string& out_path, const CutOptions& options);

// "X,Y,WxH". Throws UserError.
CutRegion parse_cut_region(const std::string& text);

}  // namespace ropsim
