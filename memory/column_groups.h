// Which elements of a block take part in its columns, and which of them belong together.
#pragma once

#include "memory/block_plan.h"

#include <array>
#include <cstdint>

namespace ropsim {

// Groups are quads where neighbours in memory are pixels, else the elements of a pixel.
struct ElementGroups {
    // By element from the shape's first: whether it takes part, and its group, rising.
    std::array<std::uint8_t, kMaxBlockBytes + 16> used;  // writable to 8 past the last
    std::array<std::uint8_t, kMaxBlockBytes + 2> group;
    bool all_used = true;
    // Whole groups of four that begin with every column; the arrays are not set then.
    bool aligned = false;
};

// Elements of a group; 0: there are none.
inline std::uint32_t group_size(const BlockFormat& format) {
    return format.planar || format.elements == 1 ? 4 : format.elements;
}

// All elements take part, unless `masked`: then `used` is to be set, and nothing is aligned.
void group_elements(const BlockPlan& plan, const BlockShape& shape, ElementGroups& groups,
                    bool masked = false);
// Values of a column whose elements take part.
std::uint32_t count_used(const BlockShape& shape, const Column& column, const ElementGroups& groups);
// Drops the values whose element takes no part.
void compact_columns(const BlockPlan& plan, const BlockShape& shape, const ElementGroups& groups,
                     BlockValues& values);
// The inverse; values of elements that take no part become the clear element's.
void expand_columns(const BlockPlan& plan, const BlockShape& shape, const ElementGroups& groups,
                    BlockValues& values);

// The first value of each group of a compacted column, the others, and the first of each one's group.
struct GroupIndex {
    std::array<std::uint8_t, kMaxBlockBytes> anchor;
    std::array<std::uint8_t, kMaxBlockBytes> other;
    std::array<std::uint8_t, kMaxBlockBytes> anchor_of_other;
    std::uint32_t anchors = 0;
    std::uint32_t others = 0;
};

// Of a block's columns in turn: those of the same elements share theirs.
class GroupIndexes {
 public:
    GroupIndexes(const BlockShape& shape, const ElementGroups& groups) : shape_(shape), groups_(groups) {}
    const GroupIndex& of(const Column& column);

 private:
    const BlockShape& shape_;
    const ElementGroups& groups_;
    std::uint32_t first_ = ~0u;
    std::uint32_t count_ = 0;
    GroupIndex index_;
};

}  // namespace ropsim
