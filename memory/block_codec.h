// Lossless compression of a surface's blocks, executed on their bytes (docs/compression.md).
#pragma once

#include "memory/block_format.h"
#include "memory/block_plan.h"

#include <cstdint>
#include <vector>

namespace ropsim {

enum class CodecKind : std::uint8_t {
    kNone,           // nothing is compressed
    kDepthPlanes,    // one or two planes and a small correction a pixel
    kDepthDelta,     // two references and low bits a pixel, as ATTILA's HILO
    kDepthBest,      // the smaller of the two
    kColorDelta,     // a base a channel, or a quad, and deltas of a width a channel
    kNodeDelta,      // the same with deltas along the elements of a pixel
    kNodesUsed,      // a bit an element, then those that differ from the clear element
    kNodesUsedDelta  // the smaller of used nodes as they are, and deltas of used nodes
};

// One object a surface. Const methods may be called by any number of threads and allocate nothing.
class BlockCodec {
 public:
    // `levels`: bytes that a compressed block may take, ascending, multiples of 8 below block_bytes.
    BlockCodec(CodecKind kind, const BlockFormat& format, std::vector<std::uint32_t> levels);

    // `tile_offset`: where the block begins in its tile's bytes. Returns the level's bytes, with as many
    // written to `out`, or block_bytes if the block fits none; `out` is untouched then.
    std::uint32_t compress(const std::uint8_t* block, std::uint32_t tile_offset, std::uint8_t* out) const;
    // Of what compress() returned `bytes` for at the same offset; bytes == block_bytes copies.
    void decompress(const std::uint8_t* compressed, std::uint32_t bytes, std::uint32_t tile_offset,
                    std::uint8_t* block) const;

    CodecKind kind() const { return kind_; }
    const BlockFormat& format() const { return plan_.format; }
    const std::vector<std::uint32_t>& levels() const { return plan_.levels; }
    // Clocks of the ROP from a block's last byte in to its first out: ATTILA's 8 [bGPU.ini] and, estimated,
    // one for every two adders in a row that a codec needs beyond a subtraction from a base.
    std::uint32_t compress_latency() const;
    std::uint32_t decompress_latency() const;

 private:
    CodecKind kind_;
    BlockPlan plan_;
};

}  // namespace ropsim
