#include "model/frame.h"

#include "base/parallel.h"
#include "model/frame_shard.h"

#include <algorithm>
#include <utility>

namespace ropsim {

namespace {
constexpr std::size_t kBatchFragments =
    32768;  // run at a time where quads are kept: their lines should stay in cache

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
      depth_test_(trace.header()),
      threads_(threads),
      quads_(quads),
      sequence_(operation.declaration()),
      written_initially_(operation.declaration().surfaces.size()),
      pass_operated_(operation.declaration().passes.size()) {
    for (std::uint32_t p = 0; p < config.partitions; ++p)
        shards_.push_back(std::make_unique<Shard>(*this, map_.pool_nodes()));
    std::vector<const PixelStore*> store_of_tile;
    for (std::size_t tile = 0; tile < trace.tile_fragments().size(); ++tile)
        store_of_tile.push_back(&shards_[static_cast<std::size_t>(map_.partition_of(tile))]->store);
    stores_ = std::make_unique<StoreMap>(trace.header().width, trace.header().height, store_of_tile);
    const auto& surfaces = operation.declaration().surfaces;
    for (std::size_t s = 0; s < surfaces.size(); ++s)
        if (initialised_in_memory(surfaces[s])) initialised_.push_back(static_cast<int>(s));
    covered_.assign(
        static_cast<std::size_t>(trace.header().width) * static_cast<std::size_t>(trace.header().height), 0);
    for (const Pass& pass : operation.declaration().passes) low_scale_ = std::max(low_scale_, pass.scale);
    if (low_scale_ > 1) {
        drawn_.assign(trace.tile_fragments().size(), 0);
        drawn_low_ = drawn_;
    }
    trace_.rewind();
    start_image();
}

Frame::~Frame() {
    if (!selected_.empty()) trace_.select_tiles({});
}

void Frame::select_tiles(std::vector<std::uint8_t> selected) {
    selected_ = std::move(selected);
    trace_.select_tiles(selected_);
    trace_.rewind();
}

bool Frame::advance(QuadBatch& batch) {
    batch.clear();
    batch.lines.resize(config_.partitions);
    batch.values.resize(config_.partitions);
    while (stage_ != Stage::kDone) {
        batch.pass = pass_number();
        if (advance_stage(batch)) return true;
        next_stage();
    }
    return false;
}

std::vector<std::string> Frame::pass_names() const {
    std::vector<std::string> names{"initialise"};
    for (const Pass& pass : operation_.declaration().passes) names.push_back(pass.name);
    names.insert(names.end(), {"resolve", "end_of_frame"});
    return names;
}

std::uint8_t Frame::pass_number() const {
    if (stage_ == Stage::kInitialise) return 0;
    const std::size_t passes = operation_.declaration().passes.size();
    return static_cast<std::uint8_t>(
        stage_ == Stage::kResolve ? passes + 1 : static_cast<std::size_t>(sequence_.pass()) + 1);
}

bool Frame::advance_stage(QuadBatch& batch) {
    switch (stage_) {
        case Stage::kInitialise:
            return advance_initialise(initialised_, batch);
        case Stage::kRestore:
            return advance_initialise(sequence_.current().restores, batch);
        case Stage::kGeometry:
            return advance_geometry(batch);
        case Stage::kImage:
            return advance_image_pass(batch);
        case Stage::kResolve:
            return advance_resolve(batch);
        case Stage::kDone:
            break;
    }
    return false;
}

void Frame::next_stage() {
    next_tile_ = 0;
    chunk_.clear();
    held_back_.clear();
    chunk_next_ = 0;
    trace_.rewind();
    switch (stage_) {
        case Stage::kInitialise:
            return enter_pass();
        case Stage::kRestore:
            for (auto& shard : shards_) shard->store.restore(sequence_.current().restores);
            stage_ = sequence_.current().kind == PassKind::kImage ? Stage::kImage : Stage::kGeometry;
            return;
        case Stage::kGeometry:
        case Stage::kImage: {
            const int watched = sequence_.watched_path();
            sequence_.advance(watched < 0 ? 0 : path_count(static_cast<std::size_t>(watched)));
            return enter_pass();
        }
        case Stage::kResolve:
        case Stage::kDone:
            stage_ = Stage::kDone;
    }
}

void Frame::enter_pass() {
    if (sequence_.done()) {
        stage_ = Stage::kResolve;
        return;
    }
    ++passes_run_;
    const Pass& pass = sequence_.current();
    geometry_passes_run_ += pass.kind == PassKind::kGeometry ? 1 : 0;
    const bool restores = sequence_.round() > 0 && !pass.restores.empty();
    stage_ = restores ? Stage::kRestore : pass.kind == PassKind::kImage ? Stage::kImage : Stage::kGeometry;
}

bool Frame::advance_geometry(QuadBatch& batch) {
    while (chunk_next_ == chunk_.size())
        if (!read_chunk()) return false;
    std::size_t count = std::min(chunk_.size() - chunk_next_, quads_ ? kBatchFragments : chunk_.size());
    while (chunk_next_ + count < chunk_.size() && joins_next(chunk_next_ + count - 1)) ++count;
    const Fragment* fragments = &chunk_.fragments[chunk_next_];
    FragmentSpan span{{fragments, count}};
    if (!chunk_.slopes.empty()) span.slopes = {&chunk_.slopes[chunk_next_], count};
    if (!chunk_.materials.empty()) span.materials = {&chunk_.materials[chunk_next_], count};
    chunk_next_ += count;
    sort_into_shards(fragments, count, batch);
    parallel_for(threads_, static_cast<int>(shards_.size()), [&](int p) {
        Shard& shard = *shards_[static_cast<std::size_t>(p)];
        operation_.run(sequence_.pass(), sequence_.round(), span, shard.operated, shard.store, shard.log);
        if (quads_) emit_pass_quads(shard, fragments, batch);
    });
    return true;
}

// The quad this fragment belongs to: the last one if it is of the same primitive and place, else a new one.
QuadOperation& Frame::quad_of(const Fragment& f, QuadBatch& batch) {
    const Fragment* p = previous_;
    const std::uint32_t pixel = pixel_in_quad(f.x, f.y);
    const bool same_primitive = p != nullptr && p->primitive == f.primitive && p->draw == f.draw;
    const bool continues = same_primitive && p->x / 2 == f.x / 2 && p->y / 2 == f.y / 2 &&
                           pixel_in_quad(p->x, p->y) < pixel;
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
    q.draw = f.draw;
    q.scale = static_cast<std::uint8_t>(sequence_.current().scale);
    // Four lanes run for a quad, whatever its coverage: the others are helpers for derivatives.
    q.shader_lane_cycles = 4 * lane_cycles(f);
    q.new_tile = !same_primitive || p->x / kTileSize != f.x / kTileSize || p->y / kTileSize != f.y / kTileSize;
    set_texture_fetches(f, q);
    shards_[q.partition]->quads.push_back(static_cast<std::uint32_t>(batch.quads.size() - 1));
    return q;
}

// Of the fragment's own shader and of what the technique has it compute besides.
std::uint32_t Frame::lane_cycles(const Fragment& f) const {
    const Draw& draw = trace_.header().draws[f.draw];
    const bool full = sequence_.current().shading == Shading::kFull;
    return (full ? draw.full : draw.alpha).alu_instructions +
           static_cast<std::uint32_t>(operation_.declaration().added_shading.alu_instructions);
}

void Frame::sort_into_shards(const Fragment* fragments, std::size_t count, QuadBatch& batch) {
    const TraceHeader& header = trace_.header();
    const Pass& pass = sequence_.current();
    // Passes that choose draws choose each of them once.
    const bool first_pass = pass.draws.empty() ? passes_run_ == 1 : sequence_.round() == 0;
    const bool drops_zero = operation_.declaration().zero_alpha_harmless;
    const std::vector<std::uint8_t>& joined_draws = operation_.declaration().joined_draws;
    const auto across = static_cast<std::size_t>(tiles_across(header.width));
    for (auto& shard : shards_) {
        shard->operated.clear();
        shard->operated_quad.clear();
        shard->quads.clear();
        shard->log.clear_records();
    }
    previous_ = nullptr;
    FragmentCounts seen;
    DepthTests tests;
    const HierarchicalDepth* ranges = depth_ranges(pass.scale);
    std::uint8_t joined_depths = 0;
    std::uint32_t joined_lane_cycles = 0;  // of fragments that leave with the next one, a lane each
    for (std::size_t i = 0; i < count; ++i) {
        const Fragment& f = fragments[i];
        ++seen.input;
        std::uint8_t depth = 0;
        if (ranges != nullptr && header.draws[f.draw].depth_test) {
            const std::size_t at = static_cast<std::size_t>(&f - chunk_.fragments.data());
            depth = ranges->decide(f, chunk_.slopes.empty() ? DepthSlope{} : chunk_.slopes[at]);
            ++tests.tested;
            tests.read += depth == kDepthUndecided ? 1 : 0;
        }
        if (first_pass && pass.scale == 1 && f.coverage != 0)
            covered_[static_cast<std::size_t>(f.y) * static_cast<std::size_t>(header.width) + f.x] = 1;
        const bool joined = !joined_draws.empty() && joined_draws[f.draw] != 0;
        if (joined && i + 1 < count && joins(f, fragments[i + 1]) && fragments[i + 1].coverage != 0) {
            ++seen.joined;
            joined_lane_cycles += quads_ ? lane_cycles(f) : 0;
            joined_depths |= depth;
            continue;
        }
        QuadOperation* quad = quads_ ? &quad_of(f, batch) : nullptr;
        if (quad != nullptr) {
            quad->shader_lane_cycles += std::exchange(joined_lane_cycles, 0);
            quad->depth |= std::exchange(joined_depths, 0) | depth;
            quad->covered |= static_cast<std::uint8_t>(1u << pixel_in_quad(f.x, f.y));
        }
        if (f.coverage == 0) {
            ++seen.depth_culled;
            continue;
        }
        if (quad != nullptr) quad->kind = QuadKind::kDraw;
        if (drops_zero && !joined && f.a == 0.0f && f.r == 0.0f && f.g == 0.0f && f.b == 0.0f) {
            ++seen.zero_alpha;
            continue;
        }
        ++seen.operated;
        const std::size_t tile =
            static_cast<std::size_t>(f.y / kTileSize) * across + static_cast<std::size_t>(f.x / kTileSize);
        if (low_scale_ > 1) (pass.scale > 1 ? drawn_low_ : drawn_)[tile] = 1;
        Shard& shard = *shards_[static_cast<std::size_t>(map_.partition_of(tile))];
        shard.operated.push_back(static_cast<std::uint32_t>(i));
        if (quads_) shard.operated_quad.push_back(static_cast<std::uint32_t>(batch.quads.size() - 1));
    }
    DepthTests& all_tests = pass.scale > 1 ? depth_tests_low_ : depth_tests_;
    all_tests.tested += tests.tested;
    all_tests.read += tests.read;
    pass_operated_[static_cast<std::size_t>(sequence_.pass())] += seen.operated;
    if (first_pass) {
        counts_.input += seen.input;
        counts_.depth_culled += seen.depth_culled;
        counts_.zero_alpha += seen.zero_alpha;
        counts_.operated += seen.operated;
        counts_.joined += seen.joined;
    }
}

void Frame::emit_pass_quads(Shard& shard, const Fragment* fragments, QuadBatch& batch) const {
    std::size_t record = 0;
    const std::uint8_t* values = shard.log.values().data();
    for (const std::uint32_t number : shard.quads) {
        QuadOperation& q = batch.quads[number];
        q.first_line = static_cast<std::uint32_t>(batch.lines[q.partition].size());
        shard.collector.begin(batch, q.partition);
        const std::size_t tile = q.quad_id / 16;
        if (q.depth_tested()) shard.collector.read_quad(tested_depth(), tile, q.quad_id % 16);
        std::uint32_t group = 0;  // pixels in the lanes now
        std::uint64_t group_interval = 0;
        for (; record < shard.operated.size() && shard.operated_quad[record] == number; ++record) {
            const Fragment& f = fragments[shard.operated[record]];
            const std::uint32_t pixel = pixel_in_quad(f.x, f.y);
            q.pixels = static_cast<std::uint8_t>(q.pixels | 1u << pixel);
            const SurfaceAccess* access = shard.log.record_access(record);
            for (int s = 0; s < map_.technique_surfaces(); ++s)
                values = shard.collector.elements(s, tile, q.quad_id % 16, pixel, access[s], values);
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

// Tiles that no fragment reaches keep the opaque layer: it costs nothing.
void Frame::start_image() {
    const TraceHeader& header = trace_.header();
    image_ = Image(header.width, header.height, {"R", "G", "B"});
    for (int y = 0; y < header.height; ++y) {
        for (int x = 0; x < header.width; ++x) {
            const glm::vec3 color = shards_[0]->store.mean_background(x, y);
            float* out = image_.pixel(x, y);
            const Format format = operation_.declaration().image_format;
            for (int c = 0; c < 3; ++c) out[c] = stored_value(format, color[c]);
        }
    }
}

}  // namespace ropsim
