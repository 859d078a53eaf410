// What the bytes of a surface's tile mean, told by whoever places surfaces: what a codec of blocks knows.
#pragma once

#include <cstdint>
#include <vector>

namespace ropsim {

enum class FieldKind : std::uint8_t {
    kFloat32,  // any float whose top bit is the sign, 32 bits
    kFloat16,  // the same of 16 bits
    kUnorm,
    kSnorm,    // two's complement
    kInteger,  // unsigned
    kPacked,   // opaque bits
};

// Channels of one kind side by side. Unequal channels that order as integers do (R11G11B10's small floats)
// are better told as several kInteger fields than as one kPacked field.
struct BlockField {
    std::uint16_t bit;      // offset in the element, little endian
    std::uint8_t bits;      // of one channel, 1..64; of kPacked all, with one channel
    std::uint8_t channels;  // at least 1
    FieldKind kind;
};

enum class SurfaceClass : std::uint8_t { kDepth, kColor, kNodes };

// A tile is 8x8 pixels in quad order: 16 quads row-major, 2x2 pixels row-major in each. Interleaved: pixel
// after pixel, each with its elements side by side; planar: a plane of 64 pixels for each element. Bytes
// after the last element of a tile are padding.
struct BlockFormat {
    SurfaceClass surface_class = SurfaceClass::kColor;
    std::uint32_t block_bytes = 256;  // 64, 128 or 256
    std::uint32_t element_bytes = 4;  // 1..64
    std::uint32_t elements = 1;       // of a pixel; 0: a pool, elements without end that belong to no pixel
    bool planar = false;
    std::vector<BlockField> fields;           // of an element, by rising bit, not overlapping
    std::vector<std::uint8_t> clear_element;  // element_bytes, of the cleared element
};

}  // namespace ropsim
