#include "model/interlock_order.h"

#include "base/error.h"
#include "model/chunk_order.h"

#include <algorithm>
#include <utility>

namespace ropsim {

namespace {
constexpr std::uint32_t kOrdinals = 1u << 26;

template <class Value>
void append(std::vector<Value>& to, const std::vector<Value>& from) {
    to.insert(to.end(), from.begin(), from.end());
}

}  // namespace

InterlockOrder::InterlockOrder(const std::vector<std::uint64_t>& tile_fragments, std::size_t passes)
    : first_(tile_fragments.size() + 1), passes_(passes) {
    for (std::size_t t = 0; t < tile_fragments.size(); ++t) first_[t + 1] = first_[t] + tile_fragments[t];
}

InterlockOrder::OfPass& InterlockOrder::of_pass(std::uint8_t pass) {
    OfPass& p = passes_[pass];
    if (p.used.empty()) {
        p.operations.resize(first_.back());
        p.used.resize(first_.size() - 1);
        p.arrived.resize((first_.size() - 1) * kTilePixels);
    }
    return p;
}

InterlockOrder::Ordinals InterlockOrder::arrive(std::uint8_t pass, std::uint32_t quad_id,
                                                std::uint32_t pixels) {
    OfPass& p = of_pass(pass);
    Ordinals ordinals{};
    for (std::uint32_t pixel = 0; pixel < 4; ++pixel)
        if ((pixels >> pixel & 1u) != 0) ordinals[pixel] = p.arrived[std::size_t{quad_id} * 4 + pixel]++;
    return ordinals;
}

void InterlockOrder::operate(std::uint8_t pass, std::uint32_t quad_id, std::uint32_t pixels,
                             const Ordinals& ordinals, std::uint64_t overtaken) {
    OfPass& p = of_pass(pass);
    const std::size_t tile = quad_id / 16;
    for (std::uint32_t pixel = 0; pixel < 4; ++pixel) {
        if ((pixels >> pixel & 1u) == 0) continue;
        CHECK(ordinals[pixel] < kOrdinals, "{} operations on a pixel", ordinals[pixel]);
        const std::uint64_t at = first_[tile] + p.used[tile]++;
        CHECK(at < first_[tile + 1], "more operations than fragments in tile {}", tile);
        p.operations[at] = {(quad_id % 16 * 4 + pixel) & 63u, ordinals[pixel] & (kOrdinals - 1)};
    }
    inversions_ += overtaken;
}

std::span<const InterlockOrder::Operation> InterlockOrder::operations(std::uint8_t pass,
                                                                      std::size_t tile) const {
    const OfPass& p = passes_[pass];
    if (p.used.empty()) return {};
    return {p.operations.data() + first_[tile], p.used[tile]};
}

std::string no_replay(const Declaration& declaration) {
    if (!declaration.joined_draws.empty()) return "joins fragments of a draw before they operate";
    if (declaration.repeat.rounds != 1) return "repeats its passes";
    for (const Pass& pass : declaration.passes)
        if (!pass.draws.empty() || pass.scale != 1) return "chooses draws, or draws at a lower resolution";
    return {};
}

bool InterlockReplay::next(FragmentChunk& chunk, unsigned wanted, std::uint8_t pass) {
    const std::vector<std::uint64_t>& fragments = trace_.tile_fragments();
    while (next_tile_ < fragments.size() && fragments[next_tile_] == 0) ++next_tile_;
    if (next_tile_ == fragments.size()) {
        next_tile_ = 0;
        trace_.select_tiles({});
        trace_.rewind();
        return false;
    }
    const std::size_t first = next_tile_;
    std::uint64_t sum = 0;
    do {
        sum += fragments[next_tile_++];
    } while (next_tile_ < fragments.size() && sum + fragments[next_tile_] <= kFragments);
    read_tiles(first, next_tile_, wanted, chunk);
    reorder(first, next_tile_, pass, chunk);
    return true;
}

void InterlockReplay::read_tiles(std::size_t first, std::size_t last, unsigned wanted, FragmentChunk& chunk) {
    std::vector<std::uint8_t> selected(trace_.tile_fragments().size());
    std::fill(selected.begin() + static_cast<std::ptrdiff_t>(first),
              selected.begin() + static_cast<std::ptrdiff_t>(last), std::uint8_t{1});
    trace_.select_tiles(std::move(selected));
    trace_.rewind();
    chunk.clear();
    FragmentChunk part;
    while (trace_.next(part, wanted)) {
        append(chunk.fragments, part.fragments);
        append(chunk.slopes, part.slopes);
        append(chunk.materials, part.materials);
    }
}

// As the frame decides it.
bool InterlockReplay::operated(const FragmentChunk& chunk, std::size_t i) const {
    const Fragment& f = chunk.fragments[i];
    const DepthSlope slope = chunk.slopes.empty() ? DepthSlope{} : chunk.slopes[i];
    if (depth_test_.visible_samples(f, slope) == 0) return false;
    return !declaration_.zero_alpha_harmless || f.a != 0.0f || f.r != 0.0f || f.g != 0.0f || f.b != 0.0f;
}

// By tile, quad of it and pixel of that.
std::size_t InterlockReplay::pixel_of(const Fragment& f) const {
    const auto across = static_cast<std::size_t>(tiles_across(trace_.header().width));
    const std::size_t tile = f.y / kTileSize * across + f.x / kTileSize;
    const auto quad = static_cast<std::size_t>(f.y % kTileSize / 2 * (kTileSize / 2) + f.x % kTileSize / 2);
    return (tile * 16 + quad) * 4 + static_cast<std::size_t>((f.y & 1) * 2 + (f.x & 1));
}

// First what does not operate, then operations in the order of the record.
void InterlockReplay::reorder(std::size_t first, std::size_t last, std::uint8_t pass,
                              FragmentChunk& chunk) const {
    const std::size_t base = first * kTilePixels;
    std::vector<std::uint32_t> order;
    order.reserve(chunk.size());
    std::vector<std::uint32_t> start((last - first) * kTilePixels + 1);  // by pixel, in `sorted`
    std::vector<std::uint8_t> operates(chunk.size());
    for (std::size_t i = 0; i < chunk.size(); ++i) {
        operates[i] = operated(chunk, i) ? 1 : 0;
        if (operates[i] == 0)
            order.push_back(static_cast<std::uint32_t>(i));
        else
            ++start[pixel_of(chunk.fragments[i]) - base + 1];
    }
    for (std::size_t p = 1; p < start.size(); ++p) start[p] += start[p - 1];
    std::vector<std::uint32_t> sorted(start.back());
    std::vector<std::uint32_t> filled(start.begin(), start.end() - 1);
    for (std::size_t i = 0; i < chunk.size(); ++i)
        if (operates[i] != 0)
            sorted[filled[pixel_of(chunk.fragments[i]) - base]++] = static_cast<std::uint32_t>(i);
    for (std::size_t tile = first; tile < last; ++tile) {
        for (const InterlockOrder::Operation& o : order_.operations(pass, tile)) {
            const std::size_t pixel = (tile - first) * kTilePixels + o.pixel;
            CHECK(start[pixel] + o.ordinal < start[pixel + 1], "tile {} pixel {} operation {}", tile,
                  static_cast<int>(o.pixel), static_cast<int>(o.ordinal));
            order.push_back(sorted[start[pixel] + o.ordinal]);
        }
    }
    CHECK(order.size() == chunk.size(), "{} of {} fragments in pass {}", order.size(), chunk.size(), pass);
    permute(chunk, order);
}

}  // namespace ropsim
