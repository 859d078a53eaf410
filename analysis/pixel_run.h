// One technique on one pixel's fragments: every pass in its order, then its state can be asked.
#pragma once

#include "rop/operation.h"
#include "rop/pixel_store.h"
#include "traces/trace.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <tuple>
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

// The same of several pixels in one go over their tiles.
struct PixelPlace {
    int x = 0, y = 0;
    bool operator==(const PixelPlace&) const = default;
    bool operator<(const PixelPlace& other) const { return std::tie(x, y) < std::tie(other.x, other.y); }
};
// "X,Y", neither negative. Throws UserError{where, ...} for anything else.
PixelPlace parse_pixel_place(const std::string& text, const std::string& where);
std::vector<PixelFragments> read_pixels(TraceReader& trace, std::span<const PixelPlace> places);

// What a surface holds of the pixel: its elements that differ from how the frame starts, values as text.
struct StoredElement {
    int element = 0;                  // of a pool, the node
    std::vector<std::string> values;  // one a field, channels side by side; bits in hexadecimal
};
struct StoredSurface {
    std::string name;
    std::vector<std::string> fields;  // formats, with how many channels
    int elements = 0;                 // declared; of a pool, nodes taken
    std::vector<StoredElement> changed;
};

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
    // Every surface as the passes have left it.
    std::vector<StoredSurface> stored();
    // Why one pixel's fragments alone do not give the state that a frame gives, in a few words; empty: they
    // do.
    static std::string beyond_one_pixel(const Declaration& declaration, const TraceHeader& header);

 private:
    void run_passes(const TraceHeader& header, const PixelFragments& pixel);

    std::unique_ptr<FramebufferOperation> operation_;
    std::unique_ptr<PixelStore> store_;
    int x_;
    int y_;
};

}  // namespace ropsim
