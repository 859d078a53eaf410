// Chunks of the trace: read, tested against the opaque layer, kept for later passes, and, without quads,
// sorted and run.
#include "base/parallel.h"
#include "model/frame.h"
#include "model/frame_chunk.h"
#include "model/frame_shard.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace ropsim {

namespace {

// Decoded fragments that are kept at most.
constexpr std::uint64_t kMostKeptBytes = std::uint64_t{640} << 20;

std::uint64_t kept_bytes(const TraceReader& trace) {
    const TraceHeader& header = trace.header();
    return trace.fragment_count() *
           (sizeof(Fragment) + sizeof(std::uint32_t) + (header.depth_slopes ? sizeof(DepthSlope) : 0) +
            (header.materials ? sizeof(Material) : 0));
}

// Whether a technique goes over the fragments more than once.
bool passes_again(const Declaration& declared) {
    int passes = 0;
    for (std::size_t p = 0; p < declared.passes.size(); ++p) {
        if (declared.passes[p].kind != PassKind::kGeometry) continue;
        const auto number = static_cast<int>(p);
        const bool repeated = number >= declared.repeat.first && number <= declared.repeat.last;
        passes += repeated ? declared.repeat.rounds : 1;
    }
    return passes > 1;
}

}  // namespace

void Frame::prepare_chunks() {
    for (auto& chunk : own_chunks_) chunk = std::make_unique<Chunk>();
    keeps_ = passes_again(operation_.declaration()) && kept_bytes(trace_) <= kMostKeptBytes;
    if (!quads_) bin_tiles();
}

bool Frame::keeps_chunks() const {
    return keeps_ && group_ == nullptr && source_ == nullptr && selected_.empty();
}

// Whether the pass takes other fragments than the trace's, or in another order.
bool Frame::alters_chunks() const {
    return !sequence_.current().draws.empty() || !operation_.declaration().joined_draws.empty();
}

void Frame::forget_chunks() {
    chunk_ = ahead_ = nullptr;
    ahead_state_ = Ahead::kUnknown;
    held_back_.clear();
    chunk_next_ = 0;
    next_kept_ = 0;
    if (!kept_all_) kept_.clear();
}

// The next fragments, their coverage cut down to what the opaque layer leaves to be seen.
bool Frame::read_visible(Chunk& chunk) {
    FragmentChunk& fragments = chunk.fragments;
    chunk.sorted = false;
    if (!(group_ != nullptr    ? read_group_chunk(fragments)
          : source_ != nullptr ? source_->next(fragments, fragment_channels(), pass_number())
                               : trace_.next(fragments, fragment_channels())))
        return false;
    chunk.outside = region_.whole() ? 0 : keep_region(fragments);
    for (std::size_t i = 0; i < fragments.size(); ++i) {
        const DepthSlope slope = fragments.slopes.empty() ? DepthSlope{} : fragments.slopes[i];
        Fragment& f = fragments.fragments[i];
        f.coverage = static_cast<std::uint16_t>(depth_test_.visible_samples(f, slope));
    }
    return true;
}

// Decoding and testing costs as much as operating: what is kept of the first pass is there for the others.
Frame::Chunk* Frame::next_chunk(Chunk& own) {
    if (!keeps_chunks()) return read_visible(own) ? &own : nullptr;
    if (!kept_all_) {
        auto chunk = std::make_unique<Chunk>();
        kept_all_ = !read_visible(*chunk);
        if (kept_all_) return nullptr;
        kept_.push_back(std::move(chunk));
    }
    if (next_kept_ == kept_.size()) return nullptr;
    Chunk& kept = *kept_[next_kept_++];
    if (!alters_chunks()) return &kept;
    own.fragments = kept.fragments;
    own.outside = kept.outside;
    own.sorted = false;
    return &own;
}

// The pass's next chunk; null at its end. `own`: where one that is not kept may lie.
Frame::Chunk* Frame::read_chunk(Chunk& own) {
    Chunk* chunk = next_chunk(own);
    if (chunk == nullptr) {
        if (held_back_.empty()) return nullptr;
        own.fragments = std::exchange(held_back_, {});
        own.sorted = false;
        return &own;
    }
    skipped_.outside_fragments += chunk->outside;
    FragmentChunk& fragments = chunk->fragments;
    if (!sequence_.current().draws.empty()) choose_fragments(fragments);
    // A material that does not scatter has a shader that does not ask what is behind it.
    for (std::size_t i = 0; i < fragments.materials.size(); ++i)
        scattering_ +=
            fragments.fragments[i].coverage != 0 && fragments.materials[i].collimation < 1.0f ? 1 : 0;
    if (!operation_.declaration().joined_draws.empty()) hold_back_run(fragments);
    return chunk;
}

