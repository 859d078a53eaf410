#include "model/frame.h"

#include "base/parallel.h"
#include "model/frame_shard.h"

#include <algorithm>

namespace ropsim {

namespace {
constexpr std::size_t kBatchFragments =
    32768;  // run at a time where quads are kept: their lines should stay in cache
constexpr std::size_t kBatchTiles = 128;
constexpr std::uint32_t kDepthBytes = 4;

std::uint32_t quad_in_tile(int x, int y) {
    return static_cast<std::uint32_t>((y % kTileSize) / 2 * (kTileSize / 2) + (x % kTileSize) / 2);
}
std::uint32_t pixel_in_quad(int x, int y) {
    return static_cast<std::uint32_t>((y & 1) * 2 + (x & 1));
}
}  // namespace

Frame::Frame(TraceReader& trace, const FramebufferOperation& operation, const MachineConfig& config,
             int threads, bool quads)
    : trace_(trace),
      operation_(operation),
      config_(config),
      map_(operation.declaration(), config, trace.header()),
      cost_(operation.cost(config.datapath)),
      threads_(threads),
      quads_(quads),
      pass_operated_(operation.declaration().passes.size()) {
    for (std::uint32_t p = 0; p < config.partitions; ++p)
        shards_.push_back(std::make_unique<Shard>(*this, map_.pool_nodes()));
    covered_.assign(
        static_cast<std::size_t>(trace.header().width) * static_cast<std::size_t>(trace.header().height), 0);
    trace_.rewind();
    start_image();
}

Frame::~Frame() = default;

bool Frame::advance(QuadBatch& batch) {
    batch.clear();
    batch.lines.resize(config_.partitions);
    while (stage_ <= passes() + 1) {
        const bool more = stage_ == 0          ? advance_initialise(batch)
                          : stage_ <= passes() ? advance_pass(batch)
                                               : advance_resolve(batch);
        if (more) return true;
        ++stage_;
        next_tile_ = 0;
        chunk_.clear();
        chunk_next_ = 0;
        trace_.rewind();
    }
    return false;
}

bool Frame::initialised_in_memory(const Surface& surface) const {
    if (surface.layout == Layout::kPool || surface.initial == Initial::kOpaqueTarget) return false;
    // Without an opaque layer its colour and depth are constants: a clear like any other.
    const bool clear = surface.initial == Initial::kClear || !trace_.header().opaque;
    return !clear || !config_.fast_clear;
}

bool Frame::advance_initialise(QuadBatch& batch) {
    const auto& surfaces = operation_.declaration().surfaces;
    if (std::none_of(surfaces.begin(), surfaces.end(),
                     [&](const Surface& s) { return initialised_in_memory(s); }))
        return false;
    const auto& fragments = trace_.tile_fragments();
    std::size_t tiles = 0;
    for (; next_tile_ < fragments.size() && tiles < kBatchTiles; ++next_tile_) {
        if (fragments[next_tile_] == 0) continue;
        ++tiles;
        ++initialised_tiles_;
        Shard& shard = *shards_[static_cast<std::size_t>(map_.partition_of(next_tile_))];
        if (quads_) emit_initialise_quads(shard, next_tile_, batch);
    }
    return tiles > 0;
}

// One operation a line of each surface; the first line of a surface also reads the opaque layer's tile.
void Frame::emit_initialise_quads(Shard& shard, std::size_t tile, QuadBatch& batch) const {
    const auto& surfaces = operation_.declaration().surfaces;
    const std::uint32_t line_bytes = config_.cache.line_bytes;
    for (int s = 0; s < map_.technique_surfaces(); ++s) {
        const Surface& surface = surfaces[static_cast<std::size_t>(s)];
        if (!initialised_in_memory(surface)) continue;
        const std::uint64_t bytes =
            static_cast<std::uint64_t>(map_.pixel_bytes(s)) * static_cast<std::uint64_t>(kTilePixels);
        for (std::uint64_t at = 0; at < bytes; at += line_bytes) {
            QuadOperation q;
            q.partition = static_cast<std::uint8_t>(map_.partition_of(tile));
            q.kind = QuadKind::kCopy;
            q.quad_id = static_cast<std::uint32_t>(tile) * 16;
            q.interval = 1;
            auto& lines = batch.lines[q.partition];
            q.first_line = static_cast<std::uint32_t>(lines.size());
            shard.collector.begin(lines);
            if (at == 0 && surface.initial != Initial::kClear && trace_.header().opaque) {
                const int from =
                    surface.initial == Initial::kOpaqueDepth ? map_.opaque_depth() : map_.opaque_color();
                shard.collector.read(from, map_.tile_address(from, tile),
                                     static_cast<std::uint32_t>(map_.pixel_bytes(from) * kTilePixels));
            }
            shard.collector.write(
                s, map_.tile_address(s, tile) + at,
                static_cast<std::uint32_t>(std::min<std::uint64_t>(line_bytes, bytes - at)));
            q.line_count = shard.collector.count();
            batch.quads.push_back(q);
        }
    }
}

bool Frame::read_chunk() {
    chunk_next_ = 0;
    return trace_.next(chunk_);
}

bool Frame::advance_pass(QuadBatch& batch) {
    while (chunk_next_ == chunk_.size())
        if (!read_chunk()) return false;
    const std::size_t count = std::min(chunk_.size() - chunk_next_, quads_ ? kBatchFragments : chunk_.size());
    const Fragment* fragments = &chunk_[chunk_next_];
    chunk_next_ += count;
    sort_into_shards(fragments, count, batch);
    parallel_for(threads_, static_cast<int>(shards_.size()), [&](int p) {
        Shard& shard = *shards_[static_cast<std::size_t>(p)];
        operation_.run(stage_ - 1, {fragments, count}, shard.operated, shard.store, shard.log);
        if (quads_) emit_pass_quads(shard, fragments, batch);
    });
    return true;
}

bool Frame::visible(const Fragment& f) const {
    const TraceHeader& header = trace_.header();
    if (!header.opaque || !header.draws[f.draw].depth_test) return true;
    return f.z <
           header.opaque->depth[static_cast<std::size_t>(f.y) * static_cast<std::size_t>(header.width) + f.x];
}

// The quad this fragment belongs to: the last one if it is of the same primitive and place, else a new one.
QuadOperation& Frame::quad_of(const Fragment& f, QuadBatch& batch) {
    const Fragment* p = previous_;
    const std::uint32_t pixel = pixel_in_quad(f.x, f.y);
    const bool continues = p != nullptr && p->primitive == f.primitive && p->draw == f.draw &&
                           p->x / 2 == f.x / 2 && p->y / 2 == f.y / 2 && pixel_in_quad(p->x, p->y) < pixel;
    previous_ = &f;
    if (continues) return batch.quads.back();
    const TraceHeader& header = trace_.header();
    const std::size_t tile =
        static_cast<std::size_t>(f.y / kTileSize) * static_cast<std::size_t>(tiles_across(header.width)) +
        static_cast<std::size_t>(f.x / kTileSize);
    QuadOperation& q = batch.quads.emplace_back();
    q.quad_id = static_cast<std::uint32_t>(tile) * 16 + quad_in_tile(f.x, f.y);
    q.partition = static_cast<std::uint8_t>(map_.partition_of(tile));
    q.kind = QuadKind::kCulled;
    const Draw& draw = header.draws[f.draw];
    const bool full =
        operation_.declaration().passes[static_cast<std::size_t>(stage_ - 1)].shading == Shading::kFull;
    // Four lanes run for a quad, whatever its coverage: the others are helpers for derivatives.
    q.shader_lane_cycles = 4 * (full ? draw.full_alu_instructions : draw.alpha_alu_instructions);
    shards_[q.partition]->quads.push_back(static_cast<std::uint32_t>(batch.quads.size() - 1));
    return q;
}

void Frame::sort_into_shards(const Fragment* fragments, std::size_t count, QuadBatch& batch) {
    const TraceHeader& header = trace_.header();
    const bool first_pass = stage_ == 1;
    const bool drops_zero = operation_.declaration().zero_alpha_harmless;
    const auto across = static_cast<std::size_t>(tiles_across(header.width));
    for (auto& shard : shards_) {
        shard->operated.clear();
        shard->operated_quad.clear();
        shard->quads.clear();
        shard->log.clear_records();
    }
    previous_ = nullptr;
    FragmentCounts seen;
    std::uint64_t tested = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const Fragment& f = fragments[i];
        ++seen.input;
        tested += header.opaque && header.draws[f.draw].depth_test ? 1 : 0;
        QuadOperation* quad = quads_ ? &quad_of(f, batch) : nullptr;
        if (!visible(f)) {
            ++seen.depth_culled;
            continue;
        }
        if (quad != nullptr) quad->kind = QuadKind::kDraw;
        if (first_pass)
            covered_[static_cast<std::size_t>(f.y) * static_cast<std::size_t>(header.width) + f.x] = 1;
        if (drops_zero && f.a == 0.0f && f.r == 0.0f && f.g == 0.0f && f.b == 0.0f) {
            ++seen.zero_alpha;
            continue;
        }
        ++seen.operated;
        const std::size_t tile =
            static_cast<std::size_t>(f.y / kTileSize) * across + static_cast<std::size_t>(f.x / kTileSize);
        Shard& shard = *shards_[static_cast<std::size_t>(map_.partition_of(tile))];
        shard.operated.push_back(static_cast<std::uint32_t>(i));
        if (quads_) shard.operated_quad.push_back(static_cast<std::uint32_t>(batch.quads.size() - 1));
    }
    depth_tested_ += tested;
    pass_operated_[static_cast<std::size_t>(stage_ - 1)] += seen.operated;
    if (first_pass) {
        counts_.input += seen.input;
        counts_.depth_culled += seen.depth_culled;
        counts_.zero_alpha += seen.zero_alpha;
        counts_.operated += seen.operated;
    }
}

