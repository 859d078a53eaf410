// Columns of a block as a base and deltas of a width chosen a column: what the colour and node codecs share.
#pragma once

#include "memory/block_bits.h"
#include "memory/block_plan.h"

#include <array>
#include <cstdint>

namespace ropsim {

// What a value is a delta of. Two bits in the block.
enum class DeltaMode : std::uint8_t {
    kBase,      // the column's least value
    kAnchor,    // its group's first value
    kChain,     // the value before it in its group
    kPrevious,  // the same element's value in the column before
};
constexpr unsigned mode_set(DeltaMode mode) {
    return 1u << static_cast<unsigned>(mode);
}

// Which elements a column has, and which of them belong together: a quad's, or a pixel's.
struct ElementGroups {
    // By element from the shape's first: whether it takes part, and its group, rising.
    std::array<std::uint8_t, kMaxBlockBytes + 2> used;
    std::array<std::uint8_t, kMaxBlockBytes + 2> group;
    bool all_used = true;
    // Whole groups of four that begin with every column: loops need not ask.
    bool aligned = false;
};

// Groups of the elements that a delta may refer to: quads where neighbours in memory are pixels, else the
// elements of a pixel. All elements take part. Unless `masked` (some will not), `aligned` is set where it
// holds and the arrays are not.
void group_elements(const BlockPlan& plan, const BlockShape& shape, ElementGroups& groups,
                    bool masked = false);
// kAnchor and kChain of `modes` only where group_elements() has groups: not in pools.
unsigned possible_modes(const BlockPlan& plan, unsigned modes);

// How a column is coded.
struct ColumnCode {
    DeltaMode mode = DeltaMode::kBase;
    std::uint8_t width = 0;        // of the deltas of kBase and kPrevious, of anchors else
    std::uint8_t delta_width = 0;  // of kAnchor and kChain
    std::uint32_t base = 0;
    std::uint32_t delta_base = 0;
    std::uint32_t count = 0;    // values
    std::uint32_t anchors = 0;  // of them
};

struct ColumnCodes {
    std::array<ColumnCode, kMaxChannels> code;
    std::uint32_t bits = 0;  // of all columns, with their headers
};

// Drops the values of columns from `first` whose element takes no part.
void compact_columns(const BlockPlan& plan, const BlockShape& shape, const ElementGroups& groups,
                     BlockValues& values);
// The inverse; values of elements that take no part become the clear element's.
void expand_columns(const BlockPlan& plan, const BlockShape& shape, const ElementGroups& groups,
                    BlockValues& values);

// Chooses the shortest of `modes` (mode_set()s; kBase always) for each column from `first` on. Gives up, with
// a number of bits above `limit`, as soon as they are too many.
void choose_columns(const BlockPlan& plan, const BlockShape& shape, const ElementGroups& groups,
                    std::uint32_t first, unsigned modes, std::uint32_t limit, const BlockValues& values,
                    ColumnCodes& codes);
void write_columns(const BlockPlan& plan, const BlockShape& shape, const ElementGroups& groups,
                   std::uint32_t first, const ColumnCodes& codes, const BlockValues& values, BitWriter& out);
void read_columns(const BlockPlan& plan, const BlockShape& shape, const ElementGroups& groups,
                  std::uint32_t first, BitReader& in, BlockValues& values);

}  // namespace ropsim
