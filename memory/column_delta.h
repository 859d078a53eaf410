// Columns of a block as a base and deltas of a width chosen a column: what the colour and node codecs share.
#pragma once

#include "memory/block_bits.h"
#include "memory/block_plan.h"
#include "memory/column_groups.h"

#include <array>
#include <cstdint>

namespace ropsim {

// What a value is a delta of. Two bits in the block.
enum class DeltaMode : std::uint8_t {
    kBase,      // the column's least value
    kAnchor,    // its group's first value (ElementGroups)
    kChain,     // the value before it in its group
    kPrevious,  // the same element's value in the column before
};
constexpr unsigned mode_set(DeltaMode mode) {
    return 1u << static_cast<unsigned>(mode);
}

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

// Chooses the shortest of `modes` (mode_set()s; kBase always) for each column from `first` on. With kChain in
// them, the first field's columns are chained and only the others have anchors. Gives up, with a number of
// bits above `limit`, as soon as they are too many.
void choose_columns(const BlockPlan& plan, const BlockShape& shape, const ElementGroups& groups,
                    std::uint32_t first, unsigned modes, std::uint32_t limit, const BlockValues& values,
                    ColumnCodes& codes);
void write_columns(const BlockPlan& plan, const BlockShape& shape, const ElementGroups& groups,
                   std::uint32_t first, const ColumnCodes& codes, const BlockValues& values, BitWriter& out);
void read_columns(const BlockPlan& plan, const BlockShape& shape, const ElementGroups& groups,
                  std::uint32_t first, BitReader& in, BlockValues& values);

}  // namespace ropsim
