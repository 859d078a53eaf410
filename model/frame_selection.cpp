// Which fragments a pass takes, and as what: those of its draws, at its resolution; and which tiles it, or a
// resolve, must then go over.
#include "base/error.h"
#include "model/chunk_order.h"
#include "model/frame.h"
#include "model/frame_shard.h"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

namespace ropsim {

namespace {

void append(FragmentChunk& to, const FragmentChunk& from, std::size_t first) {
    const auto copy = [first](auto& into, const auto& of) {
        if (of.empty()) return;
        into.insert(into.end(), of.begin() + static_cast<std::ptrdiff_t>(first), of.end());
    };
    copy(to.fragments, from.fragments);
    copy(to.slopes, from.slopes);
    copy(to.materials, from.materials);
}

void shorten(FragmentChunk& chunk, std::size_t size) {
    chunk.fragments.resize(size);
    if (!chunk.slopes.empty()) chunk.slopes.resize(size);
    if (!chunk.materials.empty()) chunk.materials.resize(size);
}

// Within a primitive and tile, quad by quad: what lies at every second pixel comes row by row. Joined draws
// keep their order: what follows one another must not depend on where chunks end.
void order_by_quad(FragmentChunk& chunk, const std::vector<std::uint8_t>& joined) {
    const auto part = [&](std::uint32_t i) {
        const Fragment& f = chunk.fragments[i];
        return std::tuple(f.draw, f.primitive, f.y / kTileSize, f.x / kTileSize);
    };
    const auto place = [&](std::uint32_t i) {
        const Fragment& f = chunk.fragments[i];
        return std::tuple(f.y / 2, f.x / 2, f.y, f.x);
    };
    std::vector<std::uint32_t> order(chunk.size());
    std::iota(order.begin(), order.end(), 0u);
    for (auto first = order.begin(); first != order.end();) {
        const auto last =
            std::find_if(first, order.end(), [&, p = part(*first)](std::uint32_t i) { return part(i) != p; });
        const bool keeps = !joined.empty() && joined[chunk.fragments[*first].draw] != 0;
        if (!keeps)
            std::stable_sort(first, last,
                             [&](std::uint32_t a, std::uint32_t b) { return place(a) < place(b); });
        first = last;
    }
    permute(chunk, order);
}

}  // namespace

unsigned Frame::fragment_channels() const {
    const Declaration& declared = operation_.declaration();
    const unsigned materials = declared.shades_materials ? kMaterialChannels : kNoChannels;
    const bool least_alpha = !declared.shades_materials || declared.knows_alpha_alone;
    return kSlopeChannels | materials | (least_alpha ? kLeastAlpha : kNoChannels);
}

// Dropped fragments must not show inside the region: not by a read from afar, nor by joining what was apart.
void Frame::check_region() const {
    if (region_.whole()) return;
    const TraceHeader& header = trace_.header();
    if (!config_.skip.region.meets({0, 0, header.width, header.height}))
        throw UserError("skip.region",
                        fmt::format("lies outside the image of {}x{} pixels", header.width, header.height));
    const Declaration& declared = operation_.declaration();
    if (declared.gathers || low_scale_ > 1 || !declared.joined_draws.empty() ||
        std::ranges::any_of(declared.passes, &Pass::gathers))
        throw UserError("skip.region",
                        "the technique reads pixels at places it computes, or joins fragments before they "
                        "are exported: leave the key out");
}

// Drops what lies outside the region of interest, before anything is done for it; returns how much.
std::uint64_t Frame::keep_region(FragmentChunk& chunk) const {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < chunk.size(); ++i) {
        const Fragment& f = chunk.fragments[i];
        if (!region_.contains(f.x, f.y)) continue;
        chunk.fragments[kept] = f;
        if (!chunk.slopes.empty()) chunk.slopes[kept] = chunk.slopes[i];
        if (!chunk.materials.empty()) chunk.materials[kept] = chunk.materials[i];
        ++kept;
    }
    const std::uint64_t dropped = chunk.size() - kept;
    shorten(chunk, kept);
    return dropped;
}

