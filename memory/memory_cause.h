// Why bytes move between a ROP partition and memory: every byte on the pins has one cause.
#pragma once

#include <cstdint>

namespace ropsim {

enum class MemoryCause : std::uint8_t {
    kFill,       // read on a cache miss of a draw's operations
    kWriteBack,  // dirty bytes of a line evicted to make room
    kFlush,      // dirty bytes written at the end of a frame or between passes
    kClear,      // clear values written to memory (fast clear avoids these)
    kCopy,       // read to initialise a surface from another one, e.g. from the opaque layer
    kResolve,    // read on a cache miss of resolve or an image pass
    kMetadata,   // states of compressed and cleared blocks, both ways
    kRepack,     // the rest of a compressed block, read because some of it is written back
    kShadow,     // shadow map look-ups of the shader cores
    kTexture,    // texture fetches of the shader cores
};
inline constexpr int kMemoryCauses = 10;
inline constexpr int kMaxSurfaces = 64;  // surfaces that a run may tell apart; ids are 0..kMaxSurfaces-1

// The name used in results: "fill", "write_back", ...
constexpr const char* to_string(MemoryCause cause) {
    constexpr const char* kNames[kMemoryCauses] = {"fill",    "write_back", "flush",  "clear",  "copy",
                                                   "resolve", "metadata",   "repack", "shadow", "texture"};
    return kNames[static_cast<int>(cause)];
}

}  // namespace ropsim
