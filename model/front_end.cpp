#include "model/front_end.h"

#include "model/read_cache.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace ropsim {

void FrontEnd::Lane::grow() {
    std::rotate(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(head), ring.end());
    head = 0;
    ring.resize(std::max<std::size_t>(64, 2 * ring.size()));
    places = ring.size();
}

FrontEnd::FrontEnd(EventWheel& wheel, const MachineConfig& config, BatchSource& source,
                   std::uint64_t depth_bytes)
    : wheel_(wheel),
      config_(config),
      clock_(config.rop_period_ps),
      source_(source),
      quad_time_(config.shader_period_ps * kTimeFraction / config.raster_quads_per_cycle),
      tile_time_(config.shader_period_ps * kTimeFraction / config.front.raster_tiles_per_cycle),
      timeout_(config.shader_period_ps * kTimeFraction * config.front.shader.pack_timeout),
      packing_(config),
      packers_(packing_.warps()),
      cores_(config),
      depth_bytes_(depth_bytes) {
    wheel_id_ = wheel.add(*this);
    wheel.arm(wheel_id_, 0);
}

void FrontEnd::connect(std::vector<PartitionInput*> partitions) {
    for (PartitionInput* p : partitions) p->connect(*this);
    partitions_ = std::move(partitions);
    lanes_.resize(partitions_.size());
    head_ready_.assign(partitions_.size(), kNever);
}

void FrontEnd::connect_caches(std::vector<ReadCache*> depth_units, std::vector<ReadCache*> texture_caches,
                              int texture_surface) {
    depth_units_ = std::move(depth_units);
    texture_caches_ = std::move(texture_caches);
    texture_surface_ = texture_surface;
    fetching_.resize(texture_caches_.size());
}

Picoseconds FrontEnd::step(Picoseconds now) {
    const Picoseconds period = clock_.picoseconds();
    const std::uint64_t cycle = clock_.cycle_of(now);
    if (now != cycle * period) return (cycle + 1) * period;
    // Woken again in a cycle that has exported: its turn is used.
    if (account_.labelled() > cycle) return now + period;
    account_.charge(cycle, label_);
    rasteriser_.charge(cycle, raster_label_);
    take_in(now);
    rasteriser_.charge(clock_.cycle_of(raster_free_ / kTimeFraction), StageLabel::kBusy);
    const std::uint32_t exported = export_quads(now);
    if (exported > 0) account_.charge(cycle + 1, StageLabel::kBusy);
    return next_step(now, exported);
}

bool FrontEnd::fetch() {
    while (!source_ended_ && batch_ == nullptr) {
        batch_ = source_.next();
        next_quad_ = 0;
        if (batch_ == nullptr) {
            source_ended_ = true;
            break;
        }
        batch_->unfinished = batch_quads_ = batch_->quads.size();
        if (batch_quads_ == 0) source_.release(std::exchange(batch_, nullptr));
    }
    return !source_ended_;
}

void FrontEnd::finish_quad(QuadBatch& batch) {
    if (--batch.unfinished == 0) source_.release(&batch);
}

// Where one pass reads what another wrote, an API demands that nothing of the other is left; likewise where
// surfaces are restored before a further round.
bool FrontEnd::at_barrier() {
    const int pass = 2 * batch_->pass + (batch_->quads[next_quad_].kind == QuadKind::kCopy ? 1 : 0);
    if (pass == pass_) return false;
    if (in_window_ + held_ > 0) return true;
    pass_ = pass;
    return false;
}

void FrontEnd::quad_done(std::uint32_t warp) {
    --held_;
    if (warp != kNoWarp) leave_warp(warp);
    if (!source_ended_ || in_window_ > 0) wheel_.arm(wheel_id_, next_edge());
}

