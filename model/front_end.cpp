#include "model/front_end.h"

#include <algorithm>
#include <utility>

namespace ropsim {

namespace {
constexpr std::uint64_t kFraction = 256;  // of a picosecond, so that fast cores do not round to nothing
}

void FrontEnd::Lane::push(const Launched& launched) {
    if (count == ring.size()) {
        std::rotate(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(head), ring.end());
        head = 0;
        ring.resize(std::max<std::size_t>(64, 2 * ring.size()));
    }
    ring[(head + count) & (ring.size() - 1)] = launched;
    ++count;
}

void FrontEnd::Lane::pop() {
    head = (head + 1) & (ring.size() - 1);
    --count;
}

FrontEnd::FrontEnd(EventWheel& wheel, const MachineConfig& config, BatchSource& source,
                   std::uint64_t depth_bytes)
    : wheel_(wheel), config_(config), source_(source), depth_bytes_(depth_bytes) {
    wheel_id_ = wheel.add(*this);
    wheel.arm(wheel_id_, 0);
}

void FrontEnd::connect(std::vector<PartitionInput*> partitions) {
    for (PartitionInput* p : partitions) p->connect(*this);
    partitions_ = std::move(partitions);
    lanes_.resize(partitions_.size());
}

bool FrontEnd::fetch() {
    while (!source_ended_ && batch_ == nullptr) {
        batch_ = source_.next();
        next_quad_ = 0;
        if (batch_ == nullptr) {
            source_ended_ = true;
            break;
        }
        batch_->unfinished = batch_->quads.size();
        if (batch_->quads.empty()) source_.release(std::exchange(batch_, nullptr));
    }
    return !source_ended_;
}

void FrontEnd::fill_window(Picoseconds now) {
    while (in_window_ < config_.shader_quads_in_flight && fetch()) {
        const std::size_t quads = batch_->quads.size();
        const QuadOperation& quad = batch_->quads[next_quad_];
        counts_.rasterise(quad, depth_bytes_);
        const Picoseconds ready = shaded(quad, now);
        if (reaches_partition(quad)) {
            lanes_[quad.partition].push({batch_, static_cast<std::uint32_t>(next_quad_), ready});
            ++in_window_;
        } else if (--batch_->unfinished == 0) {
            source_.release(batch_);  // nothing of it is seen, and all before it are written
        }
        // The batch is its quads' from here on.
        if (++next_quad_ == quads) batch_ = nullptr;
    }
}

// When a quad launched now is ready to leave. Copies and resolves come from the resolve engine: no shading.
Picoseconds FrontEnd::shaded(const QuadOperation& quad, Picoseconds now) {
    if (quad.kind == QuadKind::kCopy || quad.kind == QuadKind::kResolve) return now;
    const std::uint64_t period = config_.shader_period_ps * kFraction;
    raster_free_ = std::max(raster_free_, now * kFraction) + period / config_.raster_quads_per_cycle;
    if (quad.kind == QuadKind::kCulled) return raster_free_ / kFraction;
    lanes_free_ =
        std::max(lanes_free_, raster_free_) + quad.shader_lane_cycles * period / config_.shader_alu_lanes;
    lane_cycles_ += quad.shader_lane_cycles;
    return lanes_free_ / kFraction + config_.shader_latency * config_.shader_period_ps;
}

Picoseconds FrontEnd::step(Picoseconds now) {
    const Picoseconds period = config_.rop_period_ps;
    if (now % period != 0) return (now / period + 1) * period;
    // Woken again in a cycle that has exported: its turn is used.
    if (account_.labelled() > now / period) return now + period;
    account_.charge(now / period, label_);
    fill_window(now);
    const std::uint32_t exported = export_quads(now);
    if (exported > 0) account_.charge(now / period + 1, StageLabel::kBusy);
    return next_step(now, exported);
}

// Up to export_quads_per_cycle, at most one a partition, partitions taking turns.
std::uint32_t FrontEnd::export_quads(Picoseconds now) {
    std::uint32_t exported = 0;
    for (std::size_t i = 0; i < lanes_.size() && exported < config_.export_quads_per_cycle; ++i) {
        const std::size_t p = (turn_ + i) % lanes_.size();
        Lane& lane = lanes_[p];
        if (lane.count == 0 || lane.front().ready > now) continue;
        lane.waiting = !partitions_[p]->has_room();
        if (lane.waiting) continue;
        partitions_[p]->push(*lane.front().batch, lane.front().quad, now);
        lane.pop();
        ++exported;
    }
    // Only where something left: an idle step, which comes and goes with events elsewhere, must not turn the
    // order.
    if (exported > 0) turn_ = (turn_ + 1) % lanes_.size();
    in_window_ -= exported;
    exported_ += exported;
    return exported;
}

Picoseconds FrontEnd::next_step(Picoseconds now, std::uint32_t exported) {
    const Picoseconds period = config_.rop_period_ps;
    Picoseconds earliest = kNever;
    bool blocked = false;
    for (const Lane& lane : lanes_) {
        if (lane.count == 0) continue;
        if (lane.waiting && lane.front().ready <= now)
            blocked = true;
        else
            earliest = std::min(earliest, std::max(lane.front().ready, now + period));
    }
    if (exported > 0 && !source_ended_) earliest = now + period;  // the window has room
    label_ = blocked ? StageLabel::kRopQueueFull : in_window_ > 0 ? StageLabel::kShading : StageLabel::kIdle;
    if (source_ended_ && in_window_ == 0 && !told_end_) {
        // The last quads may have been rejected: the rasteriser has found them all the same.
        if (raster_free_ / kFraction > now) return (raster_free_ / kFraction + period - 1) / period * period;
        told_end_ = true;
        for (PartitionInput* p : partitions_) p->finish();
    }
    return earliest == kNever ? kNever : (earliest + period - 1) / period * period;
}

void FrontEnd::partition_free(int partition) {
    Lane& lane = lanes_[static_cast<std::size_t>(partition)];
    if (!lane.waiting) return;
    lane.waiting = false;
    // Room made in this cycle is seen in the next.
    const Picoseconds period = config_.rop_period_ps;
    wheel_.arm(wheel_id_, (wheel_.now() / period + 1) * period);
}

double FrontEnd::alu_utilisation(Picoseconds total) const {
    if (total == 0) return 0;
    const double available =
        static_cast<double>(total) / static_cast<double>(config_.shader_period_ps) * config_.shader_alu_lanes;
    return static_cast<double>(lane_cycles_) / available;
}

}  // namespace ropsim
