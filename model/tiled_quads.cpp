#include "model/tiled_quads.h"

#include <algorithm>
#include <utility>

namespace ropsim {

namespace {
constexpr std::size_t kBatchQuads = 8192;           // handed out at once
constexpr std::uint64_t kGroupFragments = 1 << 19;  // run at once, if they are not all of one tile
constexpr std::uint64_t kMostKept = 256ull << 20;   // bytes of quads that another group is run ahead of
}  // namespace

TileBins prepare_tiled(TraceReader& trace, const Declaration& declaration, MachineConfig& config) {
    config.tiles = plan_tiles(config.tiled, declaration, trace.header());
    config.partition_tiles = static_cast<std::uint32_t>(config.tiles.side / kTileSize);
    if (config.tiles.anything_on_chip()) {
        bool spilled = false;
        for (std::size_t s = 0; s < declaration.surfaces.size(); ++s)
            spilled = spilled || config.tiles.on_chip[s] == 0;
        config.cache_hit_latency =
            spilled ? std::max(config.cache_hit_latency, config.tiled.hit_latency) : config.tiled.hit_latency;
    }
    TileBins bins(trace, config, SurfaceMap(declaration, config, trace.header()));
    config.tiles.bin_bytes = bins.largest_share();
    return bins;
}

TiledQuads::TiledQuads(Frame& frame, TraceReader& trace, const MachineConfig& config, const TileBins& bins)
    : frame_(frame),
      trace_(trace),
      config_(config),
      bins_(bins),
      map_(frame.surfaces()),
      collector_(map_, config),
      groups_(tile_groups(trace, config.tiles, kGroupFragments)),
      streams_(config.partitions),
      rank_(trace.tile_fragments().size()) {
    report_.plan = config.tiles;
    report_.primitives = bins.primitives();
    report_.bin_entries = bins.entries();
    report_.bin_written = bins.written_bytes();
    for (const auto& group : groups_) report_.tiles += group.size();
    // Without a pass of its own, or a tile.
    if (config.tiles.tiled_passes == 0) groups_.clear();
}

TiledQuads::~TiledQuads() {
    trace_.select_tiles({});
}

void TiledQuads::prepare(QuadBatch& batch) const {
    batch.clear();
    batch.lines.resize(config_.partitions);
    batch.values.resize(config_.partitions);
    batch.pass = 0;
}

bool TiledQuads::advance(QuadBatch& batch) {
    prepare(batch);
    for (;;) {
        switch (stage_) {
            case Stage::kBinning:
                if (advance_binning(batch)) return true;
                stage_ = Stage::kTiles;
                break;
            case Stage::kTiles:
                if (advance_tiles(batch)) return true;
                prepare(batch);
                stage_ = config_.tiles.tiled_resolve ? Stage::kDone : Stage::kRest;
                if (stage_ == Stage::kRest) frame_.start_rest();
                break;
            case Stage::kRest:
                if (advance_rest(batch)) return true;
                stage_ = Stage::kDone;
                break;
            case Stage::kDone:
                return false;
        }
    }
}

// The binner is one for the whole machine; tiles begin when it has finished. So in every partition the
// operation units are taken for as long as it works, shared out over the lines that the partition writes.
bool TiledQuads::advance_binning(QuadBatch& batch) {
    const std::uint64_t rate = config_.tiled.bin_entries_per_cycle;
    const std::uint64_t cycles = config_.tiled.overlap_binning ? 0 : (bins_.entries() + rate - 1) / rate;
    bool more = true;
    for (; more && batch.quads.size() < kBatchQuads; ++binned_) {
        more = false;
        for (int p = 0; p < map_.partitions(); ++p) {
            const std::size_t writes = bins_.writes(p);
            if (binned_ >= std::max<std::size_t>(writes, cycles > 0 ? 1 : 0)) continue;
            more = true;
            if (writes > 0) {
                bins_.append_write(p, binned_, map_, collector_, batch);
            } else {
                QuadOperation& q = batch.quads.emplace_back();
                q.partition = static_cast<std::uint8_t>(p);
                q.kind = QuadKind::kCopy;
                q.first_line = static_cast<std::uint32_t>(batch.lines[q.partition].size());
            }
            const std::uint64_t parts = std::max<std::size_t>(writes, 1);
            batch.quads.back().interval =
                static_cast<std::uint32_t>(cycles * (binned_ + 1) / parts - cycles * binned_ / parts);
        }
    }
    return !batch.quads.empty();
}

bool TiledQuads::wants_group() const {
    if (next_group_ == groups_.size() || kept_bytes_ >= kMostKept) return false;
    return std::ranges::any_of(streams_, [](const auto& stream) { return stream.empty(); });
}

bool TiledQuads::advance_tiles(QuadBatch& batch) {
    bool more = true;
    batch.by_tile = true;
    while (more && batch.quads.size() < kBatchQuads) {
        while (wants_group()) run_group();
        more = false;
        for (auto& stream : streams_) {
            if (stream.empty()) continue;
            more = true;
            hand_out(stream.front(), batch);
            if (stream.front().count == 0) stream.pop_front();
        }
        more = more || next_group_ < groups_.size();
    }
    return !batch.quads.empty();
}

// The first quad of a segment.
void TiledQuads::hand_out(Segment& segment, QuadBatch& batch) {
    Kept& kept = *segment.kept;
    QuadOperation q = kept.batch.quads[segment.first];
    if (q.pass == QuadOperation::kBatchPass) q.pass = kept.batch.pass;
    const auto& from = kept.batch.lines[q.partition];
    auto& to = batch.lines[q.partition];
    const auto first = static_cast<std::uint32_t>(to.size());
    // With those that the depth unit reads.
    to.insert(to.end(), from.begin() + q.first_line - q.depth_lines,
              from.begin() + q.first_line + q.line_count);
    for (auto line = to.begin() + first; line != to.end(); ++line) {
        if (line->values == LineAccess::kNoValues) continue;
        const auto bytes = kept.batch.values[q.partition].begin() + line->values;
        auto& values = batch.values[q.partition];
        line->values = static_cast<std::uint32_t>(values.size());
        values.insert(values.end(), bytes, bytes + config_.cache.line_bytes);
    }
    q.first_line = first + q.depth_lines;
    batch.quads.push_back(q);
    ++segment.first;
    --segment.count;
    if (--kept.left == 0) {
        kept_bytes_ -= std::exchange(kept.memory, 0);
        free_.push_back(&kept);
    }
}

TiledQuads::Kept& TiledQuads::take_kept() {
    if (free_.empty()) {
        owned_.push_back(std::make_unique<Kept>());
        free_.push_back(owned_.back().get());
    }
    Kept& kept = *free_.back();
    free_.pop_back();
    prepare(kept.batch);
    return kept;
}

// Passes over the whole screen read every bin anew, in front of them.
bool TiledQuads::advance_rest(QuadBatch& batch) {
    if (!has_waiting_) {
        if (!frame_.advance(batch)) return false;
        const bool draws = std::ranges::any_of(batch.quads, [](const QuadOperation& q) {
            return q.kind == QuadKind::kDraw || q.kind == QuadKind::kCulled;
        });
        if (!draws || std::exchange(last_pass_, batch.pass) == batch.pass) return true;
        std::swap(waiting_, batch);
        prepare(batch);
        has_waiting_ = true;
        read_next_ = 0;
    }
    const auto tiles =
        static_cast<std::uint32_t>(config_.tiles.across) * static_cast<std::uint32_t>(config_.tiles.down);
    while (read_next_ < tiles && batch.quads.size() < kBatchQuads)
        append_reads(read_next_++, waiting_.pass, batch);
    if (!batch.quads.empty()) return true;
    std::swap(waiting_, batch);
    has_waiting_ = false;
    return true;
}

}  // namespace ropsim
