// A block's values as columns, a column a channel of the element: how codecs see the bytes of a surface.
#pragma once

#include "memory/block_bits.h"
#include "memory/block_format.h"

#include <array>
#include <cstdint>
#include <vector>

namespace ropsim {

inline constexpr std::uint32_t kMaxChannels = 64;

// How a channel's bits become an unsigned integer that orders as its values do. All are bijections.
enum class OrderMap : std::uint8_t {
    kPlain,
    kFlipTop,  // two's complement
    kFloat,    // sign and magnitude
};

struct Channel {
    std::uint16_t bit;   // offset in the element
    std::uint8_t bits;   // 1..32
    std::uint8_t bytes;  // 1, 2 or 4: of the integer that holds it
    OrderMap map;
    bool follows;  // same field as the channel before
};

// The values of a channel that lie in the block as a whole.
struct Column {
    std::uint32_t first;  // element of the first, counted from the tile's first
    std::uint32_t count;
    std::uint32_t offset;  // bytes from BlockColumn::values
};

// Where a block's values lie. Of a value that straddles a border the part in the block is kept as raw bits:
// one value at most at either end, because channels cover all bits of an element.
struct BlockShape {
    std::array<Column, kMaxChannels> columns;
    std::uint32_t first_element;  // of the tile; the first that has a bit in the block
    std::uint32_t end_element;
    std::uint32_t origin;  // bit of the block at which first_element begins, modulo 2^32
    std::uint32_t head_bits;
    std::uint32_t tail_bits;
    std::uint32_t bytes;  // of the block before the tile's padding
};

// One byte, two or four a value, columns after another; each is readable and writable to 8 bytes past its
// end.
struct BlockValues {
    static constexpr std::uint32_t kBytes = kMaxBlockBytes * 8 + kMaxChannels * 24;
    alignas(16) std::array<std::uint8_t, kBytes> bytes;

    template <typename T>
    T* column(const Column& column) {
        return reinterpret_cast<T*>(bytes.data() + column.offset);
    }
    template <typename T>
    const T* column(const Column& column) const {
        return reinterpret_cast<const T*>(bytes.data() + column.offset);
    }
};

struct BlockPlan {
    BlockPlan(const BlockFormat& block_format, std::vector<std::uint32_t> level_bytes);

    BlockFormat format;
    std::vector<std::uint32_t> levels;
    // Fields' channels and the bits between them, covering the element. More than kMaxChannels: its bytes.
    std::vector<Channel> channels;
    std::vector<std::uint32_t> clear_values;  // by channel, ordered
    std::uint32_t first_channels = 0;         // of the first field, where that is at bit 0
    bool depth_first = false;                 // the first channel is the first field's
    std::uint32_t payload_bytes = 0;          // of a tile before its padding
    bool byte_aligned = true;                 // every channel is 1, 2 or 4 whole bytes

    BlockShape shape(std::uint32_t tile_offset) const;
    // Fills the columns; false if the padding is not 0.
    bool gather(const std::uint8_t* block, const BlockShape& shape, BlockValues& values) const;
    // Writes whole values and 0 in the padding; leaves straddling bits alone.
    void scatter(const BlockShape& shape, const BlockValues& values, std::uint8_t* block) const;
    // The smallest level that holds `bits`, or block_bytes.
    std::uint32_t level_of(std::uint32_t bits) const;
};

// A channel's bits as an unsigned integer that orders as its values do, and back.
template <typename T>
T ordered(T value, OrderMap map, std::uint32_t bits) {
    if (map == OrderMap::kPlain) return value;
    const T top = static_cast<T>(T{1} << (bits - 1));
    const T all = static_cast<T>(low_bits(bits));
    const bool negative = map == OrderMap::kFloat && (value & top) != 0;
    return static_cast<T>(value ^ (negative ? all : top));
}
template <typename T>
T unordered(T value, OrderMap map, std::uint32_t bits) {
    if (map != OrderMap::kFloat) return ordered(value, map, bits);
    const T top = static_cast<T>(T{1} << (bits - 1));
    const T all = static_cast<T>(low_bits(bits));
    return static_cast<T>(value ^ ((value & top) != 0 ? top : all));
}

// The straddling values' bits, the block's first and last before the padding.
void write_straddling(const BlockShape& shape, const std::uint8_t* block, BitWriter& out);
void read_straddling(const BlockShape& shape, BitReader& in, std::uint8_t* block);

// Calls visit with a null pointer of the integer that holds the channel.
template <class Visit>
decltype(auto) with_integer(const Channel& channel, Visit&& visit) {
    switch (channel.bytes) {
        case 1:
            return visit(static_cast<std::uint8_t*>(nullptr));
        case 2:
            return visit(static_cast<std::uint16_t*>(nullptr));
        default:
            return visit(static_cast<std::uint32_t*>(nullptr));
    }
}

}  // namespace ropsim