void Frame::emit_pass_quads(Shard& shard, const Fragment* fragments, QuadBatch& batch) const {
    const TraceHeader& header = trace_.header();
    std::size_t record = 0;
    for (const std::uint32_t number : shard.quads) {
        QuadOperation& q = batch.quads[number];
        auto& lines = batch.lines[q.partition];
        q.first_line = static_cast<std::uint32_t>(lines.size());
        shard.collector.begin(lines);
        const std::size_t tile = q.quad_id / 16;
        if (header.opaque)
            shard.collector.read(map_.opaque_depth(),
                                 map_.address(map_.opaque_depth(), tile, q.quad_id % 16, 0, 0),
                                 4 * kDepthBytes);
        std::uint32_t group = 0;  // pixels in the lanes now
        std::uint64_t group_interval = 0;
        for (; record < shard.operated.size() && shard.operated_quad[record] == number; ++record) {
            const Fragment& f = fragments[shard.operated[record]];
            const std::uint32_t pixel = pixel_in_quad(f.x, f.y);
            q.pixels = static_cast<std::uint8_t>(q.pixels | 1u << pixel);
            const SurfaceAccess* access = shard.log.record_access(record);
            for (int s = 0; s < map_.technique_surfaces(); ++s)
                shard.collector.elements(s, tile, q.quad_id % 16, pixel, access[s]);
            const PathCost& path = cost_[shard.log.record_path(record)];
            const auto& steps = shard.log.record_steps(record);
            group_interval = std::max(group_interval, path.interval_cycles(steps));
            q.latency = std::max(q.latency, static_cast<std::uint32_t>(path.latency_cycles(steps)));
            if (++group == config_.lanes) {
                q.interval += static_cast<std::uint32_t>(group_interval);
                group = 0;
                group_interval = 0;
            }
        }
        q.interval += static_cast<std::uint32_t>(group_interval);
        q.line_count = shard.collector.count();
    }
}

