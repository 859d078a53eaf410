// Lossless compression of a surface's blocks: which codec runs, and its latency.
#include "memory/block_codec.h"

#include "memory/codecs.h"
#include "memory/column_groups.h"

#include <bit>
#include <cstring>
#include <utility>

namespace ropsim {
namespace {

// ATTILA's CompressionUnitLatency and DecompressionUnitLatency [bGPU.ini].
constexpr std::uint32_t kUnitLatency = 8;

// Of a unit with so many adders in a row beyond a subtraction from a base, two a clock (an estimate).
std::uint32_t latency(std::uint32_t adders) {
    return kUnitLatency + (adders + 1) / 2;
}

// Two products of a slope and three bits, and their sum with the plane's depth.
constexpr std::uint32_t kPlaneAdders = 2 + 2;

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
    // How many bits each way of coding a column takes, the shortest, and the sum over the columns.
    const std::uint32_t columns = 2 + tree_levels(static_cast<std::uint32_t>(plan_.channels.size()));
    const std::uint32_t mask = tree_levels(format().block_bytes / format().element_bytes);
    switch (kind_) {
        case CodecKind::kNone:
            return 0;
        case CodecKind::kDepthDelta:
            return kUnitLatency;
        case CodecKind::kDepthPlanes:
        case CodecKind::kDepthBest:
            // A slope (a difference, a product with a constant), a depth on the plane, its correction, the
            // choice of plane.
            return latency(1 + 2 + kPlaneAdders + 1 + 1);
        case CodecKind::kColorDelta:
        case CodecKind::kNodeDelta:
            return latency(columns);
        case CodecKind::kNodesUsed:
            return latency(mask);
        case CodecKind::kNodesUsedDelta:
            return latency(mask + columns);
    }
    return 0;
}

std::uint32_t BlockCodec::decompress_latency() const {
    const std::uint32_t channels = tree_levels(static_cast<std::uint32_t>(plan_.channels.size()));
    // Where each column begins, then channels that follow the one before.
    const std::uint32_t columns = 2 * channels;
    const std::uint32_t mask = tree_levels(format().block_bytes / format().element_bytes);
    const std::uint32_t chain = tree_levels(group_size(format()));
    switch (kind_) {
        case CodecKind::kNone:
            return 0;
        case CodecKind::kDepthDelta:
            return kUnitLatency;
        case CodecKind::kDepthPlanes:
        case CodecKind::kDepthBest:
            return latency(kPlaneAdders);
        case CodecKind::kColorDelta:
            return latency(columns + 1);  // a delta from an anchor
        case CodecKind::kNodeDelta:
            return latency(columns + chain);
        case CodecKind::kNodesUsed:
            return latency(mask);
        case CodecKind::kNodesUsedDelta:
            return latency(mask + columns + chain);
    }
    return 0;
}

}  // namespace ropsim
