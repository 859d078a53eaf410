// What a frame does before a pass: surfaces that are initialised in memory, tile by tile.
#include "model/compressed_surfaces.h"
#include "model/frame.h"
#include "model/frame_shard.h"

#include <algorithm>

namespace ropsim {

namespace {
constexpr std::size_t kBatchTiles = 128;
}

bool Frame::initialised_in_memory(const Surface& surface) const {
    if (surface.layout == Layout::kPool || surface.initial == Initial::kOpaqueTarget) return false;
    // Without an opaque layer its colour and depth are constants: a clear like any other.
    const bool clear = surface.initial == Initial::kClear || !trace_.header().opaque;
    return !clear || !config_.fast_clear;
}

bool Frame::advance_initialise(const std::vector<int>& surfaces, QuadBatch& batch) {
    if (surfaces.empty()) return false;
    std::size_t tiles = 0;
    for (; next_tile_ < trace_.tile_fragments().size() && tiles < kBatchTiles; ++next_tile_) {
        const std::vector<int> here = surfaces_in(surfaces, next_tile_);
        if (here.empty()) continue;
        if (!tile_used(next_tile_)) {
            skip_initialise(here);
            continue;
        }
        ++tiles;
        Shard& shard = *shards_[static_cast<std::size_t>(map_.partition_of(next_tile_))];
        for (const int s : here) written_initially_[static_cast<std::size_t>(s)] += kTilePixels;
        if (quads_) emit_initialise_quads(shard, next_tile_, here, batch);
    }
    return tiles > 0;
}

// Those of the surfaces that have the tile.
std::vector<int> Frame::surfaces_in(const std::vector<int>& surfaces, std::size_t tile) const {
    std::vector<int> chosen;
    if (!selected(tile)) return chosen;
    for (const int s : surfaces)
        if (tile_pixels(tile, operation_.declaration().surfaces[static_cast<std::size_t>(s)].scale) > 0)
            chosen.push_back(s);
    return chosen;
}

// Whether the frame uses the tile. A window reads its neighbours' tiles, and what gathers reads anywhere,
// whether a fragment has reached them or not.
bool Frame::tile_used(std::size_t tile) const {
    const Declaration& declared = operation_.declaration();
    if (declared.footprint > 0 || declared.gathers || !config_.skip.untouched_tiles) return true;
    return trace_.tile_fragments()[tile] > 0 && region_.meets(tile_region(tile));
}

ScreenRegion Frame::tile_region(std::size_t tile) const {
    const int across = tiles_across(trace_.header().width);
    const int x = static_cast<int>(tile) % across * kTileSize;
    const int y = static_cast<int>(tile) / across * kTileSize;
    return {x, y, x + kTileSize, y + kTileSize};
}

void Frame::skip_initialise(const std::vector<int>& surfaces) {
    ++skipped_.initialise_tiles;
    for (const int s : surfaces) {
        const Surface& surface = operation_.declaration().surfaces[static_cast<std::size_t>(s)];
        std::uint64_t bytes = map_.pixel_bytes(s);
        if (surface.initial != Initial::kClear && trace_.header().opaque)
            bytes += map_.pixel_bytes(surface.initial == Initial::kOpaqueDepth ? map_.opaque_depth()
                                                                               : map_.opaque_color());
        skipped_.initialise_bytes += bytes * kTilePixels;
    }
}

// The opaque layer's depths that a tile of lower resolution keeps, read where they lie.
void Frame::emit_downsample_quads(std::size_t tile, int scale, QuadBatch& batch) const {
    const TraceHeader& header = trace_.header();
    const int across = tiles_across(header.width);
    const int u = static_cast<int>(tile) % across * scale;
    const int v = static_cast<int>(tile) / across * scale;
    for (int y = v; y < std::min(v + scale, tiles_across(header.height)); ++y) {
        for (int x = u; x < std::min(u + scale, across); ++x) {
            const auto from = static_cast<std::size_t>(y * across + x);
            QuadOperation q;
            q.partition = static_cast<std::uint8_t>(map_.partition_of(from));
            q.kind = QuadKind::kCopy;
            q.quad_id = static_cast<std::uint32_t>(from) * 16;
            q.interval = 1;
            q.first_line = static_cast<std::uint32_t>(batch.lines[q.partition].size());
            LineCollector& collector = shards_[q.partition]->collector;
            collector.begin(batch, q.partition);
            for (int py = scale / 2; py < kTileSize; py += scale)
                for (int px = scale / 2; px < kTileSize; px += scale)
                    collector.read(map_.opaque_depth(),
                                   map_.address(map_.opaque_depth(), from,
                                                static_cast<std::uint32_t>(py / 2 * (kTileSize / 2) + px / 2),
                                                static_cast<std::uint32_t>(py % 2 * 2 + px % 2), 0),
                                   map_.pixel_bytes(map_.opaque_depth()));
            q.line_count = collector.count();
            batch.quads.push_back(q);
        }
    }
}

// One operation a line of each surface; the first line of a surface also reads the opaque layer's tile.
void Frame::emit_initialise_quads(Shard& shard, std::size_t tile, const std::vector<int>& surfaces,
                                  QuadBatch& batch) const {
    const std::uint32_t line_bytes = config_.cache.line_bytes;
    const FrameContents contents(map_, operation_.declaration(), shard.store, map_.partition_of(tile));
    std::vector<std::uint8_t> initial;
    for (const int s : surfaces) {
        const Surface& surface = operation_.declaration().surfaces[static_cast<std::size_t>(s)];
        const std::uint64_t bytes =
            static_cast<std::uint64_t>(map_.pixel_bytes(s)) * static_cast<std::uint64_t>(kTilePixels);
        const bool copied = surface.initial != Initial::kClear && trace_.header().opaque;
        if (copied && surface.scale > 1) emit_downsample_quads(tile, surface.scale, batch);
        if (map_.needs_values(s)) contents.tile(s, tile, initial);
        for (std::uint64_t at = 0; at < bytes; at += line_bytes) {
            QuadOperation q;
            q.partition = static_cast<std::uint8_t>(map_.partition_of(tile));
            q.kind = QuadKind::kCopy;
            q.scale = static_cast<std::uint8_t>(surface.scale);
            q.quad_id = static_cast<std::uint32_t>(tile) * 16;
            q.interval = 1;
            q.first_line = static_cast<std::uint32_t>(batch.lines[q.partition].size());
            shard.collector.begin(batch, q.partition);
            if (at == 0 && copied && surface.scale == 1) {
                const int from =
                    surface.initial == Initial::kOpaqueDepth ? map_.opaque_depth() : map_.opaque_color();
                shard.collector.read(from, map_.tile_address(from, tile),
                                     static_cast<std::uint32_t>(map_.pixel_bytes(from) * kTilePixels));
            }
            shard.collector.write(s, map_.tile_address(s, tile) + at,
                                  static_cast<std::uint32_t>(std::min<std::uint64_t>(line_bytes, bytes - at)),
                                  initial.empty() ? nullptr : initial.data() + at);
            q.line_count = shard.collector.count();
            batch.quads.push_back(q);
        }
    }
}

}  // namespace ropsim