bool Frame::advance_resolve(QuadBatch& batch) {
    for (auto& shard : shards_) {
        shard->tiles.clear();
        shard->tile_quads.clear();
    }
    const auto across = static_cast<std::size_t>(tiles_across(trace_.header().width));
    const std::size_t all = trace_.tile_fragments().size();
    const bool emits = quads_ && operation_.declaration().resolves;
    std::size_t tiles = 0;
    for (; next_tile_ < all && tiles < kBatchTiles; ++next_tile_) {
        Shard& shard = *shards_[static_cast<std::size_t>(map_.partition_of(next_tile_))];
        if (!shard.store.touched(static_cast<int>(next_tile_ % across),
                                 static_cast<int>(next_tile_ / across)))
            continue;
        ++tiles;
        shard.tiles.push_back(next_tile_);
        shard.tile_quads.push_back(batch.quads.size());
        resolved_pixels_ += tile_pixels(next_tile_);
        if (emits) batch.quads.resize(batch.quads.size() + 16);
    }
    parallel_for(threads_, static_cast<int>(shards_.size()), [&](int p) {
        Shard& shard = *shards_[static_cast<std::size_t>(p)];
        for (std::size_t i = 0; i < shard.tiles.size(); ++i)
            resolve_tile(shard, shard.tiles[i], shard.tile_quads[i], batch);
    });
    return tiles > 0;
}

void Frame::resolve_tile(Shard& shard, std::size_t tile, std::size_t first_quad, QuadBatch& batch) {
    const auto across = static_cast<std::size_t>(tiles_across(trace_.header().width));
    const int tile_x = static_cast<int>(tile % across);
    const int tile_y = static_cast<int>(tile / across);
    std::array<float, std::size_t{3} * kTilePixels> rgb{};
    shard.log.clear_records();
    const bool resolves = operation_.declaration().resolves;
    operation_.resolve(shard.store, tile_x, tile_y, rgb.data(), resolves ? shard.log : shard.readout);
    for (int i = 0; i < kTilePixels; ++i) {
        const int x = tile_x * kTileSize + i % kTileSize;
        const int y = tile_y * kTileSize + i / kTileSize;
        if (x < image_.width && y < image_.height)
            std::copy_n(&rgb[3 * static_cast<std::size_t>(i)], 3, image_.pixel(x, y));
    }
    if (quads_ && resolves) emit_resolve_quads(shard, tile, first_quad, batch);
    shard.log.clear_records();
}

