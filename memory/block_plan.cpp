// Columns of a block: which channels an element has, where their values lie, and moving them in and out.
#include "memory/block_plan.h"

#include "base/error.h"

#include <algorithm>
#include <cstring>
#include <type_traits>
#include <utility>

namespace ropsim {
namespace {

constexpr std::uint32_t kTilePixels = 64;

Channel channel_at(std::uint32_t bit, std::uint32_t bits, OrderMap map, bool follows) {
    const std::uint8_t bytes = bits <= 8 ? 1 : bits <= 16 ? 2 : 4;
    return {static_cast<std::uint16_t>(bit), static_cast<std::uint8_t>(bits), bytes, map, follows};
}

// Bits [begin, end) as integers of at most 32.
void add_plain(std::vector<Channel>& channels, std::uint32_t begin, std::uint32_t end) {
    for (std::uint32_t bit = begin; bit < end; bit += 32)
        channels.push_back(channel_at(bit, std::min(end - bit, 32u), OrderMap::kPlain, false));
}

OrderMap map_of(FieldKind kind) {
    switch (kind) {
        case FieldKind::kFloat32:
        case FieldKind::kFloat16:
            return OrderMap::kFloat;
        case FieldKind::kSnorm:
            return OrderMap::kFlipTop;
        default:
            return OrderMap::kPlain;
    }
}

std::vector<Channel> channels_of(const BlockFormat& format) {
    std::vector<Channel> channels;
    std::uint32_t end = 0;
    for (const BlockField& field : format.fields) {
        CHECK(field.bit >= end && field.bits >= 1 && field.bits <= 64 && field.channels >= 1,
              "field at bit {} of {} bits, {} channels, after bit {}", field.bit, field.bits, field.channels,
              end);
        add_plain(channels, end, field.bit);
        end = field.bit;
        for (std::uint32_t c = 0; c < field.channels; ++c, end += field.bits) {
            if (field.bits > 32)
                add_plain(channels, end, end + field.bits);
            else
                channels.push_back(channel_at(end, field.bits, map_of(field.kind), c != 0));
        }
    }
    const std::uint32_t element_bits = format.element_bytes * 8;
    CHECK(end <= element_bits, "fields end at bit {} of {}", end, element_bits);
    add_plain(channels, end, element_bits);
    if (channels.size() <= kMaxChannels) return channels;
    channels.clear();
    for (std::uint32_t bit = 0; bit < element_bits; bit += 8)
        channels.push_back(channel_at(bit, 8, OrderMap::kPlain, bit != 0));
    return channels;
}

template <typename T>
T ordered(T value, OrderMap map, std::uint32_t bits) {
    const T top = static_cast<T>(T{1} << (bits - 1));
    if (map == OrderMap::kPlain) return value;
    if (map == OrderMap::kFlipTop) return static_cast<T>(value ^ top);
    const T all = static_cast<T>(low_bits(bits));
    return static_cast<T>(value ^ ((value & top) != 0 ? all : top));
}

template <typename T>
T unordered(T value, OrderMap map, std::uint32_t bits) {
    if (map != OrderMap::kFloat) return ordered(value, map, bits);
    const T top = static_cast<T>(T{1} << (bits - 1));
    const T all = static_cast<T>(low_bits(bits));
    return static_cast<T>(value ^ ((value & top) != 0 ? top : all));
}

template <typename T>
void order_column(T* values, std::uint32_t count, const Channel& channel) {
    if (channel.map == OrderMap::kPlain) return;
    for (std::uint32_t i = 0; i < count; ++i) values[i] = ordered(values[i], channel.map, channel.bits);
}

std::uint64_t read_bits(const std::uint8_t* bytes, std::uint32_t bit, std::uint32_t count) {
    std::uint64_t value = 0;
    const std::uint32_t used = ((bit & 7) + count + 7) / 8;
    std::memcpy(&value, bytes + bit / 8, used);
    return value >> (bit & 7) & low_bits(count);
}

void write_bits(std::uint8_t* bytes, std::uint32_t bit, std::uint32_t count, std::uint64_t value) {
    std::uint64_t word = 0;
    const std::uint32_t used = ((bit & 7) + count + 7) / 8;
    std::memcpy(&word, bytes + bit / 8, used);
    word = (word & ~(low_bits(count) << (bit & 7))) | value << (bit & 7);
    std::memcpy(bytes + bit / 8, &word, used);
}

}  // namespace

void write_straddling(const BlockShape& shape, const std::uint8_t* block, BitWriter& out) {
    out.put(read_bits(block, 0, shape.head_bits), shape.head_bits);
    out.put(read_bits(block, shape.bytes * 8 - shape.tail_bits, shape.tail_bits), shape.tail_bits);
}

void read_straddling(const BlockShape& shape, BitReader& in, std::uint8_t* block) {
    write_bits(block, 0, shape.head_bits, in.get(shape.head_bits));
    write_bits(block, shape.bytes * 8 - shape.tail_bits, shape.tail_bits, in.get(shape.tail_bits));
}

BlockPlan::BlockPlan(const BlockFormat& block_format, std::vector<std::uint32_t> level_bytes)
    : format(block_format), levels(std::move(level_bytes)) {
    CHECK(format.block_bytes == 64 || format.block_bytes == 128 || format.block_bytes == 256,
          "blocks of {} bytes", format.block_bytes);
    CHECK(format.element_bytes >= 1 && format.element_bytes <= 64, "elements of {} bytes",
          format.element_bytes);
    CHECK(format.clear_element.size() == format.element_bytes, "{} bytes clear an element of {}",
          format.clear_element.size(), format.element_bytes);
    std::uint32_t last = 0;
    for (const std::uint32_t level : levels) {
        CHECK(level > last && level < format.block_bytes && level % 8 == 0, "level {} of blocks of {} bytes",
              level, format.block_bytes);
        last = level;
    }
    channels = channels_of(format);
    depth_first = !format.fields.empty() && channels.front().bits == format.fields.front().bits &&
                  format.fields.front().bit == 0;
    payload_bytes = format.elements == 0 ? ~0u : kTilePixels * format.elements * format.element_bytes;
    for (const Channel& channel : channels) {
        const auto bits =
            static_cast<std::uint32_t>(read_bits(format.clear_element.data(), channel.bit, channel.bits));
        clear_values.push_back(ordered(bits, channel.map, channel.bits));
    }
    for (const Channel& channel : channels)
        if (channel.bit % 8 != 0 || channel.bits != channel.bytes * 8) byte_aligned = false;
}

BlockShape BlockPlan::shape(std::uint32_t tile_offset) const {
    BlockShape shape;
    const std::uint32_t begin = std::min(tile_offset, payload_bytes);
    const std::uint32_t end = begin + std::min(format.block_bytes, payload_bytes - begin);
    const std::uint32_t first = begin / format.element_bytes;
    const std::uint32_t last = end / format.element_bytes;
    const std::uint32_t begin_bit = begin % format.element_bytes * 8;
    const std::uint32_t end_bit = end % format.element_bytes * 8;
    shape.first_element = first;
    shape.end_element = last + (end_bit != 0 ? 1 : 0);
    shape.origin = 0u - begin_bit;
    shape.bytes = end - begin;
    shape.head_bits = 0;
    shape.tail_bits = 0;
    std::uint32_t offset = 0;
    for (std::size_t c = 0; c < channels.size(); ++c) {
        const std::uint32_t bit = channels[c].bit;
        const std::uint32_t after = bit + channels[c].bits;
        if (bit < begin_bit && begin_bit < after) shape.head_bits = after - begin_bit;
        if (bit < end_bit && end_bit < after) shape.tail_bits = end_bit - bit;
        const std::uint32_t from = first + (bit < begin_bit ? 1 : 0);
        const std::uint32_t to = last + (after <= end_bit ? 1 : 0);
        const std::uint32_t count = to > from ? to - from : 0;
        shape.columns[c] = {from, count, offset};
        offset += (count * channels[c].bytes + 23) & ~15u;
    }
    return shape;
}

bool BlockPlan::gather(const std::uint8_t* block, const BlockShape& shape, BlockValues& values) const {
    for (std::uint32_t b = shape.bytes; b < format.block_bytes; ++b)
        if (block[b] != 0) return false;
    // Reads of 8 bytes at unaligned values may pass the end.
    std::array<std::uint8_t, kMaxBlockBytes + 8> copy;
    if (!byte_aligned) {
        std::memcpy(copy.data(), block, format.block_bytes);
        std::memset(copy.data() + format.block_bytes, 0, 8);
        block = copy.data();
    }
    const std::uint32_t stride = format.element_bytes;
    for (std::size_t c = 0; c < channels.size(); ++c) {
        const Channel& channel = channels[c];
        const Column& column = shape.columns[c];
        std::uint32_t bit = shape.origin + (column.first - shape.first_element) * stride * 8 + channel.bit;
        with_integer(channel, [&](auto* type) {
            using T = std::remove_pointer_t<decltype(type)>;
            T* out = values.column<T>(column);
            if (channel.bit % 8 == 0 && channel.bits == sizeof(T) * 8) {
                const std::uint8_t* in = block + bit / 8;
                for (std::uint32_t i = 0; i < column.count; ++i, in += stride)
                    std::memcpy(out + i, in, sizeof(T));
            } else {
                for (std::uint32_t i = 0; i < column.count; ++i, bit += stride * 8) {
                    std::uint64_t word = 0;
                    std::memcpy(&word, block + bit / 8, 8);
                    out[i] = static_cast<T>(word >> (bit & 7) & low_bits(channel.bits));
                }
            }
            order_column(out, column.count, channel);
        });
    }
    return true;
}

void BlockPlan::scatter(const BlockShape& shape, const BlockValues& values, std::uint8_t* block) const {
    std::memset(block + shape.bytes, 0, format.block_bytes - shape.bytes);
    const std::uint32_t stride = format.element_bytes;
    for (std::size_t c = 0; c < channels.size(); ++c) {
        const Channel& channel = channels[c];
        const Column& column = shape.columns[c];
        std::uint32_t bit = shape.origin + (column.first - shape.first_element) * stride * 8 + channel.bit;
        with_integer(channel, [&](auto* type) {
            using T = std::remove_pointer_t<decltype(type)>;
            const T* in = values.column<T>(column);
            for (std::uint32_t i = 0; i < column.count; ++i, bit += stride * 8) {
                const T value = unordered(in[i], channel.map, channel.bits);
                if (channel.bit % 8 == 0 && channel.bits == sizeof(T) * 8)
                    std::memcpy(block + bit / 8, &value, sizeof(T));
                else
                    write_bits(block, bit, channel.bits, value);
            }
        });
    }
}

std::uint32_t BlockPlan::level_of(std::uint32_t bits) const {
    for (const std::uint32_t level : levels)
        if (bits <= level * 8) return level;
    return format.block_bytes;
}

}  // namespace ropsim
