// A group of tiles of the tiled engine: run by the frame, and its quads put in the order of tiles.
#include "model/tiled_quads.h"

#include <algorithm>
#include <utility>

namespace ropsim {

namespace {
constexpr std::uint64_t kReadAhead = 4;  // quads drawn for one that reads bins or loads
constexpr std::uint32_t kLoadLines = 4;  // of a quad
}  // namespace

void TiledQuads::push(const Segment& segment) {
    auto& stream = streams_[segment.kept->batch.quads[segment.first].partition];
    if (!stream.empty() && stream.back().kept == segment.kept &&
        stream.back().first + stream.back().count == segment.first)
        stream.back().count += segment.count;
    else
        stream.push_back(segment);
}

// Quads from `first` on, which may be of several partitions, each as reads ahead of what follows: one by one
// among the quads that came before, since what fetches them works while a tile is drawn.
void TiledQuads::spread(Kept& extra, std::size_t first) {
    if (first == extra.batch.quads.size()) return;
    for (std::size_t p = 0; p < streams_.size(); ++p) {
        std::uint64_t reads = 0;
        for (std::size_t i = first; i < extra.batch.quads.size(); ++i)
            reads += extra.batch.quads[i].partition == p ? 1 : 0;
        std::uint64_t quads = 0;
        tail_.clear();
        for (auto& stream = streams_[p]; !stream.empty() && quads < kReadAhead * reads; stream.pop_back()) {
            tail_.push_back(stream.back());
            quads += stream.back().count;
        }
        std::uint64_t read = 0;  // comes in front of quad read * quads / reads
        std::size_t next = first;
        const auto push_read = [&] {
            while (extra.batch.quads[next].partition != p) ++next;
            push({&extra, static_cast<std::uint32_t>(next++), 1});
            ++read;
        };
        std::uint64_t at = 0;
        for (auto s = tail_.rbegin(); s != tail_.rend(); ++s) {
            while (s->count > 0) {
                while (read < reads && read * quads / reads <= at) push_read();
                const std::uint64_t until = read < reads ? read * quads / reads : quads;
                const auto taken = static_cast<std::uint32_t>(std::min<std::uint64_t>(s->count, until - at));
                push({s->kept, s->first, taken});
                s->first += taken;
                s->count -= taken;
                at += taken;
            }
        }
        while (read < reads) push_read();
    }
}

void TiledQuads::run_group() {
    const TileGroup group =
        read_tile_group(trace_, config_.tiles, std::move(groups_[next_group_++]), frame_.fragment_channels());
    for (std::uint32_t r = 0; r < group.tiles.size(); ++r)
        for (const std::size_t small :
             TileGroup::small_tiles(config_.tiles, group.tiles[r], tiles_across(frame_.height())))
            rank_[small] = r;
    runs_.resize(std::max(runs_.size(), group.tiles.size()));
    for (auto& runs : runs_) runs.clear();
    pass_of_tile_.assign(group.tiles.size(), 0);
    frame_.start_group(group);
    for (;;) {
        Kept& kept = take_kept();
        if (!frame_.advance(kept.batch)) {
            free_.push_back(&kept);
            break;
        }
        if (kept.batch.quads.empty()) {
            free_.push_back(&kept);
            continue;
        }
        sort_runs(kept);
    }
    Kept& extra = take_kept();
    for (std::size_t r = 0; r < group.tiles.size(); ++r) append_tile(r, group, extra);
    extra.left = extra.batch.quads.size();
    if (extra.left == 0) free_.push_back(&extra);
}

void TiledQuads::sort_runs(Kept& kept) {
    const std::vector<QuadOperation>& quads = kept.batch.quads;
    for (std::uint32_t first = 0; first < quads.size();) {
        const std::uint32_t rank = rank_[quads[first].quad_id / 16];
        std::uint32_t last = first + 1;
        std::uint32_t small = quads[first].quad_id / 16;
        for (; last < quads.size(); ++last) {
            const std::uint32_t next = quads[last].quad_id / 16;
            if (next != small && rank_[next] != rank) break;
            small = next;
        }
        const bool draws = quads[first].kind == QuadKind::kDraw || quads[first].kind == QuadKind::kCulled;
        const bool begins = draws && pass_of_tile_[rank] != frame_.passes_in_group();
        if (begins) pass_of_tile_[rank] = frame_.passes_in_group();
        runs_[rank].push_back({{&kept, first, last - first}, begins});
        first = last;
    }
    kept.left = quads.size();
    kept.memory = quads.size() * sizeof(QuadOperation);
    for (const auto& lines : kept.batch.lines) kept.memory += lines.size() * sizeof(LineAccess);
    for (const auto& values : kept.batch.values) kept.memory += values.size();
    kept_bytes_ += kept.memory;
}

// A tile from its load to its store.
void TiledQuads::append_tile(std::size_t rank, const TileGroup& group, Kept& extra) {
    const std::vector<std::size_t> parts =
        TileGroup::small_tiles(config_.tiles, group.tiles[rank], tiles_across(frame_.height()));
    std::size_t ahead = extra.batch.quads.size();  // read ahead, from here on
    for (const std::size_t small : parts) load_tile(small, extra.batch);
    for (const Run& run : runs_[rank]) {
        if (run.begins_pass) append_reads(group.tiles[rank], run.segment.kept->batch.pass, extra.batch);
        spread(extra, ahead);
        ahead = extra.batch.quads.size();
        push(run.segment);
    }
    spread(extra, ahead);
    const int stored = frame_.operation().declaration().resolves ? map_.image() : 0;
    if (!map_.on_chip(stored)) return;
    for (const std::size_t small : parts) {
        frame_.store_tile(small, extra.batch);
        push({&extra, static_cast<std::uint32_t>(extra.batch.quads.size() - 1), 1});
    }
    report_.stored += parts.size() * static_cast<std::uint64_t>(map_.pixel_bytes(stored)) * kTilePixels;
}

// The opaque layer, once: its depth, and its colour or the target that holds it.
void TiledQuads::load_tile(std::size_t small_tile, QuadBatch& batch) {
    if (!trace_.header().opaque) return;
    const Declaration& declared = frame_.operation().declaration();
    if (map_.on_chip(map_.opaque_depth())) load_surface(map_.opaque_depth(), small_tile, batch);
    const bool target = !declared.resolves && declared.surfaces[0].initial == Initial::kOpaqueTarget;
    const int color = target ? 0 : map_.opaque_color();
    if (map_.on_chip(color)) load_surface(color, small_tile, batch);
}

void TiledQuads::load_surface(int surface, std::size_t small_tile, QuadBatch& batch) {
    const auto bytes = static_cast<std::uint32_t>(map_.pixel_bytes(surface) * kTilePixels);
    const std::uint32_t step = kLoadLines * config_.cache.line_bytes;
    for (std::uint32_t at = 0; at < bytes; at += step) {
        QuadOperation q;
        q.partition = static_cast<std::uint8_t>(map_.partition_of(small_tile));
        q.kind = QuadKind::kCopy;
        q.pass = 0;
        q.quad_id = static_cast<std::uint32_t>(small_tile) * 16;
        q.first_line = static_cast<std::uint32_t>(batch.lines[q.partition].size());
        collector_.begin(batch, q.partition, true);
        collector_.read(surface, map_.tile_address(surface, small_tile) + at, std::min(step, bytes - at));
        q.line_count = collector_.count();
        q.interval = q.line_count;
        batch.quads.push_back(q);
    }
    report_.loaded += bytes;
}

void TiledQuads::append_reads(std::uint32_t tile, std::uint8_t pass, QuadBatch& batch) {
    bins_.append_reads(tile, pass, map_, collector_, batch);
    report_.bin_read += bins_.read_bytes(tile);
}

}  // namespace ropsim
