// Bits of a compressed block: fields put and taken at a running position, and rows of equally wide ones.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>

namespace ropsim {

inline constexpr std::uint32_t kMaxBlockBytes = 256;

constexpr std::uint64_t low_bits(std::uint32_t count) {
    return count >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
}

// Little endian: bit 0 is the lowest of the first byte.
class BitWriter {
 public:
    BitWriter() { words_[0] = 0; }
    // At most kMaxBlockBytes in all; `value` has no bits above `count` <= 64.
    void put(std::uint64_t value, std::uint32_t count) {
        const std::uint32_t word = position_ >> 6;
        const std::uint32_t shift = position_ & 63;
        words_[word] |= value << shift;
        words_[word + 1] = (value >> 1) >> (63 - shift);
        position_ += count;
    }
    std::uint32_t position() const { return position_; }
    // Copies the first `bytes`; those after the last bit are 0.
    void copy(std::uint8_t* out, std::uint32_t bytes) {
        const std::uint32_t used = (position_ >> 6) + 1;  // words whose bits are defined
        for (std::uint32_t w = used; w * 8 < bytes; ++w) words_[w] = 0;
        std::memcpy(out, words_.data(), bytes);
    }

 private:
    std::uint32_t position_ = 0;
    std::array<std::uint64_t, kMaxBlockBytes / 8 + 2> words_;
};

class BitReader {
 public:
    BitReader(const std::uint8_t* data, std::uint32_t bytes) {
        words_.fill(0);
        std::memcpy(words_.data(), data, bytes);
    }
    std::uint64_t get(std::uint32_t count) {
        const std::uint32_t word = position_ >> 6;
        const std::uint32_t shift = position_ & 63;
        position_ += count;
        return (words_[word] >> shift | (words_[word + 1] << 1) << (63 - shift)) & low_bits(count);
    }
    std::uint32_t position() const { return position_; }

 private:
    std::uint32_t position_ = 0;
    std::array<std::uint64_t, kMaxBlockBytes / 8 + 2> words_;
};

// `count` bits from bit `bit` on, of bytes that may end with them; (bit % 8) + count <= 64.
inline std::uint64_t read_bits(const std::uint8_t* bytes, std::uint32_t bit, std::uint32_t count) {
    std::uint64_t value = 0;
    std::memcpy(&value, bytes + bit / 8, ((bit & 7) + count + 7) / 8);
    return value >> (bit & 7) & low_bits(count);
}
inline void write_bits(std::uint8_t* bytes, std::uint32_t bit, std::uint32_t count, std::uint64_t value) {
    std::uint64_t word = 0;
    const std::uint32_t used = ((bit & 7) + count + 7) / 8;
    std::memcpy(&word, bytes + bit / 8, used);
    word = (word & ~(low_bits(count) << (bit & 7))) | value << (bit & 7);
    std::memcpy(bytes + bit / 8, &word, used);
}

// A word of 8 / sizeof(T) values of `width` bits each, moved together.
template <typename T>
std::uint64_t squeeze(std::uint64_t x, std::uint32_t width) {
    std::uint32_t lane = sizeof(T) * 8;
    std::uint32_t used = width;
    if constexpr (sizeof(T) == 1) {
        x = (x & 0x00FF00FF00FF00FFu) | (x & 0xFF00FF00FF00FF00u) >> (lane - used);
        lane *= 2;
        used *= 2;
    }
    if constexpr (sizeof(T) <= 2) {
        x = (x & 0x0000FFFF0000FFFFu) | (x & 0xFFFF0000FFFF0000u) >> (lane - used);
        lane *= 2;
        used *= 2;
    }
    return (x & 0xFFFFFFFFu) | (x >> 32 << 32) >> (lane - used);
}

// The inverse.
template <typename T>
std::uint64_t spread(std::uint64_t x, std::uint32_t width) {
    constexpr std::uint32_t kLane = sizeof(T) * 8;
    const auto move = [](std::uint64_t value, std::uint32_t lane, std::uint32_t used, std::uint64_t low) {
        const std::uint64_t kept = low * low_bits(used);
        return (value & kept) | (value << (lane - used) & kept << lane);
    };
    x = move(x, 32, width * (4 / sizeof(T)), 1);
    if constexpr (sizeof(T) <= 2) x = move(x, 16, width * (2 / sizeof(T)), 0x0000000100000001u);
    if constexpr (sizeof(T) == 1) x = move(x, kLane, width, 0x0001000100010001u);
    return x;
}

// `count` values of `width` bits; the array is readable to the next multiple of 8 bytes.
template <typename T>
void put_values(BitWriter& out, const T* values, std::uint32_t count, std::uint32_t width) {
    constexpr std::uint32_t kWord = 8 / sizeof(T);
    if (width == 0) return;
    for (std::uint32_t i = 0; i < count; i += kWord) {
        std::uint64_t x = 0;
        std::memcpy(&x, values + i, 8);
        const std::uint32_t bits = (count - i < kWord ? count - i : kWord) * width;
        out.put(squeeze<T>(x, width) & low_bits(bits), bits);
    }
}

// The inverse; writes to the next multiple of 8 bytes.
template <typename T>
void get_values(BitReader& in, T* values, std::uint32_t count, std::uint32_t width) {
    constexpr std::uint32_t kWord = 8 / sizeof(T);
    for (std::uint32_t i = 0; i < count; i += kWord) {
        const std::uint32_t bits = (count - i < kWord ? count - i : kWord) * width;
        const std::uint64_t x = spread<T>(width == 0 ? 0 : in.get(bits), width);
        std::memcpy(values + i, &x, 8);
    }
}

}  // namespace ropsim
