// Counting sort by primitive, then a small sort within each primitive, on all cores.
#include "capture/fragment_order.h"

#include "base/error.h"
#include "base/parallel.h"
#include "traces/sample_positions.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace ropsim {
namespace {

constexpr int kPiecesPerThread = 8;

// Rank of a pixel among a primitive's: 22 bits of tile, 4 of quad, 2 of pixel (images are at most 16384
// across).
std::uint64_t raster_rank(std::uint32_t x, std::uint32_t y, std::uint32_t tiles_wide) {
    const std::uint32_t tile = (y / kTileSize) * tiles_wide + x / kTileSize;
    const std::uint32_t quad = ((y >> 1) & 3) * 4 + ((x >> 1) & 3);
    const std::uint32_t pixel = (y & 1) * 2 + (x & 1);
    return (std::uint64_t{tile} << 6) | (quad << 2) | pixel;
}

std::uint64_t rank_of(std::uint64_t key) {
    return key >> 32;
}

// Orders equal ranks by value, so that no order of arrival can show.
bool earlier(const Fragment& left, const Fragment& right) {
    if (left.coverage != right.coverage) return left.coverage < right.coverage;
    if (left.z != right.z) return left.z < right.z;
    if (left.a != right.a) return left.a < right.a;
    if (left.r != right.r) return left.r < right.r;
    if (left.g != right.g) return left.g < right.g;
    return left.b < right.b;
}

template <typename T>
void move_down(std::vector<T>& values, std::size_t from, std::size_t to, std::size_t count) {
    if (!values.empty() && from != to)
        std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(from), count,
                    values.begin() + static_cast<std::ptrdiff_t>(to));
}

}  // namespace

Fragment FragmentOrder::fragment_of(const FragmentRecords& records, std::uint64_t key) const {
    Fragment fragment;
    std::memcpy(&fragment, &records.words[(key & 0xFFFFFFFFu) * records.record_words()], sizeof fragment);
    return fragment;
}

// Writes the record's fragment and channels as element `out`.
void FragmentOrder::put(const FragmentRecords& records, std::uint64_t key, std::size_t out) {
    const std::uint32_t* words = &records.words[(key & 0xFFFFFFFFu) * records.record_words()];
    std::memcpy(&ordered_.fragments[out], words, sizeof(Fragment));
    words += sizeof(Fragment) / sizeof *words;
    if (records.slopes) {
        std::memcpy(static_cast<void*>(&ordered_.slopes[out]), words, sizeof(DepthSlope));
        words += sizeof(DepthSlope) / sizeof *words;
    }
    if (records.materials) std::memcpy(static_cast<void*>(&ordered_.materials[out]), words, sizeof(Material));
}

// One fragment from keys_[first, last), the records of one primitive and pixel, where they cover any sample.
void FragmentOrder::merge(const FragmentRecords& records, std::size_t first, std::size_t last,
                          std::size_t& out) {
    std::uint32_t coverage = 0;
    for (std::size_t i = first; i < last; ++i) coverage |= fragment_of(records, keys_[i]).coverage;
    if (coverage == 0) return;
    const auto shaded = std::min_element(keys_.begin() + static_cast<std::ptrdiff_t>(first),
                                         keys_.begin() + static_cast<std::ptrdiff_t>(last),
                                         [&](std::uint64_t a, std::uint64_t b) {
                                             return earlier(fragment_of(records, a), fragment_of(records, b));
                                         });
    put(records, *shaded, out);
    Fragment& fragment = ordered_.fragments[out];
    if (fragment.coverage != 0 && records.slopes) {
        const auto sample = static_cast<std::size_t>(std::countr_zero(fragment.coverage));
        const SamplePosition position = sample_positions(samples_)[sample];
        const DepthSlope slope = ordered_.slopes[out];
        fragment.z = std::clamp(fragment.z - slope.dx * position.x() - slope.dy * position.y(), 0.0f, 1.0f);
    }
    fragment.coverage = static_cast<std::uint16_t>(coverage);
    ++out;
}

