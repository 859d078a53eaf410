// Lossless compression of a surface's blocks: which codec runs, and its latency.
#include "memory/block_codec.h"

#include "memory/codecs.h"

#include <bit>
#include <cstring>
#include <utility>

namespace ropsim {
namespace {

// ATTILA's CompressionUnitLatency and DecompressionUnitLatency [bGPU.ini].
constexpr std::uint32_t kUnitLatency = 8;

// Levels of an adder tree, or of a parallel prefix sum, over `values`.
std::uint32_t tree_levels(std::uint32_t values) {
    return static_cast<std::uint32_t>(values <= 1 ? 0 : std::bit_width(values - 1));
}

}  // namespace

BlockCodec::BlockCodec(CodecKind kind, const BlockFormat& format, std::vector<std::uint32_t> levels)
    : kind_(kind), plan_(format, std::move(levels)) {}

std::uint32_t BlockCodec::compress(const std::uint8_t* block, std::uint32_t tile_offset,
                                   std::uint8_t* out) const {
    switch (kind_) {
        case CodecKind::kDepthPlanes:
            return compress_depth(plan_, {true, false}, block, tile_offset, out);
        case CodecKind::kDepthDelta:
            return compress_depth(plan_, {false, true}, block, tile_offset, out);
        case CodecKind::kDepthBest:
            return compress_depth(plan_, {true, true}, block, tile_offset, out);
        case CodecKind::kColorDelta:
            return compress_color(plan_, block, tile_offset, out);
        case CodecKind::kNodeDelta:
            return compress_nodes(plan_, {false, true}, block, tile_offset, out);
        case CodecKind::kNodesUsed:
            return compress_nodes(plan_, {true, false}, block, tile_offset, out);
        case CodecKind::kNodesUsedDelta:
            return compress_nodes(plan_, {true, true}, block, tile_offset, out);
        case CodecKind::kNone:
            break;
    }
    return format().block_bytes;
}

void BlockCodec::decompress(const std::uint8_t* compressed, std::uint32_t bytes, std::uint32_t tile_offset,
                            std::uint8_t* block) const {
    if (bytes == format().block_bytes) {
        std::memcpy(block, compressed, bytes);
        return;
    }
    switch (kind_) {
        case CodecKind::kDepthPlanes:
        case CodecKind::kDepthDelta:
        case CodecKind::kDepthBest:
            return decompress_depth(plan_, compressed, bytes, tile_offset, block);
        case CodecKind::kColorDelta:
            return decompress_color(plan_, compressed, bytes, tile_offset, block);
        case CodecKind::kNodeDelta:
        case CodecKind::kNodesUsed:
        case CodecKind::kNodesUsedDelta:
            return decompress_nodes(plan_, compressed, bytes, tile_offset, block);
        case CodecKind::kNone:
            break;
    }
}

std::uint32_t BlockCodec::compress_latency() const {
    const std::uint32_t elements = format().block_bytes / format().element_bytes;
    switch (kind_) {
        case CodecKind::kNone:
            return 0;
        case CodecKind::kDepthPlanes:
        case CodecKind::kDepthBest:
            // Slopes (a subtraction, a product with a constant), then each pixel's plane (two products of
            // three bits, two additions) before its correction: eight adders.
            return kUnitLatency + 4;
        case CodecKind::kNodesUsed:
        case CodecKind::kNodesUsedDelta:
            // Where a used element goes: a prefix sum over the mask.
            return kUnitLatency + (tree_levels(elements) + 1) / 2;
        default:
            return kUnitLatency;
    }
}

std::uint32_t BlockCodec::decompress_latency() const {
    const std::uint32_t elements = format().block_bytes / format().element_bytes;
    const std::uint32_t mask = (tree_levels(elements) + 1) / 2;
    // Deltas along a pixel's elements: a prefix sum over them.
    const std::uint32_t chain = (tree_levels(format().elements) + 1) / 2;
    switch (kind_) {
        case CodecKind::kNone:
            return 0;
        case CodecKind::kDepthPlanes:
        case CodecKind::kDepthBest:
            return kUnitLatency + 2;  // two products of three bits, two additions: four adders
        case CodecKind::kNodesUsed:
            return kUnitLatency + mask;
        case CodecKind::kNodeDelta:
            return kUnitLatency + chain;
        case CodecKind::kNodesUsedDelta:
            return kUnitLatency + mask + chain;
        default:
            return kUnitLatency;
    }
}

}  // namespace ropsim
