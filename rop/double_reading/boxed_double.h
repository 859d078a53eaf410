// A double in the 32-bit word of a pixel's functional state: its number in a table, marked as a negative NaN.
// Words that are copied, moved and compared for identity need not know.
#pragma once

#include <cstddef>
#include <cstdint>

namespace ropsim {

// A value that float holds is kept as the float's bits, every NaN as the positive one. Others go into this
// thread's table. Aborts when the table is full: 2^23 - 1 values.
std::uint32_t boxed_double(double value);
double unboxed_double(std::uint32_t word);

// Whether the word stands for an entry of the table; and how many there are.
bool is_boxed(std::uint32_t word);
std::size_t boxed_doubles();
// Empties this thread's table. Words that stood for an entry are void.
void forget_boxed_doubles();

}  // namespace ropsim
