#include "model/front_end.h"

#include <algorithm>

namespace ropsim {

namespace {
constexpr std::uint64_t kFraction = 256;  // of a picosecond, so that fast cores do not round to nothing
}

FrontEnd::FrontEnd(EventWheel& wheel, const MachineConfig& config, BatchSource& source)
    : wheel_(wheel), config_(config), source_(source), exported_at_(config.shader_quads_in_flight, 0) {
    wheel_id_ = wheel.add(*this);
    wheel.arm(wheel_id_, 0);
}

bool FrontEnd::fetch() {
    while (batch_ == nullptr || next_quad_ == batch_->quads.size()) {
        batch_ = source_.next();
        next_quad_ = 0;
        if (batch_ == nullptr) return false;
        batch_->unfinished = batch_->quads.size();
        if (batch_->quads.empty()) source_.release(batch_);
    }
    return true;
}

// Launch time and readiness of the current quad. Copies and resolves come from the resolve engine: no shading.
void FrontEnd::launch() {
    const QuadOperation& q = quad();
    const std::uint64_t period = config_.shader_period_ps;
    // The window: this quad enters when the one shader_quads_in_flight before it has left.
    const Picoseconds room = exported_at_[exported_ % exported_at_.size()];
    if (q.kind == QuadKind::kCopy || q.kind == QuadKind::kResolve) {
        ready_ = room;
        return;
    }
    raster_free_ = std::max(raster_free_, room * kFraction) + period * kFraction / config_.raster_quads_per_cycle;
    if (q.kind == QuadKind::kCulled) {
        ready_ = raster_free_ / kFraction;
        return;
    }
    lanes_free_ = std::max(lanes_free_, raster_free_) +
                  q.shader_lane_cycles * period * kFraction / config_.shader_alu_lanes;
    lane_cycles_ += q.shader_lane_cycles;
    ready_ = lanes_free_ / kFraction + config_.shader_latency * period;
}

Picoseconds FrontEnd::step(Picoseconds now) {
    const Picoseconds period = config_.rop_period_ps;
    const std::uint64_t cycle = now / period;
    if (now % period != 0) return (cycle + 1) * period;
    account_.charge(cycle, waiting_label_);
    if (export_cycle_ != cycle) {
        export_cycle_ = cycle;
        exported_in_cycle_ = 0;
    }
    while (exported_in_cycle_ < config_.export_quads_per_cycle) {
        if (!fetch()) {
            finished_ = true;
            waiting_label_ = StageLabel::kIdle;
            for (RopPartition* p : partitions_) p->upstream_finished();
            break;
        }
        if (!launched_) {
            launch();
            launched_ = true;
        }
        if (ready_ > now) {
            waiting_label_ = StageLabel::kShading;
            break;
        }
        RopPartition& partition = *partitions_[quad().partition];
        if (!partition.has_room()) {
            waiting_label_ = StageLabel::kRopQueueFull;
            waiting_for_ = quad().partition;
            break;
        }
        partition.push(*batch_, static_cast<std::uint32_t>(next_quad_), now);
        exported_at_[exported_ % exported_at_.size()] = now;
        ++exported_;
        ++next_quad_;
        ++exported_in_cycle_;
        launched_ = false;
    }
    if (exported_in_cycle_ > 0) account_.charge(cycle + 1, StageLabel::kBusy);
    if (finished_) return kNever;
    if (waiting_for_ >= 0) return kNever;
    if (exported_in_cycle_ == config_.export_quads_per_cycle) return now + period;
    const Picoseconds aligned = (ready_ + period - 1) / period * period;
    return std::max(aligned, now + period);
}

void FrontEnd::partition_free(int partition) {
    if (partition != waiting_for_) return;
    waiting_for_ = -1;
    const Picoseconds period = config_.rop_period_ps;
    const Picoseconds now = wheel_.now();
    // A quad that left this cycle has used its turn; room freed now is seen in the next cycle.
    wheel_.arm(wheel_id_, (now / period + 1) * period);
}

double FrontEnd::alu_utilisation(Picoseconds total) const {
    if (total == 0) return 0;
    const double available = static_cast<double>(total) / static_cast<double>(config_.shader_period_ps) *
                             config_.shader_alu_lanes;
    return static_cast<double>(lane_cycles_) / available;
}

}  // namespace ropsim
