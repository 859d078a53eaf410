// The fragment record: one shaded contribution to one pixel, as it arrives at the ROP.
#pragma once

#include <cstdint>

namespace ropsim {

// 32 bytes, so two share a cache line. Colour is linear and premultiplied by alpha.
struct alignas(32) Fragment {
    float z;                  // window depth in [0, 1]; smaller is nearer
    float r, g, b;            // premultiplied linear colour
    float a;                  // alpha in [0, 1]
    std::uint16_t x, y;       // pixel, origin top left
    std::uint32_t primitive;  // primitive_number() and, in bit 31, faces_back()
    std::uint16_t coverage;   // bit m: spatial sample m of the trace's M is covered
    std::uint16_t draw;       // index into the trace's draws
};
static_assert(sizeof(Fragment) == 32);

inline constexpr std::uint32_t kBackFacing = 1u << 31;  // in Fragment::primitive

// The triangle within its draw, instances counted through: instance * primitives + primitive; below 2^31.
inline std::uint32_t primitive_number(const Fragment& f) {
    return f.primitive & ~kBackFacing;
}
// Whether the triangle turns its back to the eye (OpenGL's facing: corners clockwise on the screen).
inline bool faces_back(const Fragment& f) {
    return (f.primitive & kBackFacing) != 0;
}

inline constexpr int kTileSize = 8;  // pixels on a side; a tile is 16 quads
inline constexpr int kTilePixels = kTileSize * kTileSize;

}  // namespace ropsim
