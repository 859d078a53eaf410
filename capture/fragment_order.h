// The canonical order of a trace's fragments, which does not depend on how many threads the driver draws
// with.
#pragma once

#include "traces/fragment.h"

#include <cstdint>
#include <vector>

namespace ropsim {

// Orders fragments of a GPU's unordered append as a rasteriser would send them: by primitive, then 8x8 tile
// (row-major over the image), then 2x2 quad in the tile, then pixel in the quad. Coverage is set to sample 0
// and `draw` filled in. All primitives lie in [first_primitive, first_primitive + primitives) (CHECK).
// O(count + primitives); keep one object for many pieces, it reuses its memory.
class FragmentOrder {
 public:
    FragmentOrder(int width, int threads) : width_(width), threads_(threads) {}
    const std::vector<Fragment>& sort(const std::vector<Fragment>& unordered, std::uint64_t first_primitive,
                                      std::uint32_t primitives, std::uint16_t draw);

 private:
    void sort_primitives(const std::vector<Fragment>& unordered, std::size_t first, std::size_t last,
                         std::uint16_t draw);

    int width_;
    int threads_;
    std::vector<std::uint32_t> starts_;  // where each primitive's fragments begin
    std::vector<std::uint64_t>
        keys_;  // position in the raster order << 32 | index into the unordered fragments
    std::vector<Fragment> ordered_;
};

}  // namespace ropsim
