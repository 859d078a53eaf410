// Least value and width of a column, of its differences and of its anchors.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace ropsim {

inline constexpr std::uint32_t kColumnBuffer = 256 + 16;  // values; whole vectors may be moved at the end

template <typename T>
inline constexpr std::uint32_t kIntegerBits = sizeof(T) * 8;

template <typename T>
struct Range {
    T least;
    std::uint32_t width;  // bits of the largest difference from it
};

// The integer whose least and largest the compiler finds in vectors of every x86-64: unsigned bytes, signed
// else. Flipping the top bit turns one order into the other.
template <typename T>
using Sought = std::conditional_t<sizeof(T) == 1, std::uint8_t, std::make_signed_t<T>>;
template <typename T>
inline constexpr T kTopBit = static_cast<T>(T{1} << (kIntegerBits<T> - 1));

template <typename T, T kFlip>
Range<T> flipped_range(const T* values, std::uint32_t count) {
    auto least = static_cast<Sought<T>>(values[0] ^ kFlip);
    auto largest = least;
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto value = static_cast<Sought<T>>(values[i] ^ kFlip);
        least = value < least ? value : least;
        largest = value > largest ? value : largest;
    }
    const T span = static_cast<T>(static_cast<T>(largest) - static_cast<T>(least));
    return {static_cast<T>(static_cast<T>(least) ^ kFlip), static_cast<std::uint32_t>(std::bit_width(span))};
}

// Of at least one value.
template <typename T>
Range<T> range_of(const T* values, std::uint32_t count) {
    constexpr T kFlip = sizeof(T) == 1 ? 0 : kTopBit<T>;
    return flipped_range<T, kFlip>(values, count);
}

// The same of differences, which are signed.
template <typename T>
Range<T> difference_range(const T* values, std::uint32_t count) {
    constexpr T kFlip = sizeof(T) == 1 ? kTopBit<T> : 0;
    return flipped_range<T, kFlip>(values, count);
}

// Sixteen bytes, that the compiler keeps in a register.
using Words16 = std::uint32_t __attribute__((vector_size(16)));
using LongWords16 = std::uint64_t __attribute__((vector_size(16)));

// The first of every four values, four times; reads and writes to the next multiple of 16 bytes.
template <typename T>
void repeat_anchors(const T* values, std::uint32_t count, T* out) {
    for (std::uint32_t i = 0; i < count; i += 16 / sizeof(T)) {
        std::conditional_t<sizeof(T) == 2, LongWords16, Words16> words;
        std::memcpy(&words, values + i, 16);
        if constexpr (sizeof(T) == 4) {
            words = __builtin_shufflevector(words, words, 0, 0, 0, 0);
        } else {
            words &= static_cast<T>(~T{0});
            words |= words << kIntegerBits<T>;
            words |= words << 2 * kIntegerBits<T>;
        }
        std::memcpy(out + i, &words, 16);
    }
}

}  // namespace ropsim
