// Colour by deltas: a base a channel, or an anchor a quad or pixel, or the channel before.
#include "memory/codecs.h"
#include "memory/column_delta.h"

namespace ropsim {
namespace {

constexpr unsigned kModes = mode_set(DeltaMode::kAnchor) | mode_set(DeltaMode::kPrevious);

}  // namespace

std::uint32_t compress_color(const BlockPlan& plan, const std::uint8_t* block, std::uint32_t tile_offset,
                             std::uint8_t* out) {
    const std::uint32_t block_bytes = plan.format.block_bytes;
    if (plan.levels.empty()) return block_bytes;
    const BlockShape shape = plan.shape(tile_offset);
    BlockValues values;
    if (!plan.gather(block, shape, values)) return block_bytes;
    ElementGroups groups;
    group_elements(plan, shape, groups);
    const std::uint32_t fixed = kBlockModeBits + shape.head_bits + shape.tail_bits;
    const std::uint32_t limit = plan.levels.back() * 8;
    ColumnCodes codes;
    choose_columns(plan, shape, groups, 0, kModes, limit, values, codes);
    const std::uint32_t level = plan.level_of(fixed + codes.bits);
    if (level == block_bytes) return level;
    BitWriter writer;
    writer.put(0, kBlockModeBits);
    write_straddling(shape, block, writer);
    write_columns(plan, shape, groups, 0, codes, values, writer);
    writer.copy(out, level);
    return level;
}

void decompress_color(const BlockPlan& plan, const std::uint8_t* in, std::uint32_t bytes,
                      std::uint32_t tile_offset, std::uint8_t* block) {
    const BlockShape shape = plan.shape(tile_offset);
    ElementGroups groups;
    group_elements(plan, shape, groups);
    BitReader reader(in, bytes);
    reader.get(kBlockModeBits);
    read_straddling(shape, reader, block);
    BlockValues values;
    read_columns(plan, shape, groups, 0, reader, values);
    plan.scatter(shape, values, block);
}

}  // namespace ropsim
