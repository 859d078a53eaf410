// The bytes of a surface's elements as they lie in memory, from functional words and back.
#pragma once

#include "rop/declaration.h"

#include <cstdint>

namespace ropsim {

// Writes the elements of `mask` one behind the other, element_bytes() each: their fields in order, without
// gaps, the lowest bits first; UNORM and SNORM as their codes, floats as their bit patterns. `words`: the
// surface's, of a pixel (or node), already rounded to the stored formats.
void store_elements(const Surface& surface, const std::uint32_t* words, std::uint64_t mask,
                    std::uint8_t* out);

// The inverse for one element: sets its words.
void load_element(const Surface& surface, int element, const std::uint8_t* bytes, std::uint32_t* words);

// One pixel's colour of an image in this format, alpha last where the format has a fourth channel; `out` gets
// `bytes` bytes.
void store_color(Format format, const float* rgb, std::uint32_t bytes, std::uint8_t* out);

}  // namespace ropsim
