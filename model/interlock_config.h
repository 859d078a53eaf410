// Engine `shader`: what it costs a pixel shader to run the operation itself, in a critical section.
#pragma once

#include "base/parameters.h"
#include "rop/datapath.h"

#include <array>
#include <cstdint>

namespace ropsim {

enum class InterlockMode : std::uint8_t {
    kOrdered,  // hardware grants a pixel in raster order
    kSpin,     // a lock word a pixel in memory; whoever tries first when it is free has it
};

// Keys interlock.*; without effect where the operation runs in the ROP.
struct InterlockConfig {
    bool executes = false;  // the run's engine is `shader`; not a key
    InterlockMode mode = InterlockMode::kOrdered;
    bool per_pixel = true;                  // interlock.granularity: else all pixels of a quad together
    std::uint32_t begin_cycles = 0;         // ROP cycles from the grant to the first load (ordered)
    std::uint32_t end_cycles = 0;           // ROP cycles from the last store's word to the release (ordered)
    std::uint32_t retry_cycles = 0;         // ROP cycles from word that the lock is taken to the next try
    std::uint32_t memory_latency = 0;       // ROP cycles of a load, store or atomic besides the L2's own
    std::uint32_t instruction_latency = 0;  // shader cycles from an instruction to one that needs its result
    std::uint32_t overhead_instructions = 0;  // a lane and quad: addresses, loads, stores, begin and end
    std::array<std::uint32_t, kUnitCount> instructions{};  // a lane issues for one use of the unit
};

InterlockConfig read_interlock(Parameters& parameters);

}  // namespace ropsim
