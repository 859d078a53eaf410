// One technique on one pixel's fragments: every pass in its order, then its state can be asked.
#pragma once

#include "rop/operation.h"
#include "rop/pixel_store.h"
#include "traces/trace.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace ropsim {

// Those of a pixel's fragments that the opaque layer leaves to be seen, in arrival order, their coverage cut
// down to the samples where they are.
struct PixelFragments {
    int x = 0, y = 0;
    std::vector<Fragment> fragments;
    std::vector<DepthSlope> slopes;  // as long; zero where the trace has none
    std::uint64_t hidden = 0;        // fragments behind the opaque layer
};

// Reads the tiles of the pixel only. The pixel must lie inside the image (CHECK). The trace is left rewound
// with all tiles selected.
PixelFragments read_pixel(TraceReader& trace, int x, int y);

// The pixel with the most fragments that are to be seen, of equal ones the first row by row; its number is 0
// where no fragment is. Reads the whole trace.
struct DeepestPixel {
    int x = 0, y = 0;
    std::uint64_t fragments = 0;
};
DeepestPixel deepest_pixel(TraceReader& trace);

class PixelRun {
 public:
    // Runs the technique's passes, rounds and restored surfaces included. Dropped before, as everywhere:
    // fragments of zero alpha and colour where the technique declares that harmless. `header` must outlive
    // the run. Throws UserError for a technique that is misspelt or refuses the trace.
    PixelRun(const TraceHeader& header, const PixelFragments& pixel, const std::string& technique,
             std::uint64_t seed);

    const FramebufferOperation& operation() const { return *operation_; }
    bool has_visibility() const { return operation_->has_visibility(); }
    // The transmittance in front of each depth, as the technique represents it.
    std::vector<float> visibility(std::span<const float> depths);

 private:
    void run_passes(const TraceHeader& header, const PixelFragments& pixel);

    std::unique_ptr<FramebufferOperation> operation_;
    std::unique_ptr<PixelStore> store_;
    int x_;
    int y_;
};

}  // namespace ropsim
