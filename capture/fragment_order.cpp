// Counting sort by primitive, then a small sort within each primitive, on all cores.
#include "capture/fragment_order.h"

#include "base/error.h"
#include "base/parallel.h"

#include <algorithm>

namespace ropsim {
namespace {

constexpr int kPiecesPerThread = 8;

// Rank of a pixel among a primitive's: 22 bits of tile, 4 of quad, 2 of pixel (images are at most 16384
// across).
std::uint64_t raster_rank(const Fragment& fragment, std::uint32_t tiles_wide) {
    const std::uint32_t x = fragment.x;
    const std::uint32_t y = fragment.y;
    const std::uint32_t tile = (y / kTileSize) * tiles_wide + x / kTileSize;
    const std::uint32_t quad = ((y >> 1) & 3) * 4 + ((x >> 1) & 3);
    const std::uint32_t pixel = (y & 1) * 2 + (x & 1);
    return (std::uint64_t{tile} << 6) | (quad << 2) | pixel;
}

// Orders equal ranks by value, so that no order of arrival can show.
bool earlier(const Fragment& left, const Fragment& right) {
    if (left.z != right.z) return left.z < right.z;
    if (left.a != right.a) return left.a < right.a;
    if (left.r != right.r) return left.r < right.r;
    if (left.g != right.g) return left.g < right.g;
    return left.b < right.b;
}

}  // namespace

void FragmentOrder::sort_primitives(const std::vector<Fragment>& unordered, std::size_t first,
                                    std::size_t last, std::uint16_t draw) {
    const auto rank = [](std::uint64_t key) { return key >> 32; };
    for (std::size_t i = first; i < last; ++i) {
        const auto begin = keys_.begin() + starts_[i];
        const auto end = keys_.begin() + starts_[i + 1];
        std::sort(begin, end);
        for (auto at = begin; at != end; ++at) {
            // Ranks repeat only if the driver split a clipped triangle unevenly.
            if (at + 1 != end && rank(*at) == rank(*(at + 1))) [[unlikely]] {
                const auto stop =
                    std::find_if(at, end, [&](std::uint64_t key) { return rank(key) != rank(*at); });
                std::sort(at, stop, [&](std::uint64_t a, std::uint64_t b) {
                    return earlier(unordered[a & 0xFFFFFFFFu], unordered[b & 0xFFFFFFFFu]);
                });
            }
            Fragment& fragment = ordered_[static_cast<std::size_t>(at - keys_.begin())];
            fragment = unordered[*at & 0xFFFFFFFFu];
            fragment.coverage = 1;
            fragment.draw = draw;
        }
    }
}

const std::vector<Fragment>& FragmentOrder::sort(const std::vector<Fragment>& unordered,
                                                 std::uint64_t first_primitive, std::uint32_t primitives,
                                                 std::uint16_t draw) {
    const std::size_t count = unordered.size();
    const auto tiles_wide = static_cast<std::uint32_t>((width_ + kTileSize - 1) / kTileSize);
    const auto base = static_cast<std::uint32_t>(first_primitive);
    starts_.assign(std::size_t{primitives} + 2, 0);
    for (const Fragment& fragment : unordered) {
        CHECK(fragment.primitive >= base && fragment.primitive - base < primitives,
              "primitive {} in [{}, +{})", fragment.primitive, base, primitives);
        ++starts_[fragment.primitive - base + 2];
    }
    for (std::size_t i = 2; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
    keys_.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        // starts_[p + 1] counts up to where primitive p + 1 begins, which leaves starts_[p] right afterwards.
        keys_[starts_[unordered[i].primitive - base + 1]++] =
            (raster_rank(unordered[i], tiles_wide) << 32) | i;
    }
    ordered_.resize(count);
    // Shares of about equal numbers of fragments, cut between primitives.
    const int pieces = threads_ <= 1 ? 1 : threads_ * kPiecesPerThread;
    const auto first_of = [&](int piece) {
        const auto target = static_cast<std::uint32_t>(count * static_cast<std::size_t>(piece) /
                                                       static_cast<std::size_t>(pieces));
        const auto end = starts_.begin() + primitives;
        return static_cast<std::size_t>(std::lower_bound(starts_.begin(), end, target) - starts_.begin());
    };
    parallel_for(threads_, pieces, [&](int piece) {
        const std::size_t last = piece + 1 == pieces ? primitives : first_of(piece + 1);
        sort_primitives(unordered, piece == 0 ? 0 : first_of(piece), last, draw);
    });
    return ordered_;
}

}  // namespace ropsim
