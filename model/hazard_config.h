// What a ROP partition does about operations on the same pixels, and about results for the same line.
#pragma once

#include "base/parameters.h"

#include <cstdint>

namespace ropsim {

// Every member is a key of a hardware preset or file (docs/hardware.md).
struct HazardConfig {
    // Which earlier operations one must wait for: those on the same pixels, quad or tile.
    enum class Interlock : std::uint8_t { kPixel, kQuad, kTile };
    Interlock interlock = Interlock::kQuad;  // rop.interlock
    bool forward_results = false;            // rop.forwarding: operands from a result that is not yet written
    std::uint32_t write_coalescing = 0;      // lines of the write queue that a later result can join; 0: none
};

// Throws UserError.
HazardConfig read_hazards(Parameters& parameters);

}  // namespace ropsim