// Rasterises what the window has room for, packs what is known to be seen, and closes a warp that has waited
// long enough.
[[gnu::always_inline]] inline void FrontEnd::take_in(Picoseconds now) {
    // Mostly there is nothing to do for some of these.
    if (!order_.empty()) settle_depths(now);
    while (window_has_room() && (batch_ != nullptr || fetch())) {
        if (holds_ && at_barrier()) {
            for (Packer& packer : packers_)
                if (packer.open.quads > 0) close_warp(packer, last_packed_);
            break;
        }
        take_quad(now);
    }
    raster_label_ = source_ended_ ? StageLabel::kIdle : StageLabel::kSlotsFull;
    if (source_ended_ || first_deadline_ <= now * kTimeFraction) close_warps(now);
    if (!answered_.empty()) take_texels(now);
    if (!closed_.empty() && cores_.has_room()) launch_warps(now);
}

// Rasterises the next quad.
[[gnu::always_inline]] inline void FrontEnd::take_quad(Picoseconds now) {
    QuadBatch& batch = *batch_;
    const auto number = static_cast<std::uint32_t>(next_quad_);
    const QuadOperation& quad = batch.quads[number];
    // The batch is its quads' from its last one on.
    if (++next_quad_ == batch_quads_) batch_ = nullptr;
    counts_.rasterise(quad, depth_bytes_);
    const std::uint64_t time = rasterise(quad, now);
    if (quad.depth_lines == 0 && !reaches_partition(quad))
        return finish_quad(batch);  // nothing of it is seen
    ++in_window_;
    if (quad.depth_lines != 0) read_depths(batch, quad, time / kTimeFraction);
    if (quad.depth_lines != 0 || !order_.empty())
        order_.push_back({&batch, number, time});
    else
        pack({&batch, number, time}, now);
}

void FrontEnd::read_depths(const QuadBatch& batch, const QuadOperation& quad, Picoseconds time) {
    CHECK(!depth_units_.empty(), "depth.test is early and nobody has connected depth units");
    ReadCache& unit = *depth_units_[quad.partition];
    const LineAccess* line = batch.lines[quad.partition].data() + quad.first_line - quad.depth_lines;
    for (std::uint32_t l = 0; l < quad.depth_lines; ++l, ++line)
        unit.add_line({line->line_address, line->read_sectors, line->surface});
    unit.push(batch.source(quad), time);
}

// In raster order, as far as depths are known: what is behind ends here, the rest is packed.
void FrontEnd::settle_depths(Picoseconds now) {
    for (; !order_.empty(); order_.pop_front()) {
        Rastered& first = order_.front();
        const QuadOperation& quad = first.batch->quads[first.quad];
        if (quad.depth_lines != 0) {
            ReadCache& unit = *depth_units_[quad.partition];
            if (unit.first_known() > now) return;
            unit.take();
            first.time = std::max(first.time, now * kTimeFraction);
        }
        if (reaches_partition(quad)) {
            pack(first, now);
        } else {
            --in_window_;
            finish_quad(*first.batch);
        }
    }
}

// When the quad is rasterised. Copies and resolves of the resolve engine come from elsewhere.
[[gnu::always_inline]] inline std::uint64_t FrontEnd::rasterise(const QuadOperation& quad, Picoseconds now) {
    const std::uint64_t earliest = now * kTimeFraction;
    if (!quad.is_shaded()) return earliest;
    raster_free_ = std::max(raster_free_, earliest) + quad_time_;
    // Without a branch: whether a tile is new is as good as random.
    const std::uint64_t tile_done = std::max(tiles_free_, earliest) + tile_time_;
    tiles_free_ = quad.new_tile ? tile_done : tiles_free_;
    raster_free_ = std::max(raster_free_, tiles_free_);
    return raster_free_;
}

void FrontEnd::await_head(std::size_t partition, Picoseconds time) {
    head_ready_[partition] = time;
    next_head_ = std::min(next_head_, time);
}

// Without a branch a partition: which heads are due is as good as random.
void FrontEnd::take_due_heads(Picoseconds now) {
    next_head_ = kNever;
    for (std::size_t p = 0; p < head_ready_.size(); ++p) {
        const bool due = head_ready_[p] <= now;
        ready_ |= static_cast<std::uint64_t>(due) << p;
        head_ready_[p] = due ? kNever : head_ready_[p];
        next_head_ = std::min(next_head_, head_ready_[p]);
    }
}