void Frame::emit_resolve_quads(Shard& shard, std::size_t tile, std::size_t first_quad,
                               QuadBatch& batch) const {
    const TraceHeader& header = trace_.header();
    const auto across = static_cast<std::size_t>(tiles_across(header.width));
    const int x0 = static_cast<int>(tile % across) * kTileSize;
    const int y0 = static_cast<int>(tile / across) * kTileSize;
    // Records are in rows of the tile, pixels outside the image left out.
    std::array<int, kTilePixels> record_of{};
    std::array<std::size_t, kTilePixels> walk_of{};
    int records = 0;
    std::size_t nodes = 0;
    for (int i = 0; i < kTilePixels; ++i) {
        const bool inside = x0 + i % kTileSize < header.width && y0 + i / kTileSize < header.height;
        record_of[static_cast<std::size_t>(i)] = inside ? records : -1;
        walk_of[static_cast<std::size_t>(i)] = nodes;
        if (!inside) continue;
        if (!shard.log.walk_lengths().empty())
            nodes += shard.log.walk_lengths()[static_cast<std::size_t>(records)];
        ++records;
    }
    for (std::uint32_t number = 0; number < 16; ++number) {
        QuadOperation& q = batch.quads[first_quad + number];
        q.quad_id = static_cast<std::uint32_t>(tile) * 16 + number;
        q.partition = static_cast<std::uint8_t>(map_.partition_of(tile));
        q.kind = QuadKind::kResolve;
        auto& lines = batch.lines[q.partition];
        q.first_line = static_cast<std::uint32_t>(lines.size());
        shard.collector.begin(lines);
        for (std::uint32_t pixel = 0; pixel < 4; ++pixel) {
            const std::uint32_t x = number % 4 * 2 + pixel % 2;
            const std::uint32_t y = number / 4 * 2 + pixel / 2;
            const int record = record_of[y * kTileSize + x];
            if (record < 0) continue;
            const auto r = static_cast<std::size_t>(record);
            q.pixels = static_cast<std::uint8_t>(q.pixels | 1u << pixel);
            const SurfaceAccess* access = shard.log.record_access(r);
            for (int s = 0; s < map_.technique_surfaces(); ++s) {
                if (map_.layout(s) != Layout::kPool) {
                    shard.collector.elements(s, tile, number, pixel, access[s]);
                    continue;
                }
                for (std::uint32_t n = 0; n < shard.log.walk_lengths()[r]; ++n)
                    shard.collector.read(
                        s, map_.node_address(s, shard.log.walk_nodes()[walk_of[y * kTileSize + x] + n]),
                        map_.element_bytes(s));
            }
            const PathCost& path = cost_[shard.log.record_path(r)];
            q.interval += static_cast<std::uint32_t>(path.interval_cycles(shard.log.record_steps(r)));
            q.latency = std::max(q.latency,
                                 static_cast<std::uint32_t>(path.latency_cycles(shard.log.record_steps(r))));
        }
        // Pixels of a quad resolve side by side in the lanes.
        q.interval =
            std::max(1u, (q.interval + std::min(config_.lanes, 4u) - 1) / std::min(config_.lanes, 4u));
        if (q.pixels != 0) {
            if (operation_.declaration().resolve_reads_background && header.opaque)
                shard.collector.read(map_.opaque_color(),
                                     map_.address(map_.opaque_color(), tile, number, 0, 0),
                                     4 * map_.pixel_bytes(map_.opaque_color()));
            shard.collector.write(map_.image(), map_.address(map_.image(), tile, number, 0, 0),
                                  4 * map_.pixel_bytes(map_.image()));
        }
        q.line_count = shard.collector.count();
    }
}

std::uint64_t Frame::tile_pixels(std::size_t tile) const {
    const TraceHeader& header = trace_.header();
    const auto across = static_cast<std::size_t>(tiles_across(header.width));
    const int wide = std::min(kTileSize, header.width - static_cast<int>(tile % across) * kTileSize);
    const int high = std::min(kTileSize, header.height - static_cast<int>(tile / across) * kTileSize);
    return static_cast<std::uint64_t>(wide) * static_cast<std::uint64_t>(high);
}

// Tiles that no fragment reaches keep the opaque layer: it costs nothing.
void Frame::start_image() {
    const TraceHeader& header = trace_.header();
    image_ = Image(header.width, header.height, {"R", "G", "B"});
    for (int y = 0; y < header.height; ++y) {
        for (int x = 0; x < header.width; ++x) {
            const glm::vec3 color = shards_[0]->store.background(x, y);
            float* out = image_.pixel(x, y);
            const Format format = operation_.declaration().image_format;
            for (int c = 0; c < 3; ++c) out[c] = stored_value(format, color[c]);
        }
    }
}

}  // namespace ropsim
