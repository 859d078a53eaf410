// Why bytes move between a ROP partition and memory: every byte on the pins has one cause.
#pragma once

#include <cstdint>

namespace ropsim {

enum class MemoryCause : std::uint8_t {
    kFill,       // read on a cache miss
    kWriteBack,  // dirty bytes of a line evicted to make room
    kFlush,      // dirty bytes written at the end of a frame or between passes
    kClear,      // clear values written to memory (fast clear avoids these)
    kCopy,       // surface initialised from another one, e.g. the opaque layer
};
inline constexpr int kMemoryCauses = 5;
inline constexpr int kMaxSurfaces = 64;  // surfaces that a run may tell apart; ids are 0..kMaxSurfaces-1

// The name used in results: "fill", "write_back", "flush", "clear", "copy".
constexpr const char* to_string(MemoryCause cause) {
    constexpr const char* kNames[kMemoryCauses] = {"fill", "write_back", "flush", "clear", "copy"};
    return kNames[static_cast<int>(cause)];
}

}  // namespace ropsim
