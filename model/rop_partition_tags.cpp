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
std::uint64_t RopPartition::look_up_lines(std::uint64_t cycle) {
    tag_waits_ = true;
    if (!tagging_ && !admit(cycle, tag_label_))
        return tag_label_ == StageLabel::kIdle && !input_.empty() ? input_.front().arrival : kNever;
    Slot& s = slot(tag_tail_);
    const std::uint32_t count = s.quad->line_count;
    std::uint64_t cycles = 1;
    if (next_line_ < count) {
        Found found = find(s.lines[next_line_]);
        cycles = found.whole ? hold_present_lines(s, found, cycle) : 0;
        if (cycles == 0) {
            if (!check_lines(s, found.line, cycle)) return kNever;
            cycles = 1;
        }
    }
    tag_waits_ = false;
    tag_free_ = cycle + cycles;
    tags_.charge(tag_free_, StageLabel::kBusy);
    last_cycle_ = std::max(last_cycle_, tag_free_);
    if (next_line_ >= count) {
        s.tags_done = tag_free_;
        tagging_ = false;
        ++tag_tail_;
        issue_operations();
    } else if (mshrs_.full() && ports_used_ == 0 && needs_register(s.lines[next_line_])) {
        // As the next look-up would find, if no fill comes before it: it need not be made.
        tag_waits_ = true;
        tag_label_ = StageLabel::kMshrsFull;
        return kNever;
    }
    return tag_free_;
}

// The next line is whole: it and the whole ones after it are taken in one go, though not past the next write,
// which also moves lines in the order of replacement. Returns the cycles that takes, and in `found` where the
// line after them is; 0 when that one is missing and has ports left in this cycle.
inline std::uint64_t RopPartition::hold_present_lines(Slot& s, Found& found, std::uint64_t cycle) {
    const std::uint64_t quiet = std::min(cycles_without_write(cycle), kLongest) * config_.cache_ports;
    std::uint64_t looked_up = ports_used_;
    ports_used_ = 0;
    do {
        hold_present_line(s, s.lines[next_line_], found.line);
        ++looked_up;
        if (++next_line_ == s.quad->line_count || looked_up >= quiet) break;
        found = find(s.lines[next_line_]);
    } while (found.whole);
    if (found.whole || config_.cache_ports == 1)
        return config_.line_cycles(static_cast<std::uint32_t>(looked_up));
    ports_used_ = static_cast<std::uint32_t>(looked_up % config_.cache_ports);
    return looked_up / config_.cache_ports;
}

// The rest of a cycle whose next line is missing, or is not whole in `line`, one port after the other. False
// when it was all for nothing.
inline bool RopPartition::check_lines(Slot& s, int line, std::uint64_t cycle) {
    std::uint32_t used = ports_used_;
    ports_used_ = 0;
    Found found{line, false};
    while (true) {
        const LineAccess& access = s.lines[next_line_];
        if (found.whole)
            hold_present_line(s, access, found.line);
        else if (!access_missing_line(s, access, found.line, cycle, tag_label_))
            break;
        ++used;
        ++next_line_;
        if (used == config_.cache_ports || next_line_ == s.quad->line_count) break;
        found = find(s.lines[next_line_]);
    }
    return used != 0;
}

// Takes the next quad from the input queue into a slot, or says what it waits for.
inline bool RopPartition::admit(std::uint64_t cycle, StageLabel& reason) {
    reason = StageLabel::kIdle;
    if (input_.empty() || input_.front().arrival > cycle) return false;
    reason = StageLabel::kSlotsFull;
    if (tag_tail_ - write_head_ >= config_.quads_in_flight || exclusive_) return false;
    const QueuedQuad& queued = input_.front();
    const std::size_t at = tag_tail_ % kMaxSlots;
    slots_[at].start(queued.batch, queued.quad);
    const QuadOperation& q = *slots_[at].quad;
    slot_quad_id_[at] = q.quad_id;
    slot_pixels_[at] = q.kind == QuadKind::kCopy ? 0 : q.pixels;
    ++crowd_[crowd_of(q.quad_id)];
    next_line_ = 0;
    tagging_ = true;
    input_.pop();
    return true;
}

void RopPartition::release_pins(Slot& s) {
    for (const int line : s.held) cache_.unpin(line);
    s.held.clear();
}

