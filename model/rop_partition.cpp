#include "model/rop_partition.h"

#include "model/front_end.h"

#include <algorithm>
#include <bit>

namespace ropsim {

namespace {
constexpr std::uint64_t kLongest = 1 << 20;  // cycles, far more than a quad's lines take through the tags
}  // namespace

RopPartition::RopPartition(const sc_core::sc_module_name& name, int number, EventWheel& wheel,
                           const MachineConfig& config, const SurfaceMap& map, BatchSource& source,
                           TrafficBreakdown& breakdown, std::unique_ptr<CompressedSurfaces> compressed)
    : sc_core::sc_module(name),
      port("port", wheel, *this, static_cast<int>(2 * config.mshrs + config.cache_request_queue)),
      config_(config),
      wheel_(wheel),
      source_(source),
      number_(number),
      worst_requests_((config.cache.line_bytes / config.cache.sector_bytes + 1) / 2),
      cache_(config.cache),
      compressed_(std::move(compressed)),
      leaving_(compressed_ != nullptr ? config.compression.eviction_buffer : 0),
      mshrs_(static_cast<int>(config.mshrs)),
      queue_(config.input_queue + config.crossbar_latency),
      requests_(config.cache_request_queue),
      fills_(config.cache_port_bytes == 0 ? 0 : 2 * config.mshrs + config.cache_request_queue),
      miss_port_(static_cast<std::size_t>(map.surfaces())),
      breakdown_(breakdown),
      read_latency_(miss_port_.size()),
      asked_(std::size_t{config.mshrs} << kSectorShift) {
    wheel_id_ = wheel.add(*this);
    map.prepare(cache_);
}

void RopPartition::push(QuadBatch& batch, std::uint32_t quad, Picoseconds now) {
    CHECK(has_room());
    const std::uint64_t arrival = now / config_.rop_period_ps + config_.crossbar_latency;
    queue_[(queue_head_ + queue_count_) % queue_.size()] = {&batch, quad, arrival};
    ++queue_count_;
    if (queue_count_ == 1) wheel_.arm(wheel_id_, std::max(arrival * config_.rop_period_ps, now));
}

void RopPartition::upstream_finished() {
    upstream_finished_ = true;
    wheel_.arm(wheel_id_, wheel_.now());
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
        operations_.charge(present, StageLabel::kFill);
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

// `cache.ports` lines of a quad a cycle. Lines that are here change nothing that anything else could see
// meanwhile, so a run of them is taken in one step with the time it would take; a line that is missing is
// taken in its own cycle.
std::uint64_t RopPartition::tag_stage(std::uint64_t cycle) {
    if (tag_free_ > cycle) return tag_free_;
    tags_.charge(cycle, tag_label_);
    if (still_blocked()) return kNever;
    if (!tagging_ && !admit(cycle, tag_label_))
        return tag_label_ == StageLabel::kIdle && queue_count_ > 0 ? queue_[queue_head_].arrival : kNever;
    Slot& slot = slots_[tag_tail_ % kMaxSlots];
    const QuadOperation& q = operation(slot);
    const LineAccess* lines = slot.batch->lines[q.partition].data() + q.first_line;
    // Present lines are taken in one go, though not past the next write, which also moves lines in the order
    // of replacement.
    const std::uint64_t quiet = std::min(cycles_without_write(cycle), kLongest) * config_.cache_ports;
    std::uint64_t looked_up = ports_used_;
    while (next_line_ < q.line_count && looked_up < quiet && hold_present_line(slot, lines[next_line_])) {
        ++next_line_;
        ++looked_up;
    }
    std::uint64_t cycles = config_.line_cycles(static_cast<std::uint32_t>(looked_up));
    ports_used_ = 0;
    if (next_line_ < q.line_count && looked_up < quiet) {
        if (config_.cache_ports > 1) {
            cycles = looked_up / config_.cache_ports;
            ports_used_ = static_cast<std::uint32_t>(looked_up % config_.cache_ports);
        }
        if (cycles == 0 && !check_lines(slot, cycle)) return kNever;
    }
    tag_free_ = cycle + std::max<std::uint64_t>(cycles, 1);
    tags_.charge(tag_free_, StageLabel::kBusy);
    last_cycle_ = std::max(last_cycle_, tag_free_);
    if (next_line_ >= q.line_count) {
        slot.tags_done = tag_free_;
        tagging_ = false;
        ++tag_tail_;
    }
    return tag_free_;
}

// The rest of a cycle whose next line is missing, one port after the other. False when it was all for
// nothing.
bool RopPartition::check_lines(Slot& slot, std::uint64_t cycle) {
    const QuadOperation& q = operation(slot);
    const LineAccess* lines = slot.batch->lines[q.partition].data() + q.first_line;
    std::uint32_t used = ports_used_;
    bool missing = true;  // the first is known to be
    for (; used < config_.cache_ports && next_line_ < q.line_count; ++used, ++next_line_, missing = false)
        if ((missing || !hold_present_line(slot, lines[next_line_])) &&
            !access_missing_line(slot, lines[next_line_], cycle, tag_label_))
            break;
    ports_used_ = 0;
    return used != 0;
}

// Whether what the tag stage waits for is still taken: most steps are for something else.
bool RopPartition::still_blocked() const {
    switch (tag_label_) {
        case StageLabel::kMshrsFull:
            return mshrs_.full();
        case StageLabel::kMetadata:
            return state_pending_;
        case StageLabel::kRequestQueue:
            return request_room() < 2 * worst_requests_ + kBlockRequests * (compressed_ != nullptr ? 1 : 0);
        default:
            return false;
    }
}

// Takes the next quad from the input queue into a slot, or says what it waits for.
bool RopPartition::admit(std::uint64_t cycle, StageLabel& reason) {
    reason = StageLabel::kIdle;
    if (queue_count_ == 0 || queue_[queue_head_].arrival > cycle) return false;
    reason = StageLabel::kSlotsFull;
    if (tag_tail_ - write_head_ >= config_.quads_in_flight) return false;
    const Queued queued = queue_[queue_head_];
    const QuadOperation& q = queued.batch->quads[queued.quad];
    if (exclusive_) return false;
    const std::size_t at = tag_tail_ % kMaxSlots;
    slots_[at].start(queued.batch, queued.quad);
    slot_quad_id_[at] = q.quad_id;
    slot_pixels_[at] = q.kind == QuadKind::kCopy ? 0 : q.pixels;
    next_line_ = 0;
    tagging_ = true;
    queue_head_ = (queue_head_ + 1) % static_cast<std::uint32_t>(queue_.size());
    --queue_count_;
    front_end_->partition_free(number_);
    return true;
}

// When the last issued quad on the same pixels is written; 0 when there is none in flight.
std::uint64_t RopPartition::last_conflict(std::uint64_t slot) const {
    const std::size_t own = slot % kMaxSlots;
    std::uint64_t written = 0;
    for (std::uint64_t i = write_head_; i < slot; ++i) {
        const std::size_t at = i % kMaxSlots;
        const std::uint32_t shared = config_.interlock_per_pixel ? slot_pixels_[at] & slot_pixels_[own]
                                                                 : slot_pixels_[at] * slot_pixels_[own];
        if (slot_quad_id_[at] == slot_quad_id_[own] && shared != 0)
            written = std::max(written, slots_[at].written);
    }
    return written;
}

void RopPartition::release_pins(Slot& slot) {
    for (const int line : slot.pinned) cache_.unpin(line);
    slot.pinned.clear();
}

void RopPartition::hold(Slot& slot, int line) {
    cache_.touch(line);
    cache_.pin(line);
    slot.pinned.push_back(line);
}

// From this cycle on, those in which no result can be written.
std::uint64_t RopPartition::cycles_without_write(std::uint64_t cycle) const {
    if (write_head_ < issue_head_)
        return std::max(slots_[write_head_ % kMaxSlots].written, cycle + 1) - cycle;
    if (issue_head_ == tag_tail_) return kNever;
    return std::max(config_.cache_hit_latency + operation(slots_[issue_head_ % kMaxSlots]).latency, 1u);
}

// A line whose sectors are all here: it stays until the quad is written.
bool RopPartition::hold_present_line(Slot& slot, const LineAccess& access) {
    const int line = cache_.probe(access.line_address, access.surface);
    if (line == RopCache::kMiss || (cache_.valid_sectors(line) & access.read_sectors) != access.read_sectors)
        return false;
    hold(slot, line);
    cache_.request_sectors(line, access.read_sectors);
    return true;
}

// A line that is missing, wholly or some sectors: asked for, and held. False, with the reason, when something
// it needs is taken.
bool RopPartition::access_missing_line(Slot& slot, const LineAccess& access, std::uint64_t cycle,
                                       StageLabel& reason) {
    int mshr = mshrs_.find(access.line_address);
    reason = StageLabel::kMshrsFull;
    if (access.read_sectors != 0 && mshr < 0 && mshrs_.full()) return false;
    reason = StageLabel::kRequestQueue;
    if (request_room() < 2 * worst_requests_ + kBlockRequests * (compressed_ != nullptr ? 1 : 0))
        return false;
    const ByteSource source = slot.batch->source(operation(slot));
    moved_for_ = source;
    if (compressed_ != nullptr && !look_up_state(access, reason)) return false;
    int line = cache_.probe(access.line_address, access.surface);
    reason = StageLabel::kEvictionBuffer;
    if (line == RopCache::kMiss && !can_write_back()) return false;
    if (access.read_sectors != 0 && leaving(access.line_address)) return false;
    reason = StageLabel::kCacheWays;
    if (line == RopCache::kMiss && !take_line(slot, access, cycle, line)) return false;
    hold(slot, line);
    std::uint32_t missing = cache_.request_sectors(line, access.read_sectors);
    // Nothing to wait for: cleared on chip, or written without being read.
    if ((missing | cache_.pending_sectors(line, access.read_sectors)) == 0) return true;
    if (mshr < 0) mshr = mshrs_.allocate(access.line_address, line);
    const bool block = missing != 0 && compressed_in_memory(access);
    if (block) missing |= cache_.request_rest(line);
    const auto number = static_cast<int>(tag_tail_ % kMaxSlots);
    if ((mshrs_[mshr].waiting >> number & 1u) == 0) ++slot.fills;
    mshrs_.add(mshr, missing, number);
    moved_for_ = source;
    MemoryRequest request{.write = false,
                          .surface = access.surface,
                          .cause = cause_of(operation(slot).kind),
                          .id = static_cast<std::uint32_t>(mshr)};
    if (block)
        queue_block_fill(access.line_address, request);
    else
        queue_requests(access.line_address, missing, request);
    return true;
}

// A line of the set for this address. When the quad's own lines hold every way and nothing else is in flight,
// waiting would be for ever: it gives them up (its operands are in the pipeline by then) and runs alone until
// written.
bool RopPartition::take_line(Slot& slot, const LineAccess& access, std::uint64_t cycle, int& line) {
    Eviction eviction;
    line = cache_.allocate(access.line_address, access.surface, &eviction, cycle);
    if (line == RopCache::kMiss && write_head_ == tag_tail_ && slot.fills == 0) {
        release_pins(slot);
        exclusive_ = true;
        line = cache_.allocate(access.line_address, access.surface, &eviction, cycle);
    }
    if (line == RopCache::kMiss) return false;
    queue_write(eviction, MemoryCause::kWriteBack);
    return true;
}

bool RopPartition::drained() const {
    return upstream_finished_ && queue_count_ == 0 && write_head_ == tag_tail_ && !tagging_ &&
           flush_line_ == cache_.line_count() && leaving_count_ == 0 && !flushing_metadata() &&
           request_count_ == 0 && port.in_flight() == 0;
}

void RopPartition::finish(std::uint64_t total_cycles) {
    CHECK(drained(), "partition {} stopped with {} queued, {} in flight, {} requests", number_, queue_count_,
          tag_tail_ - write_head_, request_count_);
    tags_.finish(total_cycles);
    operations_.finish(total_cycles);
    out_.finish(total_cycles);
    in_.finish(total_cycles);
}

}  // namespace ropsim
