#include "model/tile_group.h"

#include <algorithm>
#include <utility>

namespace ropsim {

namespace {

constexpr int kRegionSide = 128;  // pixels: what a trace's file keeps together unless told otherwise

template <class Value>
void gather(std::vector<Value>& values, const std::vector<std::uint32_t>& from) {
    if (values.empty()) return;
    std::vector<Value> gathered;
    gathered.reserve(values.size());
    for (const std::uint32_t i : from) gathered.push_back(values[i]);
    values = std::move(gathered);
}

}  // namespace

std::vector<std::size_t> TileGroup::small_tiles(const TilePlan& plan, std::uint32_t tile, int small_down) {
    const int each = plan.side / kTileSize;
    const int x0 = static_cast<int>(tile) % plan.across * each;
    const int y0 = static_cast<int>(tile) / plan.across * each;
    std::vector<std::size_t> small;
    for (int y = y0; y < std::min(y0 + each, small_down); ++y)
        for (int x = x0; x < std::min(x0 + each, plan.small_across); ++x)
            small.push_back(static_cast<std::size_t>(y) * static_cast<std::size_t>(plan.small_across) +
                            static_cast<std::size_t>(x));
    return small;
}

TileGroup read_tile_group(TraceReader& trace, const TilePlan& plan, std::vector<std::uint32_t> tiles,
                          unsigned channels) {
    TileGroup group;
    group.tiles = std::move(tiles);
    group.selected.assign(trace.tile_fragments().size(), 0);
    constexpr std::uint32_t kNoRank = ~0u;
    std::vector<std::uint32_t> rank(
        static_cast<std::size_t>(plan.across) * static_cast<std::size_t>(plan.down), kNoRank);
    for (std::uint32_t i = 0; i < group.tiles.size(); ++i) {
        rank[group.tiles[i]] = i;
        for (const std::size_t small :
             TileGroup::small_tiles(plan, group.tiles[i], tiles_across(trace.header().height)))
            group.selected[small] = 1;
    }
    trace.select_tiles(group.selected);
    trace.rewind();
    FragmentChunk chunk;
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    while (trace.next(chunk, channels)) {
        append(group.fragments.fragments, chunk.fragments);
        append(group.fragments.slopes, chunk.slopes);
        append(group.fragments.materials, chunk.materials);
    }
    // Stable, by tile.
    const auto rank_of = [&](const Fragment& f) {
        return rank[static_cast<std::size_t>(f.y / plan.side) * static_cast<std::size_t>(plan.across) +
                    static_cast<std::size_t>(f.x / plan.side)];
    };
    group.first.assign(group.tiles.size() + 1, 0);
    for (const Fragment& f : group.fragments.fragments) ++group.first[rank_of(f) + 1];
    for (std::size_t i = 1; i < group.first.size(); ++i) group.first[i] += group.first[i - 1];
    std::vector<std::size_t> next(group.first.begin(), group.first.end() - 1);
    std::vector<std::uint32_t> from(group.fragments.size());
    for (std::uint32_t i = 0; i < from.size(); ++i) from[next[rank_of(group.fragments.fragments[i])]++] = i;
    gather(group.fragments.fragments, from);
    gather(group.fragments.slopes, from);
    gather(group.fragments.materials, from);
    return group;
}

std::vector<std::vector<std::uint32_t>> tile_groups(const TraceReader& trace, const TilePlan& plan,
                                                    std::uint64_t most_fragments) {
    std::vector<std::uint64_t> fragments(static_cast<std::size_t>(plan.across) *
                                         static_cast<std::size_t>(plan.down));
    for (std::size_t small = 0; small < trace.tile_fragments().size(); ++small)
        fragments[plan.tile_of(small)] += trace.tile_fragments()[small];
    std::vector<std::vector<std::uint32_t>> groups;
    const int each = kRegionSide / plan.side;
    for (int v = 0; v < plan.down; v += each) {
        for (int u = 0; u < plan.across; u += each) {
            std::vector<std::uint32_t> group;
            std::uint64_t sum = 0;
            for (int y = v; y < std::min(v + each, plan.down); ++y) {
                for (int x = u; x < std::min(u + each, plan.across); ++x) {
                    const auto tile = static_cast<std::uint32_t>(y * plan.across + x);
                    if (fragments[tile] == 0) continue;
                    if (!group.empty() && sum + fragments[tile] > most_fragments) {
                        groups.push_back(std::exchange(group, {}));
                        sum = 0;
                    }
                    group.push_back(tile);
                    sum += fragments[tile];
                }
            }
            if (!group.empty()) groups.push_back(std::move(group));
        }
    }
    return groups;
}

}  // namespace ropsim
