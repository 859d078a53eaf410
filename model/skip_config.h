// Work that a machine may leave out, each kind with a switch, and what leaving it out has saved.
#pragma once

#include "base/parameters.h"

#include <cstdint>

namespace ropsim {

// Pixels [x0, x1) x [y0, y1).
struct ScreenRegion {
    int x0 = 0, y0 = 0, x1 = 1 << 16, y1 = 1 << 16;

    bool whole() const { return *this == ScreenRegion{}; }
    bool contains(int x, int y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
    bool meets(const ScreenRegion& o) const { return x0 < o.x1 && o.x0 < x1 && y0 < o.y1 && o.y0 < y1; }
    ScreenRegion grown(int by) const { return {x0 - by, y0 - by, x1 + by, y1 + by}; }
    friend bool operator==(const ScreenRegion&, const ScreenRegion&) = default;
};

// Keys skip.*, docs/hardware.md. None changes the image, but what lies outside `region`.
struct SkipConfig {
    bool untouched_tiles = true;  // tiles without a fragment are neither initialised nor resolved
    bool zero_alpha = true;       // zero alpha and colour: dropped before the operation, where harmless
    bool occluded = true;         // quads wholly behind the opaque layer are not shaded
    bool saturated = false;       // the technique's early termination, where it has one
    ScreenRegion region;          // fragments outside are dropped before anything is done for them
};

SkipConfig read_skips(Parameters& parameters);

// What a frame did not do. Fragments and quads count in every pass.
struct SkipCounts {
    std::uint64_t initialise_tiles = 0;  // never drawn to, and their bytes: written, and read to copy
    std::uint64_t initialise_bytes = 0;
    std::uint64_t resolve_tiles = 0;  // never drawn to; bytes: the image's written and the background's read
    std::uint64_t resolve_bytes = 0;
    std::uint64_t zero_alpha_fragments = 0;
    std::uint64_t occluded_fragments = 0;
    std::uint64_t occluded_lane_cycles = 0;  // of shader cores
    std::uint64_t outside_fragments = 0;
};

}  // namespace ropsim
