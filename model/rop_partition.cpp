#include "model/rop_partition.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace ropsim {

RopPartition::RopPartition(const sc_core::sc_module_name& name, int number, EventWheel& wheel,
                           const MachineConfig& config, const SurfaceMap& map, BatchSource& source,
                           TrafficBreakdown& breakdown, std::unique_ptr<CompressedSurfaces> compressed)
    : sc_core::sc_module(name),
      port("port", wheel, *this, static_cast<int>(2 * config.mshrs + config.cache_request_queue)),
      config_(config),
      clock_(config.rop_period_ps),
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
      mshr_of_(static_cast<std::size_t>(cache_.line_count())),
      booked_(config.hazards.write_coalescing),
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
      fill_reads_(miss_port_.size()),
      asked_(std::size_t{config.mshrs} << kSectorShift) {
    map.prepare(cache_);
}

// Whether what the tag stage waits for is still taken.
inline bool RopPartition::still_blocked(std::uint64_t cycle) const {
    switch (tag_label_) {
        case StageLabel::kSlotsFull:
            return tag_tail_ - write_head_ >= config_.quads_in_flight;
        case StageLabel::kMshrsFull:
            return mshrs_.full();
        case StageLabel::kMetadata:
            return state_pending_;
        case StageLabel::kRequestQueue:
            return !room_to_miss(cycle);
        case StageLabel::kCacheWays:
            return !ways_changed_ && compressed_ == nullptr;
        default:
            return false;
    }
}

// Most steps are for something else.
inline std::uint64_t RopPartition::tag_stage(std::uint64_t cycle) {
    if (tag_free_ > cycle) return tag_free_;
    tags_.charge(cycle, tag_label_);
    return tag_waits_ && still_blocked(cycle) ? kNever : look_up_lines(cycle);
}

Picoseconds RopPartition::step(Picoseconds now) {
    const Picoseconds period = clock_.picoseconds();
    const std::uint64_t cycle = clock_.cycle_of(now);
    if (now != cycle * period) return (cycle + 1) * period;
    if (leaving_count_ != 0) write_leaving_blocks(cycle);
    if (fill_count_ != 0) take_fills(cycle);
    if (next_write_ <= cycle) write_results(cycle);
    std::uint64_t next = tag_stage(cycle);
    if (input_.finished()) end_of_frame(cycle);
    if (request_count_ != 0 && request_free_ <= cycle && port.can_issue()) send_request(cycle);
    if (next != cycle + 1) next = std::min(next, next_cycle(cycle));
    if (slice_ != nullptr && !told_slice_ && drained()) {
        told_slice_ = true;
        slice_->end_of_frame();
    }
    return next == kNever ? kNever : next * period;
}

// When anything but the tag stage has something to do.
inline std::uint64_t RopPartition::next_cycle(std::uint64_t cycle) const {
    std::uint64_t next = kNever;
    if (next_write_ != kNever && watches_writes()) next = std::max(next_write_, cycle + 1);
    if (sent_ == cycle && tag_waits_ && tag_label_ == StageLabel::kRequestQueue) next = cycle + 1;
    if (request_count_ > 0 && port.can_issue()) next = std::min(next, std::max(request_free_, cycle + 1));
    if (fill_count_ != 0) next = std::min(next, fills_[fill_head_].cycle);
    if (leaving_count_ != 0) next = std::min(next, std::max(next_leaving_block(), cycle + 1));
    if (input_.finished()) {
        if (flushing_metadata() && request_room() > 0) next = std::min(next, cycle + 1);
        if (flushing() && can_write_back()) next = std::min(next, cycle + 1);
    }
    return next;
}

// Results are written in order.
inline void RopPartition::write_results(std::uint64_t cycle) {
    for (; next_write_ <= cycle; expect_write()) {
        Slot& s = slot(write_head_);
        if (!exclusive_)
            write_held_lines(s);
        else if (!write_lines_anew(s))
            return;
        last_cycle_ = std::max(last_cycle_, (exclusive_ ? cycle : s.written) + 1);
        exclusive_ = false;
        ways_changed_ = true;
        --crowd_[crowd_of(s.quad->quad_id)];
        ++write_head_;
        ++quads_done_;
        if (--s.batch->unfinished == 0) source_.release(s.batch);
    }
}

