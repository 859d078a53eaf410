// Node arrays: a bit an element that says whether it is used, then used ones as they are or as columns.
#include "memory/codecs.h"
#include "memory/column_delta.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

namespace ropsim {
namespace {

enum class NodeMode : std::uint8_t { kUsed, kUsedDelta, kAllDelta };

constexpr unsigned kModes =
    mode_set(DeltaMode::kAnchor) | mode_set(DeltaMode::kChain) | mode_set(DeltaMode::kPrevious);

// The bytes of a block that an element of the shape has, and where they are in the element.
struct ElementBytes {
    std::uint32_t begin;
    std::uint32_t count;
    std::uint32_t from;
};

ElementBytes bytes_of(const BlockPlan& plan, const BlockShape& shape, std::uint32_t element) {
    const std::uint32_t skipped = (0u - shape.origin) / 8;  // of the first element, before the block
    const std::uint32_t size = plan.format.element_bytes;
    const std::uint32_t begin = element == 0 ? 0 : element * size - skipped;
    const std::uint32_t end = std::min((element + 1) * size - skipped, shape.bytes);
    return {begin, end - begin, element == 0 ? skipped : 0};
}

std::uint32_t element_count(const BlockShape& shape) {
    return shape.end_element - shape.first_element;
}

// Compares an element as a whole: `size` known to the compiler where it matters.
template <std::uint32_t kSize>
void mark_whole(const std::uint8_t* element, const std::uint8_t* clear, std::uint32_t count,
                std::uint32_t size, std::uint8_t* used) {
    for (std::uint32_t e = 0; e < count; ++e, element += size)
        used[e] = std::memcmp(element, clear, kSize == 0 ? size : kSize) != 0;
}

// Marks the elements that differ from the clear one; returns their bytes.
std::uint32_t mark_used(const BlockPlan& plan, const BlockShape& shape, const std::uint8_t* block,
                        ElementGroups& groups) {
    const std::uint32_t count = element_count(shape);
    if (count == 0) return 0;
    const std::uint8_t* clear = plan.format.clear_element.data();
    const std::uint32_t size = plan.format.element_bytes;
    const ElementBytes first = bytes_of(plan, shape, 0);
    const ElementBytes last = bytes_of(plan, shape, count - 1);
    groups.used[0] = std::memcmp(block, clear + first.from, first.count) != 0;
    groups.used[count - 1] = std::memcmp(block + last.begin, clear + last.from, last.count) != 0;
    if (count > 2) {
        const auto mark = size == 4    ? mark_whole<4>
                          : size == 8  ? mark_whole<8>
                          : size == 16 ? mark_whole<16>
                                       : mark_whole<0>;
        mark(block + first.count, clear, count - 2, size, groups.used.data() + 1);
    }
    std::uint32_t used = 0;
    for (std::uint32_t e = 0; e < count; ++e) used += groups.used[e];
    groups.all_used = used == count;
    // Of elements in parts only a part.
    used *= size;
    if (groups.used[0] != 0) used -= size - first.count;
    if (count > 1 && groups.used[count - 1] != 0) used -= size - last.count;
    return used;
}

// A straddling value is part of the first or of the last element.
BlockShape without_unused_ends(const BlockShape& shape, const ElementGroups& groups) {
    BlockShape kept = shape;
    if (element_count(shape) == 0) return kept;
    if (groups.used[0] == 0) kept.head_bits = 0;
    if (groups.used[element_count(shape) - 1] == 0) kept.tail_bits = 0;
    return kept;
}

void write_mask(const BlockShape& shape, ElementGroups& groups, BitWriter& out) {
    const std::uint32_t count = element_count(shape);
    std::memset(groups.used.data() + count, 0, 8);
    put_values(out, groups.used.data(), count, 1);
}

void read_mask(const BlockShape& shape, BitReader& in, ElementGroups& groups) {
    const std::uint32_t count = element_count(shape);
    get_values(in, groups.used.data(), count, 1);
    groups.all_used = std::count(groups.used.begin(), groups.used.begin() + count, 1) == count;
}

std::uint32_t mask_bytes(const BlockShape& shape) {
    return (kBlockModeBits + element_count(shape) + 7) / 8;
}

void write_used(const BlockPlan& plan, const BlockShape& shape, ElementGroups& groups,
                const std::uint8_t* block, std::uint8_t* out, std::uint32_t level) {
    BitWriter mask;
    mask.put(static_cast<std::uint64_t>(NodeMode::kUsed), kBlockModeBits);
    write_mask(shape, groups, mask);
    mask.copy(out, mask_bytes(shape));
    std::uint32_t at = mask_bytes(shape);
    for (std::uint32_t e = 0; e < element_count(shape); ++e) {
        if (groups.used[e] == 0) continue;
        const ElementBytes element = bytes_of(plan, shape, e);
        std::memcpy(out + at, block + element.begin, element.count);
        at += element.count;
    }
    std::memset(out + at, 0, level - at);
}

void read_used(const BlockPlan& plan, const BlockShape& shape, const ElementGroups& groups,
               const std::uint8_t* in, std::uint8_t* block) {
    std::uint32_t at = mask_bytes(shape);
    for (std::uint32_t e = 0; e < element_count(shape); ++e) {
        const ElementBytes element = bytes_of(plan, shape, e);
        if (groups.used[e] != 0) {
            std::memcpy(block + element.begin, in + at, element.count);
            at += element.count;
        } else {
            std::memcpy(block + element.begin, plan.format.clear_element.data() + element.from,
                        element.count);
        }
    }
    std::memset(block + shape.bytes, 0, plan.format.block_bytes - shape.bytes);
}

// Of used elements only, behind their mask, or of all.
std::uint32_t compress_delta(const BlockPlan& plan, const BlockShape& shape, ElementGroups& groups,
                             bool masked, std::uint32_t below, const std::uint8_t* block, std::uint8_t* out) {
    BlockValues values;
    if (!plan.gather(block, shape, values)) return below;
    if (masked) compact_columns(plan, shape, groups, values);
    const BlockShape kept = masked ? without_unused_ends(shape, groups) : shape;
    const std::uint32_t fixed =
        kBlockModeBits + (masked ? element_count(shape) : 0) + kept.head_bits + kept.tail_bits;
    ColumnCodes codes;
    choose_columns(plan, shape, groups, 0, kModes, plan.levels.back() * 8, values, codes);
    const std::uint32_t level = plan.level_of(fixed + codes.bits);
    if (level >= below) return below;
    BitWriter writer;
    writer.put(static_cast<std::uint64_t>(masked ? NodeMode::kUsedDelta : NodeMode::kAllDelta),
               kBlockModeBits);
    if (masked) write_mask(shape, groups, writer);
    write_straddling(kept, block, writer);
    write_columns(plan, shape, groups, 0, codes, values, writer);
    writer.copy(out, level);
    return level;
}

}  // namespace

std::uint32_t compress_nodes(const BlockPlan& plan, NodeCoding coding, const std::uint8_t* block,
                             std::uint32_t tile_offset, std::uint8_t* out) {
    const std::uint32_t block_bytes = plan.format.block_bytes;
    if (plan.levels.empty()) return block_bytes;
    const BlockShape shape = plan.shape(tile_offset);
    for (std::uint32_t b = shape.bytes; b < block_bytes; ++b)
        if (block[b] != 0) return block_bytes;
    ElementGroups groups;
    group_elements(plan, shape, groups, coding.used);
    std::uint32_t level = block_bytes;
    if (coding.used) {
        const std::uint32_t used_bytes = mark_used(plan, shape, block, groups);
        level = plan.level_of(8 * (mask_bytes(shape) + used_bytes));
        if (level != block_bytes && (!coding.delta || level == plan.levels.front())) {
            write_used(plan, shape, groups, block, out, level);
            return level;
        }
        if (!coding.delta) return block_bytes;
    }
    const bool masked = coding.used && !groups.all_used;
    const std::uint32_t delta = compress_delta(plan, shape, groups, masked, level, block, out);
    if (delta == level && level != block_bytes) write_used(plan, shape, groups, block, out, level);
    return delta;
}

void decompress_nodes(const BlockPlan& plan, const std::uint8_t* in, std::uint32_t bytes,
                      std::uint32_t tile_offset, std::uint8_t* block) {
    const BlockShape shape = plan.shape(tile_offset);
    BitReader reader(in, bytes);
    const auto mode = static_cast<NodeMode>(reader.get(kBlockModeBits));
    const bool masked = mode != NodeMode::kAllDelta;
    ElementGroups groups;
    group_elements(plan, shape, groups, masked);
    if (masked) read_mask(shape, reader, groups);
    if (mode == NodeMode::kUsed) return read_used(plan, shape, groups, in, block);
    BlockShape kept = shape;
    if (masked) {
        kept = without_unused_ends(shape, groups);
        for (std::uint32_t e = 0; e < element_count(shape); ++e) {
            const ElementBytes element = bytes_of(plan, shape, e);
            std::memcpy(block + element.begin, plan.format.clear_element.data() + element.from,
                        element.count);
        }
    }
    read_straddling(kept, reader, block);
    BlockValues values;
    read_columns(plan, shape, groups, 0, reader, values);
    if (masked) expand_columns(plan, shape, groups, values);
    plan.scatter(shape, values, block);
}

}  // namespace ropsim
