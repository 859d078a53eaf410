// The codecs behind BlockCodec: each compresses a block to the smallest level that it fits, and back.
#pragma once

#include "memory/block_bits.h"
#include "memory/block_plan.h"

#include <cstdint>

namespace ropsim {

// Every compressed block begins with these bits; what they mean is the codec's.
inline constexpr std::uint32_t kBlockModeBits = 2;

std::uint32_t compress_color(const BlockPlan& plan, const std::uint8_t* block, std::uint32_t tile_offset,
                             std::uint8_t* out);
void decompress_color(const BlockPlan& plan, const std::uint8_t* in, std::uint32_t bytes,
                      std::uint32_t tile_offset, std::uint8_t* block);

// `used`: as they are, those that differ from the clear element; `delta`: as columns; both: the smaller.
struct NodeCoding {
    bool used;
    bool delta;
};
std::uint32_t compress_nodes(const BlockPlan& plan, NodeCoding coding, const std::uint8_t* block,
                             std::uint32_t tile_offset, std::uint8_t* out);
void decompress_nodes(const BlockPlan& plan, const std::uint8_t* in, std::uint32_t bytes,
                      std::uint32_t tile_offset, std::uint8_t* block);

struct DepthCoding {
    bool planes;
    bool references;
};
std::uint32_t compress_depth(const BlockPlan& plan, DepthCoding coding, const std::uint8_t* block,
                             std::uint32_t tile_offset, std::uint8_t* out);
void decompress_depth(const BlockPlan& plan, const std::uint8_t* in, std::uint32_t bytes,
                      std::uint32_t tile_offset, std::uint8_t* block);

}  // namespace ropsim
