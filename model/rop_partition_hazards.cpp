// A ROP partition's hazards: what an operation waits for and takes from earlier ones on the same pixels, and
// results that are written together.
#include "model/rop_partition.h"

#include <algorithm>

namespace ropsim {

// Between two slots in flight.
bool RopPartition::conflict(std::size_t older, std::size_t younger) const {
    const std::uint32_t a = slot_quad_id_[older];
    const std::uint32_t b = slot_quad_id_[younger];
    const std::uint32_t pixels = slot_pixels_[older];
    switch (config_.hazards.interlock) {
        case HazardConfig::Interlock::kPixel:
            return a == b && (pixels & slot_pixels_[younger]) != 0;
        case HazardConfig::Interlock::kQuad:
            return a == b && pixels * slot_pixels_[younger] != 0;
        case HazardConfig::Interlock::kTile:
            return a / 16 == b / 16 && pixels * slot_pixels_[younger] != 0;
    }
    return false;
}

// Operands are read once nothing earlier on these pixels is still to be written, or, with forwarding, taken
// from the results on the same quad that are not.
RopPartition::Operands RopPartition::operands(std::uint64_t number, std::uint64_t present) const {
    Operands o{present, 0, true};
    const std::size_t own = number % kMaxSlots;
    if (crowd_[crowd_of(slot_quad_id_[own])] == 1) return o;
    const bool forwards = config_.hazards.forward_results;
    bool results = false;
    for (std::uint64_t i = write_head_; i < number; ++i) {
        const std::size_t at = i % kMaxSlots;
        if (!conflict(at, own)) continue;
        if (forwards && slot_quad_id_[at] == slot_quad_id_[own])
            results = true;
        else
            o.read = std::max(o.read, slots_[at].written);
    }
    if (results) take_results(number, o);
    return o;
}

// Results in flight when the operands would be read. A line comes from the cache as well unless one of them
// holds all that is read of it.
void RopPartition::take_results(std::uint64_t number, Operands& o) const {
    const std::size_t own = number % kMaxSlots;
    std::uint64_t first = number;
    for (std::uint64_t i = write_head_; i < number; ++i) {
        const std::size_t at = i % kMaxSlots;
        if (slot_quad_id_[at] != slot_quad_id_[own] || !conflict(at, own) || slots_[at].written <= o.read)
            continue;
        first = std::min(first, i);
        o.forwarded = std::max(o.forwarded, slots_[at].result);
    }
    if (first == number) return;
    const Slot& s = slot(number);
    o.from_cache = false;
    for (std::uint32_t l = 0; l < s.quad->line_count && !o.from_cache; ++l)
        o.from_cache = s.lines[l].read_sectors != 0 && !forwarded(s, s.lines[l], first, number, o.read);
}

// Whether one of the slots [from, to) forwards all that `s` reads of a line: it operates on all pixels of
// `s`, writes the line, and has read or written those sectors.
bool RopPartition::forwarded(const Slot& s, const LineAccess& wanted, std::uint64_t from, std::uint64_t to,
                             std::uint64_t read) const {
    for (std::uint64_t i = from; i < to; ++i) {
        const Slot& older = slot(i);
        if (older.quad->quad_id != s.quad->quad_id || older.quad->kind == QuadKind::kCopy ||
            (s.quad->pixels & ~older.quad->pixels) != 0 || older.written <= read)
            continue;
        for (std::uint32_t l = 0; l < older.quad->line_count; ++l) {
            const LineAccess& has = older.lines[l];
            if (has.line_address != wanted.line_address || has.surface != wanted.surface) continue;
            const std::uint32_t written = has.write_sectors;
            if (written != 0 && (wanted.read_sectors & ~(has.read_sectors | written)) == 0) return true;
        }
    }
    return false;
}

// Books the lines of a result at the cache's write port and returns when the last is written. Results enter
// the write queue in order; a line that still waits there, one of the last `write_coalescing` booked, takes a
// later result for it along.
std::uint64_t RopPartition::book_writes(const Slot& s) {
    results_entered_ = std::max(results_entered_, s.result);
    const std::uint64_t start = std::max(s.result, write_free_);
    std::uint64_t written = start;
    std::uint32_t own = 0;
    for (std::uint32_t l = 0; l < s.quad->line_count; ++l) {
        const LineAccess& access = s.lines[l];
        if (access.write_sectors == 0) continue;
        const auto joined = std::ranges::find_if(booked_, [&](const BookedWrite& b) {
            return b.cycle >= results_entered_ && b.cycle != 0 && b.line_address == access.line_address &&
                   b.surface == access.surface;
        });
        if (joined != booked_.end()) {
            ++writes_saved_;
            written = std::max(written, joined->cycle + 1);
            continue;
        }
        const std::uint64_t cycle = start + own++ / config_.cache_ports;
        booked_[writes_booked_++ % booked_.size()] = {access.line_address, cycle, access.surface};
        written = std::max(written, cycle + 1);
    }
    return written;
}

}  // namespace ropsim