// Orders the fragments of primitives [first, last) from the place of their first record on; returns their
// end.
std::size_t FragmentOrder::sort_primitives(const FragmentRecords& records, std::size_t first,
                                           std::size_t last) {
    std::size_t out = starts_[first];
    for (std::size_t i = first; i < last; ++i) {
        const std::size_t end = starts_[i + 1];
        std::sort(keys_.begin() + starts_[i], keys_.begin() + starts_[i + 1]);
        for (std::size_t at = starts_[i]; at != end;) {
            std::size_t stop = at + 1;
            while (stop != end && rank_of(keys_[stop]) == rank_of(keys_[at])) ++stop;
            if (samples_ > 1) {
                merge(records, at, stop, out);
            } else {
                // Ranks repeat only if the driver split a clipped triangle unevenly.
                if (stop - at > 1) [[unlikely]]
                    std::sort(keys_.begin() + static_cast<std::ptrdiff_t>(at),
                              keys_.begin() + static_cast<std::ptrdiff_t>(stop),
                              [&](std::uint64_t a, std::uint64_t b) {
                                  return earlier(fragment_of(records, a), fragment_of(records, b));
                              });
                for (std::size_t k = at; k < stop; ++k) put(records, keys_[k], out++);
            }
            at = stop;
        }
    }
    return out;
}

// Moves the pieces [begins[i], ends[i]) up against each other.
void FragmentOrder::close_gaps(const std::vector<std::size_t>& begins, const std::vector<std::size_t>& ends) {
    std::size_t total = 0;
    for (std::size_t i = 0; i < begins.size(); ++i) {
        const std::size_t count = ends[i] - begins[i];
        move_down(ordered_.fragments, begins[i], total, count);
        move_down(ordered_.slopes, begins[i], total, count);
        move_down(ordered_.materials, begins[i], total, count);
        total += count;
    }
    ordered_.fragments.resize(total);
    if (!ordered_.slopes.empty()) ordered_.slopes.resize(total);
    if (!ordered_.materials.empty()) ordered_.materials.resize(total);
}

const FragmentChunk& FragmentOrder::sort(const FragmentRecords& records, std::uint64_t first_primitive,
                                         std::uint32_t primitives) {
    const std::size_t count = records.count();
    const std::size_t stride = records.record_words();
    const auto tiles_wide = static_cast<std::uint32_t>((width_ + kTileSize - 1) / kTileSize);
    const auto base = static_cast<std::uint32_t>(first_primitive);
    const auto pixel_of = [&](std::size_t record) { return records.words[record * stride + 5]; };
    const auto number_of = [&](std::size_t record) { return records.words[record * stride + 6]; };
    starts_.assign(std::size_t{primitives} + 2, 0);
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t primitive = number_of(i) & ~kBackFacing;
        CHECK(primitive >= base && primitive - base < primitives, "primitive {} in [{}, +{})", primitive,
              base, primitives);
        ++starts_[primitive - base + 2];
    }
    for (std::size_t i = 2; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
    keys_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        // starts_[p + 1] counts up to where primitive p + 1 begins, which leaves starts_[p] right afterwards.
        const std::uint32_t pixel = pixel_of(i);
        keys_[starts_[(number_of(i) & ~kBackFacing) - base + 1]++] =
            (raster_rank(pixel & 0xFFFFu, pixel >> 16, tiles_wide) << 32) | i;
    }
    ordered_.fragments.resize(count);
    ordered_.slopes.resize(records.slopes ? count : 0);
    ordered_.materials.resize(records.materials ? count : 0);
    // Shares of about equal numbers of records, cut between primitives.
    const int pieces = threads_ <= 1 ? 1 : threads_ * kPiecesPerThread;
    const auto first_of = [&](int piece) {
        const auto target = static_cast<std::uint32_t>(count * static_cast<std::size_t>(piece) /
                                                       static_cast<std::size_t>(pieces));
        const auto end = starts_.begin() + primitives;
        return static_cast<std::size_t>(std::lower_bound(starts_.begin(), end, target) - starts_.begin());
    };
    std::vector<std::size_t> begins(static_cast<std::size_t>(pieces));
    std::vector<std::size_t> ends(static_cast<std::size_t>(pieces));
    parallel_for(threads_, pieces, [&](int piece) {
        const std::size_t first = piece == 0 ? 0 : first_of(piece);
        const std::size_t last = piece + 1 == pieces ? primitives : first_of(piece + 1);
        begins[static_cast<std::size_t>(piece)] = starts_[first];
        ends[static_cast<std::size_t>(piece)] = sort_primitives(records, first, last);
    });
    close_gaps(begins, ends);
    return ordered_;
}

}  // namespace ropsim