// Without quads nothing has to wait for anything but its own pixels: while the partitions run a chunk, one
// thread decodes and sorts the next.
bool Frame::advance_whole_chunk() {
    if (ahead_state_ == Ahead::kUnknown) prepare_chunk();
    if (ahead_state_ == Ahead::kEnd) return false;
    chunk_ = ahead_;
    ahead_state_ = Ahead::kUnknown;
    const FragmentSpan span = chunk_->part(0, chunk_->fragments.size());
    const int first = threads_ > 1 ? 1 : 0;  // the longest piece is the first
    parallel_for(threads_, static_cast<int>(shards_.size()) + first, [&](int piece) {
        if (piece < first) return prepare_chunk();
        const auto p = static_cast<std::size_t>(piece - first);
        Shard& shard = *shards_[p];
        const std::span<const std::uint32_t> operated(&chunk_->operated[chunk_->first[p]],
                                                      chunk_->first[p + 1] - chunk_->first[p]);
        operation_.run(sequence_.pass(), sequence_.round(), span, operated, shard.store, shard.log);
    });
    return true;
}

void Frame::prepare_chunk() {
    // One thread needs one chunk at a time: always the same memory.
    Chunk& own = *own_chunks_[threads_ > 1 && chunk_ == own_chunks_[0].get() ? 1 : 0];
    do {
        ahead_ = read_chunk(own);
    } while (ahead_ != nullptr && ahead_->fragments.empty());
    ahead_state_ = ahead_ != nullptr ? Ahead::kReady : Ahead::kEnd;
    if (ahead_ == nullptr) return;
    if (!ahead_->sorted || low_scale_ > 1) sort_by_tile(*ahead_);
    count(ahead_->seen, ahead_->tests);
}

// A tile's fragments run one after the other: its pixels stay in the nearest cache meanwhile. Only nodes of a
// pool are taken in trace order throughout the partition.
void Frame::bin_tiles() {
    const std::size_t tiles = trace_.tile_fragments().size();
    const bool by_tile = operation_.declaration().node_words == 0;
    bin_of_tile_.resize(tiles);
    std::uint32_t bin = 0;
    for (int p = 0; p < map_.partitions(); ++p) {
        first_bin_.push_back(bin);
        for (std::size_t tile = 0; tile < tiles; ++tile)
            if (map_.partition_of(tile) == p) bin_of_tile_[tile] = by_tile ? bin++ : bin;
        bin += by_tile ? 0 : 1;
    }
    first_bin_.push_back(bin);
}

void Frame::sort_by_tile(Chunk& chunk) {
    const FragmentSpan span = chunk.part(0, chunk.fragments.size());
    const std::span<const Fragment> fragments = span.fragments;
    const Pass& pass = sequence_.current();
    const bool covers = first_pass() && pass.scale == 1;
    const bool drops_zero = operation_.declaration().zero_alpha_harmless && config_.skip.zero_alpha;
    const auto width = static_cast<std::size_t>(trace_.header().width);
    const HierarchicalDepth* ranges = depth_ranges(pass.scale);
    FragmentCounts seen;
    seen.input = fragments.size();
    DepthTests tests;
    const std::uint32_t none = first_bin_.back();
    bins_.assign(fragments.size(), none);
    bin_ends_.assign(std::size_t{none} + 1, 0);
    for (std::size_t i = 0; i < fragments.size(); ++i) {
        const Fragment& f = fragments[i];
        const DrawFacts& draw = draws_[f.draw];
        if (ranges != nullptr && draw.tested) {
            ++tests.tested;
            tests.read += ranges->decide(f, slope_of(span, i)) == kDepthUndecided ? 1 : 0;
        }
        if (covers && f.coverage != 0) covered_[f.y * width + f.x] = 1;
        if (draw.joined && joins_seen(fragments, i)) {
            ++seen.joined;
        } else if (f.coverage == 0) {
            ++seen.depth_culled;
        } else if (drops_zero && !draw.joined && is_zero(f)) {
            ++seen.zero_alpha;
        } else {
            const std::size_t tile = tile_of(f);
            if (low_scale_ > 1) (pass.scale > 1 ? drawn_low_ : drawn_)[tile] = 1;
            ++bin_ends_[bins_[i] = bin_of_tile_[tile]];
        }
    }
    std::exclusive_scan(bin_ends_.begin(), bin_ends_.end(), bin_ends_.begin(), 0u);
    seen.operated = bin_ends_[none];
    chunk.first.clear();
    for (const std::uint32_t bin : first_bin_) chunk.first.push_back(bin_ends_[bin]);
    chunk.operated.resize(seen.operated + 1);  // and a place for all that are not
    for (std::size_t i = 0; i < fragments.size(); ++i) {
        std::uint32_t& end = bin_ends_[bins_[i]];
        chunk.operated[end] = static_cast<std::uint32_t>(i);
        end += bins_[i] != none ? 1 : 0;
    }
    chunk.seen = seen;
    chunk.tests = tests;
    chunk.sorted = true;
}

}  // namespace ropsim
