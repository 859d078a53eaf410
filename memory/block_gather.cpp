// Moving a block's values into columns and back.
#include "memory/block_plan.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <type_traits>

namespace ropsim {
namespace {

// Whole bytes of the integer that holds the channel.
template <typename T>
bool is_plain(const Channel& channel) {
    return channel.bit % 8 == 0 && channel.bits == sizeof(T) * 8;
}

// The block is whole elements, and an element a word: loops over words become vectors.
bool is_words(const BlockPlan& plan, const BlockShape& shape) {
    const std::uint32_t size = plan.format.element_bytes;
    return std::has_single_bit(size) && size <= 8 && shape.origin == 0 && shape.bytes % size == 0;
}

template <class Visit>
void with_word(std::uint32_t bytes, Visit&& visit) {
    switch (bytes) {
        case 1:
            return visit(static_cast<std::uint8_t*>(nullptr));
        case 2:
            return visit(static_cast<std::uint16_t*>(nullptr));
        case 4:
            return visit(static_cast<std::uint32_t*>(nullptr));
        default:
            return visit(static_cast<std::uint64_t*>(nullptr));
    }
}

template <typename T, typename Word>
void gather_words(const Channel& channel, const std::uint8_t* block, std::uint32_t count, T* out) {
    // Copies, because bytes written may be anyone's.
    const T mask = static_cast<T>(low_bits(channel.bits));
    const std::uint32_t bit = channel.bit;
    for (std::uint32_t i = 0; i < count; ++i) {
        Word word = 0;
        std::memcpy(&word, block + i * sizeof(Word), sizeof(Word));
        out[i] = static_cast<T>(static_cast<T>(word >> bit) & mask);
    }
}

template <typename T>
void gather_bits(const Channel& channel, const std::uint8_t* block, std::uint32_t bit, std::uint32_t stride,
                 std::uint32_t count, T* out) {
    if (is_plain<T>(channel)) {
        block += bit / 8;
        for (std::uint32_t i = 0; i < count; ++i, block += stride) std::memcpy(out + i, block, sizeof(T));
        return;
    }
    for (std::uint32_t i = 0; i < count; ++i, bit += stride * 8) {
        std::uint64_t word = 0;
        std::memcpy(&word, block + bit / 8, 8);
        out[i] = static_cast<T>(word >> (bit & 7) & low_bits(channel.bits));
    }
}

template <typename T>
void order_column(T* values, std::uint32_t count, const Channel& channel) {
    const OrderMap map = channel.map;
    const std::uint32_t bits = channel.bits;
    if (map == OrderMap::kPlain) return;
    if (map == OrderMap::kFloat)
        for (std::uint32_t i = 0; i < count; ++i) values[i] = ordered(values[i], OrderMap::kFloat, bits);
    else
        for (std::uint32_t i = 0; i < count; ++i) values[i] = ordered(values[i], OrderMap::kFlipTop, bits);
}

std::uint32_t first_bit(const BlockPlan& plan, const BlockShape& shape, std::size_t c) {
    const std::uint32_t skipped = shape.columns[c].first - shape.first_element;
    return shape.origin + skipped * plan.format.element_bytes * 8 + plan.channels[c].bit;
}

template <OrderMap kMap, typename T, typename Word>
void add_words(std::uint32_t bit, std::uint32_t bits, const T* in, std::uint32_t count, Word* words) {
    for (std::uint32_t i = 0; i < count; ++i)
        words[i] |= static_cast<Word>(static_cast<Word>(unordered(in[i], kMap, bits)) << bit);
}

template <typename T, typename Word>
void add_words(const Channel& channel, const T* in, std::uint32_t count, Word* words) {
    switch (channel.map) {
        case OrderMap::kPlain:
            return add_words<OrderMap::kPlain>(channel.bit, channel.bits, in, count, words);
        case OrderMap::kFlipTop:
            return add_words<OrderMap::kFlipTop>(channel.bit, channel.bits, in, count, words);
        default:
            return add_words<OrderMap::kFloat>(channel.bit, channel.bits, in, count, words);
    }
}

template <typename Word>
void scatter_words(const BlockPlan& plan, const BlockShape& shape, const BlockValues& values,
                   std::uint8_t* block) {
    std::array<Word, kMaxBlockBytes / sizeof(Word)> words;
    const std::uint32_t count = shape.bytes / sizeof(Word);
    std::fill_n(words.begin(), count, Word{0});
    for (std::size_t c = 0; c < plan.channels.size(); ++c) {
        const Channel& channel = plan.channels[c];
        with_integer(channel, [&](auto* type) {
            using T = std::remove_pointer_t<decltype(type)>;
            add_words(channel, values.column<T>(shape.columns[c]), count, words.data());
        });
    }
    std::memcpy(block, words.data(), shape.bytes);
}

}  // namespace

bool BlockPlan::gather(const std::uint8_t* block, const BlockShape& shape, BlockValues& values) const {
    for (std::uint32_t b = shape.bytes; b < format.block_bytes; ++b)
        if (block[b] != 0) return false;
    const bool words = is_words(*this, shape);
    // Reads of 8 bytes at values of odd bits may pass the end.
    std::array<std::uint8_t, kMaxBlockBytes + 8> copy;
    if (!words && !byte_aligned) {
        std::memcpy(copy.data(), block, format.block_bytes);
        std::memset(copy.data() + format.block_bytes, 0, 8);
        block = copy.data();
    }
    for (std::size_t c = 0; c < channels.size(); ++c) {
        const Channel& channel = channels[c];
        const Column& column = shape.columns[c];
        with_integer(channel, [&](auto* type) {
            using T = std::remove_pointer_t<decltype(type)>;
            T* out = values.column<T>(column);
            if (words)
                with_word(format.element_bytes, [&](auto* word) {
                    gather_words<T, std::remove_pointer_t<decltype(word)>>(channel, block, column.count, out);
                });
            else
                gather_bits(channel, block, first_bit(*this, shape, c), format.element_bytes, column.count,
                            out);
            order_column(out, column.count, channel);
        });
    }
    return true;
}

void BlockPlan::scatter(const BlockShape& shape, const BlockValues& values, std::uint8_t* block) const {
    std::memset(block + shape.bytes, 0, format.block_bytes - shape.bytes);
    if (is_words(*this, shape)) {
        with_word(format.element_bytes, [&](auto* word) {
            scatter_words<std::remove_pointer_t<decltype(word)>>(*this, shape, values, block);
        });
        return;
    }
    for (std::size_t c = 0; c < channels.size(); ++c) {
        const Channel& channel = channels[c];
        const Column& column = shape.columns[c];
        std::uint32_t bit = first_bit(*this, shape, c);
        with_integer(channel, [&](auto* type) {
            using T = std::remove_pointer_t<decltype(type)>;
            const T* in = values.column<T>(column);
            for (std::uint32_t i = 0; i < column.count; ++i, bit += format.element_bytes * 8) {
                const T value = unordered(in[i], channel.map, channel.bits);
                if (is_plain<T>(channel))
                    std::memcpy(block + bit / 8, &value, sizeof(T));
                else
                    write_bits(block, bit, channel.bits, value);
            }
        });
    }
}

}  // namespace ropsim