// Up to export_quads_per_cycle, at most one a partition, partitions taking turns.
[[gnu::always_inline]] inline std::uint32_t FrontEnd::export_quads(Picoseconds now) {
    if (next_head_ <= now) take_due_heads(now);
    std::uint32_t exported = 0;
    follows_ = false;
    std::uint64_t left = ready_;
    while (left != 0 && exported < config_.export_quads_per_cycle) {
        const std::uint64_t from_turn = left >> turn_ << turn_;
        const auto p = static_cast<std::size_t>(std::countr_zero(from_turn != 0 ? from_turn : left));
        const std::uint64_t bit = std::uint64_t{1} << p;
        left ^= bit;
        ready_ ^= bit;
        PartitionInput& input = *partitions_[p];
        if (!input.has_room()) {
            waiting_ |= bit;
            continue;
        }
        Lane& lane = lanes_[p];
        const Launched first = lane.front();
        input.push(*first.batch, first.quad, first.warp, now);
        lane.pop();
        if (first.warp != kNoWarp && !holds_) leave_warp(first.warp);
        ++exported;
        if (const Picoseconds next = head_time(p); next > now) {
            await_head(p, next);
        } else {
            // Without a branch: whether there is still room is as good as random.
            (input.has_room() ? ready_ : waiting_) |= bit;
            follows_ = true;
        }
    }
    // Only where something left: an idle step, which comes and goes with events elsewhere, must not turn the
    // order.
    if (exported > 0) turn_ = turn_ + 1 == lanes_.size() ? 0 : turn_ + 1;
    in_window_ -= exported;
    if (holds_) held_ += exported;
    exported_ += exported;
    return exported;
}

void FrontEnd::free_warp(std::uint32_t number) {
    cores_.leave(warps_[number].core);
    free_warps_.push_back(number);
    place_freed_ = true;
}

[[gnu::always_inline]] inline Picoseconds FrontEnd::next_step(Picoseconds now, std::uint32_t exported) {
    const Picoseconds period = clock_.picoseconds();
    const bool freed = std::exchange(place_freed_, false);
    // Or the window, or every place in a core, is full of quads that others keep.
    const bool full = !window_has_room() || !cores_.has_room();
    const bool held_up = waiting_ != 0 || (held_ > in_window_ && full);
    label_ = held_up ? StageLabel::kRopQueueFull : in_window_ > 0 ? StageLabel::kShading : StageLabel::kIdle;
    if (source_ended_ && in_window_ == 0 && !told_end_) {
        // The last quads may have been rejected: the rasteriser has found them all the same.
        if (raster_free_ / kTimeFraction > now) return edge(raster_free_);
        told_end_ = true;
        for (PartitionInput* p : partitions_) p->finish();
    }
    // The window has room, or a warp finds its place.
    if ((exported > 0 && !source_ended_) || (freed && !closed_.empty())) return now + period;
    if (ready_ != 0 || follows_) return now + period;
    Picoseconds earliest = next_head_;
    const Picoseconds wanted = core_wants();
    for (const Packer& packer : packers_)
        if (packer.open.quads > 0)
            earliest = std::min(earliest, std::max({packer.deadline / kTimeFraction, wanted, now + 1}));
    if (!order_.empty())
        earliest =
            std::min(earliest,
                     depth_units_[order_.front().batch->quads[order_.front().quad].partition]->first_known());
    for (const std::uint32_t core : answered_)
        earliest = std::min(earliest, texture_caches_[core]->first_known());
    return earliest == kNever ? kNever : clock_.cycle_from(earliest) * period;
}

void FrontEnd::reads_known(int unit, Picoseconds time) {
    const auto number = static_cast<std::size_t>(unit);
    if (number >= partitions_.size()) {
        answered_.push_back(static_cast<std::uint32_t>(number - partitions_.size()));
    } else {
        const Rastered& first = order_.front();
        if (first.batch->quads[first.quad].partition != number) return;  // waits for another
    }
    wheel_.arm(wheel_id_, std::max(time, wheel_.now()));
}

void FrontEnd::partition_free(int partition) {
    const std::uint64_t bit = std::uint64_t{1} << partition;
    if ((waiting_ & bit) == 0) return;
    waiting_ &= ~bit;
    ready_ |= bit;
    wheel_.arm(wheel_id_, next_edge());
}

}  // namespace ropsim
