// Passes over the transparent fragments: quads in raster order, and what the partitions operate on.
#include "base/parallel.h"
#include "model/frame.h"
#include "model/frame_chunk.h"
#include "model/frame_shard.h"
#include "model/lane_groups.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace ropsim {

namespace {

constexpr std::size_t kBatchFragments =
    32768;  // run at a time where quads are kept: their lines should stay in cache

std::uint32_t quad_in_tile(const Fragment& f) {
    return static_cast<std::uint32_t>(f.y % kTileSize / 2 * (kTileSize / 2) + f.x % kTileSize / 2);
}
std::uint32_t pixel_in_quad(const Fragment& f) {
    return static_cast<std::uint32_t>((f.y & 1) * 2 + (f.x & 1));
}

// What is between a fragment and the one before it. Without branches: it is as good as random.
struct Step {
    Step(const Fragment& before, const Fragment& f)
        : places(static_cast<std::uint32_t>((before.x ^ f.x) | (before.y ^ f.y))),
          owners((before.primitive ^ f.primitive) | static_cast<std::uint32_t>(before.draw ^ f.draw)) {}
    // The rasteriser is still at the same quad, or the same tile, of the same primitive.
    bool stays_in_quad() const { return (places / 2 | owners) == 0; }
    bool stays_in_tile() const { return (places / kTileSize | owners) == 0; }

    std::uint32_t places;
    std::uint32_t owners;
};

}  // namespace

bool Frame::advance_geometry(QuadBatch& batch) {
    if (!quads_) return advance_whole_chunk();
    while (chunk_ == nullptr || chunk_next_ == chunk_->fragments.size()) {
        chunk_ = read_chunk(*own_chunks_[0]);
        if (chunk_ == nullptr) return false;
        chunk_next_ = 0;
    }
    const FragmentChunk& all = chunk_->fragments;
    std::size_t count = std::min(all.size() - chunk_next_, kBatchFragments);
    while (chunk_next_ + count < all.size() && joins_next(all, chunk_next_ + count - 1)) ++count;
    const FragmentSpan span = chunk_->part(chunk_next_, count);
    chunk_next_ += count;
    sort_into_quads(span, batch);
    parallel_for(threads_, static_cast<int>(shards_.size()), [&](int p) {
        Shard& shard = *shards_[static_cast<std::size_t>(p)];
        operation_.run(sequence_.pass(), sequence_.round(), span, shard.operated, shard.store, shard.log);
        emit_pass_quads(shard, batch);
    });
    return true;
}

void Frame::look_up_draws() {
    const TraceHeader& header = trace_.header();
    const Declaration& declared = operation_.declaration();
    const Pass& pass = sequence_.current();
    const bool full = pass.shading == Shading::kFull;
    draws_.clear();
    for (std::size_t d = 0; d < header.draws.size(); ++d) {
        const Draw& draw = header.draws[d];
        const ShaderCost& cost = full ? draw.full : draw.alpha;
        DrawFacts& facts = draws_.emplace_back();
        facts.lane_cycles =
            cost.alu_instructions + static_cast<std::uint32_t>(declared.added_shading.alu_instructions);
        facts.tested = header.opaque && draw.depth_test;
        facts.joined = !declared.joined_draws.empty() && declared.joined_draws[d] != 0;
        facts.quad.kind = config_.skip.occluded ? QuadKind::kCulled : QuadKind::kDraw;
        facts.quad.scale = static_cast<std::uint8_t>(pass.scale);
        facts.quad.draw = static_cast<std::uint16_t>(d);
        // Four lanes run for a quad, whatever its coverage: the others are helpers for derivatives.
        facts.quad.shader_lane_cycles = 4 * facts.lane_cycles;
        // Of its own shader: what the technique has it compute besides has no textures.
        const std::uint32_t fetches = cost.texture_fetches;
        if (fetches == 0) continue;
        facts.quad.texture_fetches = static_cast<std::uint8_t>(std::min(fetches, 255u));
        facts.quad.fetch_bytes =
            static_cast<std::uint16_t>(std::min((cost.texture_bytes + fetches - 1) / fetches, 65535u));
    }
}

std::size_t Frame::tile_of(const Fragment& f) const {
    return static_cast<std::size_t>(f.y / kTileSize) * tiles_across_ +
           static_cast<std::size_t>(f.x / kTileSize);
}

inline QuadOperation& Frame::add_quad(const Fragment& f, QuadBatch& batch) {
    const std::size_t tile = tile_of(f);
    QuadOperation& q = batch.quads.emplace_back(draws_[f.draw].quad);
    q.quad_id = static_cast<std::uint32_t>(tile) * 16 + quad_in_tile(f);
    q.partition = static_cast<std::uint8_t>(map_.partition_of(tile));
    shards_[q.partition]->quads.push_back(static_cast<std::uint32_t>(batch.quads.size() - 1));
    return q;
}

bool Frame::first_pass() const {
    // Passes that choose draws choose each of them once.
    return sequence_.current().draws.empty() ? passes_run_ == 1 : sequence_.round() == 0;
}