// Keeps the chunk's fragments of this pass's draws; at a lower resolution those at its samples, at their
// place there.
void Frame::choose_fragments(FragmentChunk& chunk) {
    const Pass& pass = sequence_.current();
    const TraceHeader& header = trace_.header();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < chunk.size(); ++i) {
        Fragment f = chunk.fragments[i];
        if (pass.draws[f.draw] == 0) continue;
        if (pass.scale > 1) {
            if (f.coverage != 0)
                covered_[static_cast<std::size_t>(f.y) * static_cast<std::size_t>(header.width) + f.x] = 1;
            if (f.x % pass.scale != pass.scale / 2 || f.y % pass.scale != pass.scale / 2) {
                ++counts_.input;
                ++counts_.between;
                continue;
            }
            f.x = static_cast<std::uint16_t>(f.x / pass.scale);
            f.y = static_cast<std::uint16_t>(f.y / pass.scale);
        }
        chunk.fragments[kept] = f;
        if (!chunk.slopes.empty()) chunk.slopes[kept] = chunk.slopes[i];
        if (!chunk.materials.empty()) chunk.materials[kept] = chunk.materials[i];
        ++kept;
    }
    shorten(chunk, kept);
    if (pass.scale > 1) order_by_quad(chunk, operation_.declaration().joined_draws);
}

// Where a trace is cut into chunks must not show: joined fragments at the end wait for those of the next.
void Frame::hold_back_run(FragmentChunk& chunk) {
    if (!held_back_.empty()) {
        append(held_back_, chunk, 0);
        std::swap(chunk, held_back_);
        held_back_.clear();
    }
    std::size_t first = chunk.size();
    while (first > 0 && (first == chunk.size() || joins_next(chunk, first - 1))) --first;
    if (first == chunk.size() || operation_.declaration().joined_draws[chunk.fragments[first].draw] == 0)
        return;
    append(held_back_, chunk, first);
    shorten(chunk, first);
}

// Whether fragment i of the chunk is of a joined draw and the one after it continues its run.
bool Frame::joins_next(const FragmentChunk& chunk, std::size_t i) const {
    const std::vector<std::uint8_t>& joined = operation_.declaration().joined_draws;
    const Fragment& f = chunk.fragments[i];
    return !joined.empty() && joined[f.draw] != 0 && joins(f, chunk.fragments[i + 1]);
}

// The surface that this pass tests depths against: at a lower resolution its own copy.
int Frame::tested_depth() const {
    const auto& surfaces = operation_.declaration().surfaces;
    const int scale = sequence_.current().scale;
    for (std::size_t s = 0; scale > 1 && s < surfaces.size(); ++s)
        if (surfaces[s].scale == scale && surfaces[s].initial == Initial::kOpaqueDepth)
            return static_cast<int>(s);
    return map_.opaque_depth();
}

// The depth ranges of the tiles of a pass at that scale; null where there is nothing opaque.
const HierarchicalDepth* Frame::depth_ranges(int scale) {
    const TraceHeader& header = trace_.header();
    if (!header.opaque) return nullptr;
    depth_ranges_.resize(std::max(depth_ranges_.size(), static_cast<std::size_t>(scale) + 1));
    auto& ranges = depth_ranges_[static_cast<std::size_t>(scale)];
    if (ranges == nullptr)
        ranges = std::make_unique<HierarchicalDepth>(header, config_.front.hierarchical, scale);
    return ranges.get();
}

std::uint64_t Frame::hierarchical_depth_bytes() const {
    std::uint64_t bytes = 0;
    for (const auto& ranges : depth_ranges_) bytes += ranges != nullptr ? ranges->bytes() : 0;
    return bytes;
}

// Whether an image pass of that scale, or the resolve, goes over the tile.
bool Frame::reached(std::size_t tile, int scale) const {
    if (low_scale_ == 1) {
        const auto across = static_cast<std::size_t>(tiles_across(trace_.header().width));
        return shards_[static_cast<std::size_t>(map_.partition_of(tile))]->store.touched(
            static_cast<int>(tile % across), static_cast<int>(tile / across));
    }
    if (scale > 1) return drawn_low_[tile] != 0;
    return drawn_[tile] != 0 || low_resolution_reached(tile);
}

// Whether something was drawn at low resolution in what the tile's pixels read of it.
bool Frame::low_resolution_reached(std::size_t tile) const {
    const TraceHeader& header = trace_.header();
    const int across = tiles_across(header.width);
    const int x = static_cast<int>(tile) % across * kTileSize;
    const int y = static_cast<int>(tile) / across * kTileSize;
    const int reach = operation_.declaration().low_resolution_reach;
    const auto tiles = [&](int at, int size) {
        const int last = std::max(low_resolution(size, low_scale_), 1) - 1;
        return std::pair(std::clamp(at / low_scale_ - reach, 0, last) / kTileSize,
                         std::clamp((at + kTileSize - 1) / low_scale_ + reach, 0, last) / kTileSize);
    };
    const auto [left, right] = tiles(x, header.width);
    const auto [top, bottom] = tiles(y, header.height);
    for (int v = top; v <= bottom; ++v)
        for (int u = left; u <= right; ++u)
            if (drawn_low_[static_cast<std::size_t>(v * across + u)] != 0) return true;
    return false;
}

}  // namespace ropsim
