// What an operation that gathers has read of other pixels.
#pragma once

#include "rop/declaration.h"

#include <array>
#include <cstdint>
#include <vector>

namespace ropsim {

// One surface of one pixel, or the opaque layer's colour or depth there.
struct GatherRead {
    static constexpr std::uint8_t kBackground = 0xFF;
    static constexpr std::uint8_t kOpaqueDepth = 0xFE;
    std::uint16_t x = 0;
    std::uint16_t y = 0;
    std::uint8_t surface = 0;
};

// What the operation on one pixel gathered.
struct GatherReads {
    bool record = false;                                        // keep `reads`, not only the sums
    std::array<std::uint32_t, kMaxTechniqueSurfaces> pixels{};  // by surface; all of a pixel's elements each
    std::uint32_t backgrounds = 0;
    std::uint32_t opaque_depths = 0;
    std::vector<GatherRead> reads;

    void clear() {
        pixels = {};
        backgrounds = 0;
        opaque_depths = 0;
        reads.clear();
    }
};

}  // namespace ropsim
