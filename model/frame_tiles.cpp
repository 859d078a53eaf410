// The stages of a frame that go tile by tile once fragments are there: image passes and the resolve.
#include "base/parallel.h"
#include "model/frame.h"
#include "model/frame_shard.h"

#include <algorithm>
#include <array>

namespace ropsim {

namespace {
constexpr std::size_t kBatchTiles = 128;
}

// The pixel state that the resolve would have read is not known.
void Frame::skip_resolve(std::size_t tile) {
    const Declaration& declared = operation_.declaration();
    if (!declared.resolves) return;
    ++skipped_.resolve_tiles;
    std::uint64_t bytes = map_.pixel_bytes(map_.image());
    if (declared.resolve_reads_background && trace_.header().opaque)
        bytes += map_.pixel_bytes(map_.opaque_color());
    skipped_.resolve_bytes += bytes * tile_pixels(tile, 1);
}

// A display filter spreads the samples of a tile to its neighbours and blurs the opaque layer too: every tile
// is resolved then.
std::size_t Frame::take_tiles(const TileChoice& choice, std::size_t quads_each, QuadBatch& batch) {
    for (auto& shard : shards_) {
        shard->tiles.clear();
        shard->tile_quads.clear();
    }
    const auto across = static_cast<std::size_t>(tiles_across(trace_.header().width));
    const std::size_t all = trace_.tile_fragments().size();
    std::size_t tiles = 0;
    for (; next_tile_ < all && tiles < kBatchTiles; ++next_tile_) {
        if (!selected(next_tile_) || tile_pixels(next_tile_, choice.scale) == 0) continue;
        if (!choice.all && config_.skip.untouched_tiles && !reached(next_tile_, choice.scale)) {
            if (stage_ == Stage::kResolve) skip_resolve(next_tile_);
            continue;
        }
        Shard& shard = *shards_[static_cast<std::size_t>(map_.partition_of(next_tile_))];
        // Before threads look at each other's tiles.
        if (choice.allocate)
            shard.store.pixel(static_cast<int>(next_tile_ % across) * kTileSize,
                              static_cast<int>(next_tile_ / across) * kTileSize);
        ++tiles;
        shard.tiles.push_back(next_tile_);
        shard.tile_quads.push_back(batch.quads.size());
        batch.quads.resize(batch.quads.size() + quads_each);
    }
    return tiles;
}

bool Frame::advance_image_pass(QuadBatch& batch) {
    const Pass& pass = sequence_.current();
    const bool emits = quads_ && !pass.gathers;
    const std::size_t tiles = take_tiles({false, pass.gathers, pass.scale}, emits ? 16 : 0, batch);
    for (const auto& shard : shards_)
        for (const std::size_t tile : shard->tiles)
            pass_operated_[static_cast<std::size_t>(sequence_.pass())] += tile_pixels(tile, pass.scale);
    parallel_for(threads_, static_cast<int>(shards_.size()), [&](int p) {
        Shard& shard = *shards_[static_cast<std::size_t>(p)];
        for (std::size_t i = 0; i < shard.tiles.size(); ++i) {
            shard.log.clear_records();
            const auto across = static_cast<std::size_t>(tiles_across(trace_.header().width));
            operation_.image_pass(sequence_.pass(), sequence_.round(), shard.store, *stores_,
                                  static_cast<int>(shard.tiles[i] % across),
                                  static_cast<int>(shard.tiles[i] / across), shard.log);
            if (emits) emit_tile_quads(shard, shard.tiles[i], shard.tile_quads[i], batch);
            if (quads_ && pass.gathers) keep_gathered(shard, shard.tiles[i]);
            shard.log.clear_records();
        }
    });
    if (quads_ && pass.gathers) emit_gather_quads(batch);
    return tiles > 0;
}

bool Frame::advance_resolve(QuadBatch& batch) {
    const Declaration& declared = operation_.declaration();
    const bool windowed = declared.footprint > 0;
    const bool emits = quads_ && declared.resolves && !windowed && !declared.gathers;
    const std::size_t tiles = take_tiles({windowed, declared.gathers, 1}, emits ? 16 : 0, batch);
    for (const auto& shard : shards_)
        for (const std::size_t tile : shard->tiles) resolved_pixels_ += tile_pixels(tile, 1);
    parallel_for(threads_, static_cast<int>(shards_.size()), [&](int p) {
        Shard& shard = *shards_[static_cast<std::size_t>(p)];
        for (std::size_t i = 0; i < shard.tiles.size(); ++i)
            resolve_tile(shard, shard.tiles[i], shard.tile_quads[i], batch);
    });
    if (quads_ && declared.gathers) emit_gather_quads(batch);
    if (quads_ && windowed)
        for (const auto& shard : shards_)
            for (const std::size_t tile : shard->tiles) emit_window_quads(tile, batch);
    return tiles > 0;
}

void Frame::resolve_tile(Shard& shard, std::size_t tile, std::size_t first_quad, QuadBatch& batch) {
    const auto across = static_cast<std::size_t>(tiles_across(trace_.header().width));
    const int tile_x = static_cast<int>(tile % across);
    const int tile_y = static_cast<int>(tile / across);
    std::array<float, std::size_t{3} * kTilePixels> rgb{};
    shard.log.clear_records();
    const Declaration& declared = operation_.declaration();
    operation_.resolve(shard.store, *stores_, tile_x, tile_y, rgb.data(),
                       declared.resolves ? shard.log : shard.readout);
    for (int i = 0; i < kTilePixels; ++i) {
        const int x = tile_x * kTileSize + i % kTileSize;
        const int y = tile_y * kTileSize + i / kTileSize;
        if (x < image_.width && y < image_.height)
            std::copy_n(&rgb[3 * static_cast<std::size_t>(i)], 3, image_.pixel(x, y));
    }
    if (quads_ && declared.gathers)
        keep_gathered(shard, tile);
    else if (quads_ && declared.resolves && declared.footprint == 0)
        emit_tile_quads(shard, tile, first_quad, batch);
    shard.log.clear_records();
}

namespace {

// Where the pixels of a tile stand in the log of what has just gone over it, row by row.
struct TileRecords {
    std::array<int, kTilePixels> record{};              // -1 outside the image: not logged
    std::array<std::size_t, kTilePixels> first_node{};  // of the pixel's walk
};

TileRecords tile_records(const OperationLog& log, const TraceHeader& header, int scale, std::size_t tile) {
    const auto across = static_cast<std::size_t>(tiles_across(header.width));
    const int width = low_resolution(header.width, scale);
    const int height = low_resolution(header.height, scale);
    const int x0 = static_cast<int>(tile % across) * kTileSize;
    const int y0 = static_cast<int>(tile / across) * kTileSize;
    TileRecords result;
    int records = 0;
    std::size_t nodes = 0;
    for (int i = 0; i < kTilePixels; ++i) {
        const bool inside = x0 + i % kTileSize < width && y0 + i / kTileSize < height;
        result.record[static_cast<std::size_t>(i)] = inside ? records : -1;
        result.first_node[static_cast<std::size_t>(i)] = nodes;
        if (!inside) continue;
        if (!log.walk_lengths().empty()) nodes += log.walk_lengths()[static_cast<std::size_t>(records)];
        ++records;
    }
    return result;
}

}  // namespace

void Frame::add_resolved(const PathCost& path, const std::array<std::uint32_t, 2>& steps,
                         const SurfaceAccess* access, QuadOperation& q) const {
    const std::uint32_t turns = turns_.cycles(access, stage_ == Stage::kResolve);
    q.interval += std::max(static_cast<std::uint32_t>(path.interval_cycles(steps)), turns);
    q.latency = std::max(q.latency, static_cast<std::uint32_t>(path.latency_cycles(steps)) + turns - 1);
}

// The quads of a tile that resolve or an image pass has just gone over.
void Frame::emit_tile_quads(Shard& shard, std::size_t tile, std::size_t first_quad, QuadBatch& batch) {
    const TraceHeader& header = trace_.header();
    const bool resolving = stage_ == Stage::kResolve;
    const int watched = group_ != nullptr ? sequence_.watched_path() : -1;
    std::vector<std::uint8_t> values;
    const TileRecords records =
        tile_records(shard.log, header, resolving ? 1 : sequence_.current().scale, tile);
    for (std::uint32_t number = 0; number < 16; ++number) {
        QuadOperation& q = batch.quads[first_quad + number];
        q.quad_id = static_cast<std::uint32_t>(tile) * 16 + number;
        q.partition = static_cast<std::uint8_t>(map_.partition_of(tile));
        q.kind = QuadKind::kResolve;
        if (!resolving) q.scale = static_cast<std::uint8_t>(sequence_.current().scale);
        q.first_line = static_cast<std::uint32_t>(batch.lines[q.partition].size());
        shard.collector.begin(batch, q.partition);
        for (std::uint32_t pixel = 0; pixel < 4; ++pixel) {
            const std::size_t at = (number / 4 * 2 + pixel / 2) * kTileSize + number % 4 * 2 + pixel % 2;
            const int record = records.record[at];
            if (record < 0) continue;
            const auto r = static_cast<std::size_t>(record);
            q.pixels = static_cast<std::uint8_t>(q.pixels | 1u << pixel);
            const SurfaceAccess* access = shard.log.record_access(r);
            for (int s = 0; s < map_.technique_surfaces(); ++s) {
                if (map_.layout(s) != Layout::kPool) {
                    shard.collector.elements(
                        s, tile, number, pixel, access[s],
                        stored_values(shard.store, s, tile, number, pixel, access[s].write, values));
                    continue;
                }
                const std::uint32_t* nodes = shard.log.walk_nodes().data() + records.first_node[at];
                for (std::uint32_t n = 0; n < shard.log.walk_lengths()[r]; ++n)
                    shard.collector.read(s, map_.node_address(s, nodes[n]), map_.element_bytes(s));
            }
            if (shard.log.record_path(r) == watched) note_watched_path(tile);
            add_resolved(cost_[shard.log.record_path(r)], shard.log.record_steps(r), access, q);
        }
        // Pixels of a quad resolve side by side in the lanes.
        q.interval =
            std::max(1u, (q.interval + std::min(config_.lanes, 4u) - 1) / std::min(config_.lanes, 4u));
        if (q.pixels != 0 && resolving) {
            if (operation_.declaration().resolve_reads_background && header.opaque)
                shard.collector.read_quad(map_.opaque_color(), tile, number);
            write_image_quad(shard.collector, tile, number);
        }
        q.interval = std::max(q.interval, shard.collector.on_chip_cycles());
        q.line_count = shard.collector.count();
    }
}

std::uint64_t Frame::tile_pixels(std::size_t tile, int scale) const {
    const TraceHeader& header = trace_.header();
    const auto across = static_cast<std::size_t>(tiles_across(header.width));
    const int width = low_resolution(header.width, scale);
    const int height = low_resolution(header.height, scale);
    // Of a lower resolution there are fewer tiles.
    const int wide = std::clamp(width - static_cast<int>(tile % across) * kTileSize, 0, kTileSize);
    const int high = std::clamp(height - static_cast<int>(tile / across) * kTileSize, 0, kTileSize);
    return static_cast<std::uint64_t>(wide) * static_cast<std::uint64_t>(high);
}

}  // namespace ropsim
