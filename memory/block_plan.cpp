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
    if (depth_first)
        while (++first_channels < channels.size() && channels[first_channels].follows) {
        }
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

std::uint32_t BlockPlan::level_of(std::uint32_t bits) const {
    for (const std::uint32_t level : levels)
        if (bits <= level * 8) return level;
    return format.block_bytes;
}

}  // namespace ropsim