inline void RopPartition::hold(Slot& s, int line, const LineAccess& access) {
    cache_.touch(line);
    cache_.pin(line);
    s.held.push_back(line);
    s.written_lines += access.write_sectors != 0 ? 1 : 0;
}

// From this cycle on, those in which no result can be written.
inline std::uint64_t RopPartition::cycles_without_write(std::uint64_t cycle) const {
    if (next_write_ != kNever) return std::max(next_write_, cycle + 1) - cycle;
    if (issue_head_ == tag_tail_) return kNever;
    return std::max(config_.cache_hit_latency + slot(issue_head_).quad->latency, 1u);
}

// A line whose sectors are all here: it stays until the quad is written.
inline void RopPartition::hold_present_line(Slot& s, const LineAccess& access, int line) {
    hold(s, line, access);
    cache_.request_sectors(line, access.read_sectors);
}

// A line that is missing, wholly (`line` is kMiss) or some sectors: asked for, and held. False, with the
// reason, when something it needs is taken.
inline bool RopPartition::access_missing_line(Slot& s, const LineAccess& access, int line,
                                              std::uint64_t cycle, StageLabel& reason) {
    const bool registered = line != RopCache::kMiss && cache_.pending_sectors(line, ~0u) != 0;
    reason = StageLabel::kMshrsFull;
    if (access.read_sectors != 0 && !registered && mshrs_.full()) return false;
    reason = StageLabel::kRequestQueue;
    if (!room_to_miss(cycle)) return false;
    if (compressed_ != nullptr) {
        moved_for_ = s.source();
        if (!look_up_state(access, reason)) return false;
    }
    reason = StageLabel::kEvictionBuffer;
    if (line == RopCache::kMiss && !can_write_back()) return false;
    if (leaving_count_ != 0 && access.read_sectors != 0 && leaving(access.line_address)) return false;
    reason = StageLabel::kCacheWays;
    if (line == RopCache::kMiss && !take_line(s, access, line)) {
        ways_changed_ = false;
        return false;
    }
    hold(s, line, access);
    state_known_ = kNoLine;  // used
    const std::uint32_t missing = cache_.request_sectors(line, access.read_sectors);
    // Else there is nothing to wait for: cleared on chip, or written without being read.
    if (missing != 0 || cache_.pending_sectors(line, access.read_sectors) != 0) {
        if (!registered)
            mshr_of_[static_cast<std::size_t>(line)] =
                static_cast<std::uint16_t>(mshrs_.allocate(access.line_address, line));
        ask_for(s, access, line, missing);
    }
    return true;
}

// The slot waits for the line's miss register; what is missing is asked for.
inline void RopPartition::ask_for(Slot& s, const LineAccess& access, int line, std::uint32_t missing) {
    const int mshr = mshr_of_[static_cast<std::size_t>(line)];
    const bool block = compressed_ != nullptr && missing != 0 && compressed_in_memory(access);
    if (block) missing |= cache_.request_rest(line);
    const auto number = static_cast<int>(tag_tail_ % kMaxSlots);
    if ((mshrs_[mshr].waiting >> number & 1u) == 0) ++s.fills;
    mshrs_.add(mshr, missing, number);
    moved_for_ = s.source();
    MemoryRequest request{.write = false,
                          .surface = access.surface,
                          .cause = cause_of(s.quad->kind),
                          .id = static_cast<std::uint32_t>(mshr)};
    if (block)
        queue_block_fill(access.line_address, request);
    else
        queue_requests(access.line_address, missing, request);
}

// A line of the set for this address. When the quad's own lines hold every way and nothing else is in flight,
// waiting would be for ever: it gives them up (its operands are in the pipeline by then) and runs alone until
// written.
inline bool RopPartition::take_line(Slot& s, const LineAccess& access, int& line) {
    Eviction eviction;
    line = cache_.allocate(access.line_address, access.surface, &eviction);
    if (line == RopCache::kMiss && write_head_ == tag_tail_ && s.fills == 0) {
        release_pins(s);
        exclusive_ = true;
        line = cache_.allocate(access.line_address, access.surface, &eviction);
    }
    if (line == RopCache::kMiss) return false;
    queue_write(eviction, MemoryCause::kWriteBack);
    return true;
}

}  // namespace ropsim