void Frame::sort_into_quads(const FragmentSpan& span, QuadBatch& batch) {
    const std::span<const Fragment> fragments = span.fragments;
    const Pass& pass = sequence_.current();
    const bool covers = first_pass() && pass.scale == 1;
    const bool drops_zero = operation_.declaration().zero_alpha_harmless && config_.skip.zero_alpha;
    const auto width = static_cast<std::size_t>(trace_.header().width);
    for (auto& shard : shards_) {
        shard->operated.clear();
        shard->quads.clear();
        shard->log.clear_records();
    }
    FragmentCounts seen;
    seen.input = fragments.size();
    DepthTests tests;
    const HierarchicalDepth* ranges = depth_ranges(pass.scale);
    std::uint8_t joined_depths = 0;
    std::uint32_t joined_lane_cycles = 0;  // of fragments that leave with the next one, a lane each
    const Fragment* before = nullptr;
    QuadOperation* quad = nullptr;
    Shard* shard = nullptr;
    for (std::size_t i = 0; i < fragments.size(); ++i) {
        const Fragment& f = fragments[i];
        const DrawFacts& draw = draws_[f.draw];
        std::uint8_t depth = 0;
        if (ranges != nullptr && draw.tested) {
            depth = ranges->decide(f, slope_of(span, i));
            ++tests.tested;
            tests.read += depth == kDepthUndecided ? 1 : 0;
        }
        if (covers && f.coverage != 0) covered_[f.y * width + f.x] = 1;
        if (draw.joined && joins_seen(fragments, i)) {
            ++seen.joined;
            joined_lane_cycles += draw.lane_cycles;
            joined_depths |= depth;
            continue;
        }
        const auto pixel = static_cast<std::uint8_t>(1u << pixel_in_quad(f));
        const Step step(before == nullptr ? f : *before, f);
        // A quad's fragments come in order of its pixels: another one begins another quad.
        if (before == nullptr || !step.stays_in_quad() || quad->covered >= pixel) {
            quad = &add_quad(f, batch);
            quad->new_tile = before == nullptr || !step.stays_in_tile();
            shard = shards_[quad->partition].get();
        }
        before = &f;
        quad->shader_lane_cycles += std::exchange(joined_lane_cycles, 0);
        quad->depth |= std::exchange(joined_depths, 0) | depth;
        quad->covered |= pixel;
        if (f.coverage == 0) {
            ++seen.depth_culled;
            continue;
        }
        quad->kind = QuadKind::kDraw;
        if (drops_zero && !draw.joined && is_zero(f)) {
            ++seen.zero_alpha;
            continue;
        }
        ++seen.operated;
        if (low_scale_ > 1) (pass.scale > 1 ? drawn_low_ : drawn_)[tile_of(f)] = 1;
        shard->operated.push_back(static_cast<std::uint32_t>(i));
        quad->pixels |= pixel;
    }
    for (const QuadOperation& q : batch.quads)
        skipped_.occluded_lane_cycles += q.kind == QuadKind::kCulled ? q.shader_lane_cycles : 0;
    count(seen, tests);
}

void Frame::count(const FragmentCounts& seen, const DepthTests& tests) {
    DepthTests& all_tests = sequence_.current().scale > 1 ? depth_tests_low_ : depth_tests_;
    all_tests.tested += tests.tested;
    all_tests.read += tests.read;
    pass_operated_[static_cast<std::size_t>(sequence_.pass())] += seen.operated;
    skipped_.zero_alpha_fragments += seen.zero_alpha;
    skipped_.occluded_fragments += config_.skip.occluded ? seen.depth_culled : 0;
    if (!first_pass()) return;
    counts_.input += seen.input;
    counts_.depth_culled += seen.depth_culled;
    counts_.zero_alpha += seen.zero_alpha;
    counts_.operated += seen.operated;
    counts_.joined += seen.joined;
}

// A quad's operations are the log's next records, a pixel of it after the other.
void Frame::emit_pass_quads(Shard& shard, QuadBatch& batch) {
    const int depth = tested_depth();
    const int surfaces = map_.technique_surfaces();
    const int watched = group_ != nullptr ? sequence_.watched_path() : -1;
    const OperationLog& log = shard.log;
    std::size_t record = 0;
    const std::uint8_t* values = log.values().data();
    for (const std::uint32_t drawn : shard.quads) {
        QuadOperation& q = batch.quads[drawn];
        shard.collector.begin(batch, q.partition);
        q.first_line = shard.collector.first();
        const std::size_t tile = q.quad_id / 16;
        const std::uint32_t number = q.quad_id % 16;
        if (q.depth_tested()) {
            shard.collector.read_quad(depth, tile, number);
            // Read before shading, the depths are not the operation's.
            if (config_.front.depth.early && depth == map_.opaque_depth()) {
                q.depth_lines = static_cast<std::uint8_t>(shard.collector.count());
                q.first_line += q.depth_lines;
                shard.collector.begin(batch, q.partition);
            }
        }
        LaneGroups groups(config_.lanes);
        for (std::uint32_t pixels = q.pixels; pixels != 0; pixels &= pixels - 1, ++record) {
            const auto pixel = static_cast<std::uint32_t>(std::countr_zero(pixels));
            const SurfaceAccess* access = log.record_access(record);
            for (int s = 0; s < surfaces; ++s)
                values = shard.collector.elements(s, tile, number, pixel, access[s], values);
            if (log.record_path(record) == watched) note_watched_path(tile);
            groups.add(cost_[log.record_path(record)], log.record_steps(record), turns_.cycles(access));
        }
        q.interval = std::max(groups.interval(), shard.collector.on_chip_cycles());
        q.latency = groups.latency();
        q.line_count = shard.collector.count();
    }
}

}  // namespace ropsim