inline void RopPartition::write_held_lines(Slot& s) {
    const std::uint32_t count = s.quad->line_count;
    const std::uint64_t writer = s.writer();
    for (std::uint32_t l = 0; l < count; ++l) {
        if (s.lines[l].write_sectors != 0) write(s, s.lines[l], s.held[l], writer);
        cache_.unpin(s.held[l]);
    }
    s.held.clear();
}

// A quad that gave up lines takes them anew, one after the other: those it still holds must not fill the set.
// Each may push another out; false when there is no room for that.
bool RopPartition::write_lines_anew(Slot& s) {
    release_pins(s);
    for (; written_lines_ < s.quad->line_count; ++written_lines_) {
        const LineAccess& access = s.lines[written_lines_];
        if (access.write_sectors == 0) continue;
        int line = cache_.probe(access.line_address, access.surface);
        if (line == RopCache::kMiss) {
            if (!can_write_back()) return false;
            Eviction eviction;
            line = cache_.allocate(access.line_address, access.surface, &eviction);
            if (line == RopCache::kMiss) return false;
            queue_write(eviction, MemoryCause::kWriteBack);
        }
        write(s, access, line, s.writer());
    }
    written_lines_ = 0;
    return true;
}

inline void RopPartition::write(const Slot& s, const LineAccess& access, int line, std::uint64_t writer) {
    cache_.touch(line);
    cache_.write(line, access.write_bytes, access.write_sectors, writer);
    if (access.values != LineAccess::kNoValues)
        compressed_->memory.write(access.surface, access.line_address, access.write_bytes,
                                  &s.batch->values[s.quad->partition][access.values]);
}

// The next quad in order, of whose fills the last has come.
void RopPartition::issue(Slot& s) {
    const std::uint64_t present = std::max(s.operands_ready, s.tags_done);
    const Operands o = operands(issue_head_, present);
    const std::uint64_t here = o.read + (o.from_cache ? config_.cache_hit_latency : 0);
    const std::uint64_t start = std::max({here, o.forwarded, units_free_});
    operations_.charge(s.tags_done, StageLabel::kIdle);
    const std::uint64_t idle_until = operations_.labelled();
    operations_.charge(present, StageLabel::kFill);
    fill_cycles_[s.awaited] += operations_.labelled() - idle_until;
    operations_.charge(std::max(o.read, o.forwarded), StageLabel::kInterlock);
    const std::uint64_t reading = operations_.labelled();
    operations_.charge(start, StageLabel::kCacheRead);
    if (std::max(o.read, o.forwarded) > present)
        interlock_reads_ += operations_.labelled() - reading;
    else if (s.operands_ready > s.tags_done)
        fill_reads_[s.awaited] += operations_.labelled() - reading;
    units_taken_ = start;
    operations_.charge(start + s.quad->interval, StageLabel::kBusy);
    units_free_ = start + s.quad->interval;
    s.result = start + s.quad->latency;
    s.written = booked_.empty() ? std::max(s.result, write_free_) + config_.line_cycles(s.written_lines)
                                : book_writes(s);
    write_free_ = s.written;
    last_cycle_ = std::max({last_cycle_, s.written, units_free_});
    if (issue_head_ == write_head_) next_write_ = s.written;
}

std::uint32_t RopPartition::slots_in_use() const {
    const std::uint64_t cycle = clock_.cycle_of(wheel_.now());
    std::uint64_t first = write_head_;
    if (!exclusive_)
        while (first < issue_head_ && slot(first).written <= cycle) ++first;
    return static_cast<std::uint32_t>(tag_tail_ - first) + (tagging_ ? 1 : 0);
}

// What the end of the frame leaves to do: the cache's dirty lines, then the states of blocks.
void RopPartition::end_of_frame(std::uint64_t cycle) {
    flush_line(cycle);
    if (compressed_ != nullptr) flush_metadata();
}

void RopPartition::replace_cache(RopCache cache) {
    bool held = compressed_ != nullptr;
    for (std::uint64_t i = write_head_; i < tag_tail_ + (tagging_ ? 1 : 0); ++i)
        held |= slot(i).quad->line_count != 0;
    CHECK(!held, "partition {}: the cache is in use", number_);
    cache_ = std::move(cache);
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
