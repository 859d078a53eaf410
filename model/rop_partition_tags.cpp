// A ROP partition's tag stage: quads from the input queue into slots, and their lines looked up, held and
// asked for.
#include "model/rop_partition.h"

#include <algorithm>
#include <bit>

namespace ropsim {

namespace {
constexpr std::uint64_t kLongest = 1 << 20;  // cycles, far more than a quad's lines take through the tags
}  // namespace

// `cache.ports` lines of a quad a cycle. Lines that are here change nothing that anything else could see
// meanwhile, so a run of them is taken in one step with the time it would take; a line that is missing is
// taken in its own cycle.
std::uint64_t RopPartition::tag_stage(std::uint64_t cycle) {
    if (tag_free_ > cycle) return tag_free_;
    tags_.charge(cycle, tag_label_);
    if (still_blocked()) return kNever;
    if (!tagging_ && !admit(cycle, tag_label_))
        return tag_label_ == StageLabel::kIdle && !input_.empty() ? input_.front().arrival : kNever;
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
    if (input_.empty() || input_.front().arrival > cycle) return false;
    reason = StageLabel::kSlotsFull;
    if (tag_tail_ - write_head_ >= config_.quads_in_flight) return false;
    const QueuedQuad queued = input_.front();
    const QuadOperation& q = queued.batch->quads[queued.quad];
    if (exclusive_) return false;
    const std::size_t at = tag_tail_ % kMaxSlots;
    slots_[at].start(queued.batch, queued.quad);
    slot_quad_id_[at] = q.quad_id;
    slot_pixels_[at] = q.kind == QuadKind::kCopy ? 0 : q.pixels;
    next_line_ = 0;
    tagging_ = true;
    input_.pop();
    return true;
}

// When the last issued quad on the same pixels is written; 0 when there is none in flight.
std::uint64_t RopPartition::last_conflict(std::uint64_t slot) const {
    const std::size_t own = slot % kMaxSlots;
    std::uint64_t written = 0;
    for (std::uint64_t i = write_head_; i < slot; ++i) {
        const std::size_t at = i % kMaxSlots;
        const std::uint32_t shared = config_.hazards.interlock == HazardConfig::Interlock::kPixel
                                         ? slot_pixels_[at] & slot_pixels_[own]
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
    state_known_ = kNoLine;  // used
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

}  // namespace ropsim
