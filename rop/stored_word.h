// A value as a word of a pixel's functional state, and back. In the double-precision reading
// (rop/double_reading/) these two are others: a word holds a double there.
#pragma once

#include <bit>
#include <cstdint>

namespace ropsim {

inline std::uint32_t stored_word(float value) {
    return std::bit_cast<std::uint32_t>(value);
}
inline float word_value(std::uint32_t word) {
    return std::bit_cast<float>(word);
}

}  // namespace ropsim
