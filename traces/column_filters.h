// The codes inside a trace column, and its filters: reversible maps from elements to elements that compress
// better.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace ropsim {

// Stored as one byte at the start of a column; numbers are never reused.
enum class ColumnFilter : std::uint8_t {
    kNone = 0,
    kConstant = 1,   // one element stands for all
    kPalette = 2,    // up to 256 distinct elements, then an index byte each
    kIncrement = 3,  // e[i] - e[i-1] - 1, e[-1] = -1: gaps of a rising sequence
    kDelta1 = 4,     // zigzag(e[i] - e[i-1]), e[-1] = 0
    kDelta4 = 5,     // zigzag(e[i] - e[i-4]), e[<0] = 0: the same corner of the previous quad
};

inline constexpr std::size_t kMaxPalette = 256;

// How the bytes of one plane (the k-th byte of every filtered element, or the indices of a palette) are
// stored.
enum class PlaneMethod : std::uint8_t {
    kConstant = 0,  // one byte stands for all
    kRaw = 1,       // as they are
    kZstd = 2,      // a size, then one zstd frame
};

// Small differences of either sign become small numbers: 0, -1, 1, -2, ...
template <typename T>
constexpr T zigzag(T difference) {
    using Signed = std::make_signed_t<T>;
    return static_cast<T>(static_cast<T>(difference << 1) ^
                          static_cast<T>(static_cast<Signed>(difference) >> (8 * sizeof(T) - 1)));
}
template <typename T>
constexpr T unzigzag(T value) {
    return static_cast<T>(static_cast<T>(value >> 1) ^ static_cast<T>(0u - (value & 1u)));
}

// Arithmetic is modulo 2^bits throughout, so every filter is exact for every input.
template <typename T>
void apply_filter(ColumnFilter filter, const T* in, std::size_t count, T* out) {
    const std::size_t stride = filter == ColumnFilter::kDelta4 ? 4 : 1;
    const std::size_t head = count < stride ? count : stride;
    switch (filter) {
        case ColumnFilter::kIncrement:
            out[0] = in[0];
            for (std::size_t i = 1; i < count; ++i) out[i] = static_cast<T>(in[i] - in[i - 1] - 1u);
            return;
        case ColumnFilter::kDelta1:
        case ColumnFilter::kDelta4:
            for (std::size_t i = 0; i < head; ++i) out[i] = zigzag(in[i]);
            for (std::size_t i = head; i < count; ++i)
                out[i] = zigzag(static_cast<T>(in[i] - in[i - stride]));
            return;
        default:
            for (std::size_t i = 0; i < count; ++i) out[i] = in[i];
    }
}

template <typename T>
void undo_filter(ColumnFilter filter, T* elements, std::size_t count) {
    switch (filter) {
        case ColumnFilter::kIncrement: {
            T previous = static_cast<T>(~T{0});
            for (std::size_t i = 0; i < count; ++i)
                elements[i] = previous = static_cast<T>(previous + elements[i] + 1u);
            return;
        }
        case ColumnFilter::kDelta1: {
            T previous = 0;
            for (std::size_t i = 0; i < count; ++i)
                elements[i] = previous = static_cast<T>(previous + unzigzag(elements[i]));
            return;
        }
        case ColumnFilter::kDelta4:
            for (std::size_t i = 0; i < count && i < 4; ++i) elements[i] = unzigzag(elements[i]);
            for (std::size_t i = 4; i < count; ++i)
                elements[i] = static_cast<T>(elements[i - 4] + unzigzag(elements[i]));
            return;
        default:
            return;
    }
}

}  // namespace ropsim
