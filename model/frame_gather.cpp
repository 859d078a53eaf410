// Quads of resolves and image passes that read pixels around their own: those of other partitions' tiles are
// read by quads of those partitions, in front of the one that computes.
#include "model/frame.h"
#include "model/frame_shard.h"

#include <algorithm>
#include <cstdlib>
#include <tuple>

namespace ropsim {

// A quad reads the pixels of its window where they lie: those of another partition's tiles as quads of that
// partition, in front of it.
void Frame::emit_window_quads(std::size_t tile, QuadBatch& batch) {
    const TraceHeader& header = trace_.header();
    const auto across = static_cast<std::size_t>(tiles_across(header.width));
    const Declaration& declared = operation_.declaration();
    const auto path = std::ranges::find(cost_, kResolvePass, &PathCost::pass);
    const int quads_wide = (header.width + 1) / 2;
    const int quads_high = (header.height + 1) / 2;
    const int reach = (declared.footprint + 1) / 2;
    const int background_reach = (declared.background_footprint + 1) / 2;
    for (std::uint32_t number = 0; number < 16; ++number) {
        const int u = static_cast<int>(tile % across) * (kTileSize / 2) + static_cast<int>(number % 4);
        const int v = static_cast<int>(tile / across) * (kTileSize / 2) + static_cast<int>(number / 4);
        if (u >= quads_wide || v >= quads_high) continue;
        const int home = map_.partition_of(tile);
        for (int turn = 1; turn <= map_.partitions(); ++turn) {  // the quad's own partition comes last
            const int partition = (home + turn) % map_.partitions();
            QuadOperation q;
            q.quad_id = static_cast<std::uint32_t>(tile) * 16 + number;
            q.partition = static_cast<std::uint8_t>(partition);
            q.kind = QuadKind::kResolve;
            q.interval = 1;
            LineCollector& collector = shards_[static_cast<std::size_t>(partition)]->collector;
            q.first_line = static_cast<std::uint32_t>(batch.lines[q.partition].size());
            collector.begin(batch, partition);
            for (int y = std::max(0, v - reach); y <= std::min(quads_high - 1, v + reach); ++y)
                for (int x = std::max(0, u - reach); x <= std::min(quads_wide - 1, u + reach); ++x)
                    collect_quad(collector, partition, x, y, *path,
                                 std::max(std::abs(x - u), std::abs(y - v)) <= background_reach);
            if (partition == home) {
                q.pixels = 0xF;
                const std::uint32_t turns = turns_.cycles(path->worst.data(), true);
                const std::uint32_t interval = std::max(static_cast<std::uint32_t>(path->interval), turns);
                q.interval = interval * ((4 + config_.lanes - 1) / config_.lanes);
                q.latency = static_cast<std::uint32_t>(path->latency()) + turns - 1;
                write_image_quad(collector, tile, number);
            }
            q.line_count = collector.count();
            if (q.line_count > 0) batch.quads.push_back(q);
        }
    }
}

// What a resolve reads of the quad at (x, y), if it is this partition's.
void Frame::collect_quad(LineCollector& collector, int partition, int x, int y, const PathCost& path,
                         bool background) const {
    const TraceHeader& header = trace_.header();
    const auto tile = static_cast<std::size_t>(y / 4) * static_cast<std::size_t>(tiles_across(header.width)) +
                      static_cast<std::size_t>(x / 4);
    if (map_.partition_of(tile) != partition) return;
    const auto number = static_cast<std::uint32_t>(y % 4 * 4 + x % 4);
    for (std::uint32_t pixel = 0; pixel < 4; ++pixel)
        for (int s = 0; s < map_.technique_surfaces(); ++s)
            collector.elements(s, tile, number, pixel, {path.worst[static_cast<std::size_t>(s)].read, 0},
                               nullptr);
    if (background && operation_.declaration().resolve_reads_background && header.opaque)
        collector.read_quad(map_.opaque_color(), tile, number);
}

// What the operations on a tile's pixels did, quad by quad, for emit_gather_quads. The pixels of a quad read
// much the same: each place is asked for once, and in the order in which it lies in memory.
void Frame::keep_gathered(Shard& shard, std::size_t tile) const {
    const int scale = stage_ == Stage::kResolve ? 1 : sequence_.current().scale;
    const int width = low_resolution(trace_.header().width, scale);
    const int height = low_resolution(trace_.header().height, scale);
    const int across = tiles_across(trace_.header().width);
    const int x0 = static_cast<int>(tile) % across * kTileSize;
    const int y0 = static_cast<int>(tile) / across * kTileSize;
    GatheredTile& kept = shard.gathered.emplace_back();
    kept.tile = tile;
    std::size_t record = 0;
    auto read = shard.log.gather_reads().begin();
    for (int i = 0; i < kTilePixels; ++i) {
        const int x = i % kTileSize;
        const int y = i / kTileSize;
        if (x0 + x >= width || y0 + y >= height) continue;
        GatheredQuad& quad = kept.quads[static_cast<std::size_t>(y / 2 * (kTileSize / 2) + x / 2)];
        GatheredPixel& pixel = quad.pixels[static_cast<std::size_t>(y % 2 * 2 + x % 2)];
        pixel.inside = true;
        pixel.path = shard.log.record_path(record);
        pixel.steps = shard.log.record_steps(record);
        std::copy_n(shard.log.record_access(record), static_cast<std::size_t>(map_.technique_surfaces()),
                    pixel.access.begin());
        const auto end = read + shard.log.gather_lengths()[record];
        quad.reads.insert(quad.reads.end(), read, end);
        read = end;
        ++record;
    }
    const auto place = [](const GatherRead& r) {
        return std::tuple(r.surface, r.y / kTileSize, r.x / kTileSize, r.y, r.x);
    };
    for (GatheredQuad& quad : kept.quads) {
        std::ranges::sort(quad.reads, {}, place);
        const auto same = [&](const GatherRead& a, const GatherRead& b) { return place(a) == place(b); };
        quad.reads.erase(std::unique(quad.reads.begin(), quad.reads.end(), same), quad.reads.end());
    }
}

void Frame::emit_gather_quads(QuadBatch& batch) {
    for (auto& shard : shards_) {
        for (const GatheredTile& tile : shard->gathered)
            for (std::uint32_t number = 0; number < tile.quads.size(); ++number)
                emit_gathered_quad(tile.tile, number, tile.quads[number], batch);
        shard->gathered.clear();
    }
}

void Frame::emit_gathered_quad(std::size_t tile, std::uint32_t number, const GatheredQuad& quad,
                               QuadBatch& batch) {
    const int across = tiles_across(trace_.header().width);
    const int home = map_.partition_of(tile);
    QuadOperation own;
    for (std::uint32_t p = 0; p < 4; ++p) {
        if (!quad.pixels[p].inside) continue;
        const PathCost& path = cost_[quad.pixels[p].path];
        own.pixels = static_cast<std::uint8_t>(own.pixels | 1u << p);
        add_resolved(path, quad.pixels[p].steps, quad.pixels[p].access.data(), own);
    }
    if (own.pixels == 0) return;
    std::vector<std::uint8_t> values;
    const std::uint32_t side_by_side = std::min(config_.lanes, 4u);
    own.interval = std::max(1u, (own.interval + side_by_side - 1) / side_by_side);
    for (int turn = 1; turn <= map_.partitions(); ++turn) {  // the quad's own partition comes last
        const int partition = (home + turn) % map_.partitions();
        QuadOperation q;
        q.interval = 1;
        if (partition == home) q = own;
        q.quad_id = static_cast<std::uint32_t>(tile) * 16 + number;
        q.partition = static_cast<std::uint8_t>(partition);
        q.kind = QuadKind::kResolve;
        if (stage_ == Stage::kImage) q.scale = static_cast<std::uint8_t>(sequence_.current().scale);
        LineCollector& collector = shards_[static_cast<std::size_t>(partition)]->collector;
        q.first_line = static_cast<std::uint32_t>(batch.lines[q.partition].size());
        collector.begin(batch, partition);
        for (const GatherRead& read : quad.reads) {
            const auto at = static_cast<std::size_t>(read.y / kTileSize * across + read.x / kTileSize);
            if (map_.partition_of(at) != partition) continue;
            int surface = read.surface;
            if (read.surface == GatherRead::kBackground) surface = map_.opaque_color();
            if (read.surface == GatherRead::kOpaqueDepth) surface = map_.opaque_depth();
            if (surface >= map_.technique_surfaces() && !trace_.header().opaque) continue;
            collector.elements(
                surface, at,
                static_cast<std::uint32_t>(read.y % kTileSize / 2 * (kTileSize / 2) + read.x % kTileSize / 2),
                static_cast<std::uint32_t>(read.y % 2 * 2 + read.x % 2), {map_.all_elements_of(surface), 0},
                nullptr);
        }
        if (partition == home) {
            for (std::uint32_t p = 0; p < 4; ++p)
                for (int s = 0; quad.pixels[p].inside && s < map_.technique_surfaces(); ++s) {
                    const SurfaceAccess& access = quad.pixels[p].access[static_cast<std::size_t>(s)];
                    collector.elements(s, tile, number, p, access,
                                       stored_values(shards_[static_cast<std::size_t>(home)]->store, s, tile,
                                                     number, p, access.write, values));
                }
            if (stage_ == Stage::kResolve) write_image_quad(collector, tile, number);
        }
        q.line_count = collector.count();
        if (q.line_count > 0) batch.quads.push_back(q);
    }
}

}  // namespace ropsim
