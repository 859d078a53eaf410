#include "model/rop_partition.h"

#include <algorithm>
#include <bit>

namespace ropsim {

RopPartition::RopPartition(const sc_core::sc_module_name& name, int number, EventWheel& wheel,
                           const MachineConfig& config, const SurfaceMap& map, BatchSource& source,
                           TrafficBreakdown& breakdown, std::unique_ptr<CompressedSurfaces> compressed)
    : sc_core::sc_module(name),
      port("port", wheel, *this, static_cast<int>(2 * config.mshrs + config.cache_request_queue)),
      config_(config),
      wheel_(wheel),
      source_(source),
      number_(number),
      wheel_id_(wheel.add(*this)),
      input_(wheel, wheel_id_, number, config),
      worst_requests_((config.cache.line_bytes / config.cache.sector_bytes + 1) / 2),
      cache_(config.cache),
      compressed_(std::move(compressed)),
      leaving_(compressed_ != nullptr ? config.compression.eviction_buffer : 0),
      mshrs_(static_cast<int>(config.mshrs)),
      requests_(config.cache_request_queue),
      // As many as can be asked for: each miss register's sectors, one by one, and what leaving blocks and
      // the tag stage read.
      fills_(config.cache_port_bytes == 0
                 ? 0
                 : config.mshrs * (config.cache.line_bytes / config.cache.sector_bytes) +
                       2 * config.compression.eviction_buffer + 1),
      miss_port_(static_cast<std::size_t>(map.surfaces())),
      breakdown_(breakdown),
      read_latency_(miss_port_.size()),
      fill_cycles_(miss_port_.size()),
      asked_(std::size_t{config.mshrs} << kSectorShift) {
    map.prepare(cache_);
}

Picoseconds RopPartition::step(Picoseconds now) {
    const Picoseconds period = config_.rop_period_ps;
    const std::uint64_t cycle = now / period;
    if (now % period != 0) return (cycle + 1) * period;
    if (leaving_count_ != 0) write_leaving_blocks(cycle);
    if (fill_count_ != 0) take_fills(cycle);
    write_results(cycle);
    issue_operations();
    write_results(cycle);  // of operations that take no time
    std::uint64_t next = tag_stage(cycle);
    issue_operations();
    flush_line(cycle);
    if (compressed_ != nullptr) flush_metadata();
    send_request(cycle);
    if (write_head_ < issue_head_)
        next = std::min(next, std::max(slots_[write_head_ % kMaxSlots].written, cycle + 1));
    if (flushing_metadata() && request_room() > 0) next = std::min(next, cycle + 1);
    if (flushing() && can_write_back()) next = std::min(next, cycle + 1);
    if (leaving_count_ != 0) next = std::min(next, std::max(next_leaving_block(), cycle + 1));
    if (request_count_ > 0 && port.can_issue()) next = std::min(next, std::max(request_free_, cycle + 1));
    if (fill_count_ != 0) next = std::min(next, fills_[fill_head_].cycle);
    if (slice_ != nullptr && !told_slice_ && drained()) {
        told_slice_ = true;
        slice_->end_of_frame();
    }
    return next == kNever ? kNever : next * period;
}

// Results are written in order; a line that has left the cache meanwhile is taken anew, which may push
// another out.
void RopPartition::write_results(std::uint64_t cycle) {
    while (write_head_ < issue_head_) {
        Slot& slot = slots_[write_head_ % kMaxSlots];
        if (slot.written > cycle) return;
        const QuadOperation& q = operation(slot);
        const std::vector<LineAccess>& lines = slot.batch->lines[q.partition];
        // It takes its lines anew, one after the other: those it still holds must not fill the set.
        if (exclusive_) release_pins(slot);
        for (; written_lines_ < q.line_count; ++written_lines_) {
            const LineAccess& access = lines[q.first_line + written_lines_];
            if (!access.write_bytes.any()) continue;
            if (!write_line(access, slot.batch->source(q), cycle)) return;
            if (access.values != LineAccess::kNoValues)
                compressed_->memory.write(access.surface, access.line_address, access.write_bytes,
                                          &slot.batch->values[q.partition][access.values]);
        }
        written_lines_ = 0;
        release_pins(slot);
        exclusive_ = false;
        ++write_head_;
        ++quads_done_;
        last_cycle_ = std::max(last_cycle_, cycle + 1);
        if (--slot.batch->unfinished == 0) source_.release(slot.batch);
    }
}

bool RopPartition::write_line(const LineAccess& access, const ByteSource& source, std::uint64_t cycle) {
    int line = cache_.probe(access.line_address, access.surface);
    if (line == RopCache::kMiss) {
        if (!can_write_back()) return false;
        Eviction eviction;
        line = cache_.allocate(access.line_address, access.surface, &eviction, cycle);
        if (line == RopCache::kMiss) return false;
        queue_write(eviction, MemoryCause::kWriteBack);
    }
    cache_.touch(line);
    cache_.write(line, access.write_bytes, std::bit_cast<std::uint64_t>(source));
    return true;
}

// Operations issue in order as soon as their operands are known to be here: the time follows by reservation.
void RopPartition::issue_operations() {
    for (; issue_head_ < tag_tail_; ++issue_head_) {
        Slot& slot = slots_[issue_head_ % kMaxSlots];
        if (slot.fills > 0) return;
        const QuadOperation& q = operation(slot);
        const std::uint64_t present = std::max(slot.operands_ready, slot.tags_done);
        // Operands are read once nothing earlier on these pixels is still to be written.
        const std::uint64_t read = std::max(present, last_conflict(issue_head_));
        const std::uint64_t issue = std::max(read + config_.cache_hit_latency, units_free_);
        operations_.charge(slot.tags_done, StageLabel::kIdle);
        const std::uint64_t here = operations_.labelled();
        operations_.charge(present, StageLabel::kFill);
        fill_cycles_[slot.awaited] += operations_.labelled() - here;
        operations_.charge(read, StageLabel::kInterlock);
        operations_.charge(issue, StageLabel::kCacheRead);
        operations_.charge(issue + q.interval, StageLabel::kBusy);
        units_free_ = issue + q.interval;
        std::uint32_t written_lines = 0;
        for (std::uint32_t l = 0; l < q.line_count; ++l)
            written_lines += slot.batch->lines[q.partition][q.first_line + l].write_bytes.any() ? 1 : 0;
        slot.written = std::max(issue + q.latency, write_free_) + config_.line_cycles(written_lines);
        write_free_ = slot.written;
        last_cycle_ = std::max({last_cycle_, slot.written, units_free_});
    }
}

bool RopPartition::drained() const {
    return input_.finished() && input_.empty() && write_head_ == tag_tail_ && !tagging_ &&
           flush_line_ == cache_.line_count() && leaving_count_ == 0 && !flushing_metadata() &&
           request_count_ == 0 && port.in_flight() == 0;
}

void RopPartition::finish(std::uint64_t total_cycles) {
    CHECK(drained(), "partition {} stopped with {} queued, {} in flight, {} requests", number_, input_.size(),
          tag_tail_ - write_head_, request_count_);
    tags_.finish(total_cycles);
    operations_.finish(total_cycles);
    out_.finish(total_cycles);
    in_.finish(total_cycles);
}

}  // namespace ropsim
