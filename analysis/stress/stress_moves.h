// What the search for worst pixels tries: random physical pixels, and changes of pixels that were bad
// already.
#pragma once

#include "base/random.h"
#include "rop/single_pixel.h"

#include <cstdint>

namespace ropsim {

// A stream of numbers.
class Draws {
 public:
    explicit Draws(std::uint64_t key) : key_(mix64(key)) {}
    float unit() { return random_unit(key_, next_++); }
    std::uint32_t below(std::uint32_t count) { return random_bits(key_, next_++) % count; }

 private:
    std::uint64_t key_;
    std::uint32_t next_ = 0;
};

// Fragments that a pixel of the search may grow to.
inline constexpr std::uint32_t kMostSearched = 256;

// A random physical pixel; mean number of fragments (1 + most) / 2. `bright`: colours up to 64, else up to 1.
PixelScene random_pixel(std::uint64_t key, std::uint32_t most_fragments, bool bright);

// `from` with a few changes: of one fragment's depth, alpha or colour, of the list (add, remove, swap,
// duplicate, repeat, reverse or sort a run of layers), or a run of `other`'s layers in it.
PixelScene changed(Draws& draws, const PixelScene& from, const PixelScene& other, bool bright);

}  // namespace ropsim
