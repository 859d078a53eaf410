// Gives a trace's fragments another arrival order.
#pragma once

#include <cstdint>
#include <string>

namespace ropsim {

// Over the whole trace; what an order calls equal stays in the order it arrived in.
enum class ArrivalOrder {
    kNearToFar,
    kFarToNear,
    kShuffle,    // at random, except that fragments of one pixel and depth keep their order: it decides which
                 // is nearer, so the exact picture stays
    kPrimitive,  // by draw, then by primitive
    kTile,       // by 8x8 tile, row by row, as a renderer that bins would send them
};

// Writes the same fragments, with their slopes, materials and values as stored, in another order; all else
// stays. Depths that are NaN or out of range sort as the reader brings them into range (NaN as 1). Memory:
// the whole trace, 48 bytes a fragment, and 8 with slopes, 32 with materials. UserError beyond 2^32 - 1
// fragments.
void order_trace(const std::string& trace_path, const std::string& out_path, ArrivalOrder order,
                 std::uint64_t seed);

}  // namespace ropsim
