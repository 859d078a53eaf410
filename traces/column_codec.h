// One column of a trace block as bytes: a reversible filter, then each byte plane on its own.
#pragma once

#include "traces/trace_layout.h"

#include <cstddef>
#include <cstdint>
#include <memory>

namespace ropsim {

// Compresses columns. Holds its scratch memory, so that columns cost no allocation; one thread at a time.
class ColumnEncoder {
 public:
    ColumnEncoder();
    ~ColumnEncoder();
    // Appends to `out` the column of `count` elements (1 or more) of T: std::uint8_t, uint16_t or uint32_t;
    // floats go in as their bits. The filter is chosen by the estimated size.
    template <typename T>
    void encode(const T* elements, std::size_t count, Bytes& out);

 private:
    struct State;
    std::unique_ptr<State> state_;
};

// The inverse. Throws FormatFault for anything that no encoder writes; never reads or writes out of bounds.
class ColumnDecoder {
 public:
    ColumnDecoder();
    ~ColumnDecoder();
    // Reads one whole column from `in` into elements[0, count).
    template <typename T>
    void decode(ByteCursor in, std::size_t count, T* elements);

 private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace ropsim
