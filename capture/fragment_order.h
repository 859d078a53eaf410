// The canonical order of a trace's fragments, which does not depend on how many threads the driver draws
// with.
#pragma once

#include "traces/trace.h"

#include <cstdint>
#include <vector>

namespace ropsim {

// What the GPU appends for a fragment: 8 words that are a Fragment, then 2 of a DepthSlope and 8 of a
// Material where they are there.
struct FragmentRecords {
    bool slopes = false;
    bool materials = false;
    std::vector<std::uint32_t> words;

    std::size_t record_words() const { return 8u + (slopes ? 2u : 0u) + (materials ? 8u : 0u); }
    std::size_t count() const { return words.size() / record_words(); }
};

// Orders the records of a GPU's unordered append as a rasteriser would send them: by primitive number,
// whichever way it faces, then 8x8 tile (row-major over the image), then 2x2 quad in the tile, then pixel in
// the quad. All numbers lie in [first_primitive, first_primitive + primitives) (CHECK).
//
// With one spatial sample every record is a fragment. With more, a record stands for one sample, whose bit
// its coverage holds, or, with coverage 0, for the pixel's centre; those of one primitive and pixel become
// one fragment. It is shaded at the centre where that is covered, else at its first covered sample (so never
// outside the primitive, like Direct3D's centroid sampling), its depth always that of its plane at the
// centre. The centre alone covers nothing. O(count + primitives); keep one object for many pieces, it reuses
// its memory.
class FragmentOrder {
 public:
    FragmentOrder(int width, int samples, int threads)
        : width_(width), samples_(samples), threads_(threads) {}
    const FragmentChunk& sort(const FragmentRecords& records, std::uint64_t first_primitive,
                              std::uint32_t primitives);

 private:
    Fragment fragment_of(const FragmentRecords& records, std::uint64_t key) const;
    std::size_t sort_primitives(const FragmentRecords& records, std::size_t first, std::size_t last);
    void merge(const FragmentRecords& records, std::size_t first, std::size_t last, std::size_t& out);
    void put(const FragmentRecords& records, std::uint64_t key, std::size_t out);
    void close_gaps(const std::vector<std::size_t>& begins, const std::vector<std::size_t>& ends);

    int width_;
    int samples_;
    int threads_;
    std::vector<std::uint32_t> starts_;  // where each primitive's records begin
    std::vector<std::uint64_t> keys_;    // position in the raster order << 32 | index of the record
    FragmentChunk ordered_;
};

}  // namespace ropsim
