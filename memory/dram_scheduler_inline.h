// What several of the scheduler's sources inline.
#pragma once

#include "memory/dram_scheduler.h"

#include <algorithm>

namespace ropsim {

// Surely no reason to turn, whatever the time: the common cases of reconsider_direction().
inline bool DramScheduler::settled(const Queues& q) const {
    const std::uint32_t reads = q.count[kReads];
    const std::uint32_t writes = q.count[kWrites];
    if (q.direction == kReads) {
        if (writes == 0) return true;
        const bool enough = writes >= config_.write_high || q.write_queue_short;
        return reads != 0 && (!enough || (q.batch != 0 && reads_in_batches_)) && q.hurried == 0;
    }
    if (writes > (q.forced_drain ? config_.write_low : config_.write_idle_low))
        return q.batch != 0 || drains_to_low_;
    return reads == 0 && writes != 0 && !snapshot_;
}

inline bool DramScheduler::update_direction(Queues& queues, DramCycle now) {
    queues.unsettled = !settled(queues);
    return queues.unsettled && reconsider_direction(queues, now);
}

inline bool DramScheduler::before(const Best& a, const Best& b) {
    // No branch: which is first is as good as random.
    return (static_cast<int>(a.time < b.time) |
            (static_cast<int>(a.time == b.time) & static_cast<int>(a.order < b.order))) != 0;
}

// Of the two kinds; in order, the older goes first though it may have to wait.
template <bool kUsual>
inline const DramScheduler::Best& DramScheduler::first_of(const Pseudochannel& pc) const {
    const Best& columns = pc.best[kColumns];
    const Best& rows = pc.best[kRows];
    if (!kUsual && in_order_ && columns.time != kNoCycle && rows.time != kNoCycle)
        return rows.order < columns.order ? rows : columns;
    return pc.best[before(rows, columns) ? kRows : kColumns];
}

// Of the commands.
template <bool kUsual>
inline DramCycle DramScheduler::first_time() const {
    if constexpr (kUsual)
        return std::min(pseudochannels_[0].best[kColumns].time, pseudochannels_[0].best[kRows].time);
    DramCycle first = kNoCycle;
    for (const Pseudochannel& pc : pseudochannels_) first = std::min(first, first_of<false>(pc).time);
    return first;
}

// Sets next_; `first` is first_time().
template <bool kUsual>
inline void DramScheduler::plan(DramCycle now, DramCycle first) {
    if (idle()) {
        next_ = kNoCycle;
        return;
    }
    DramCycle next = std::min(next_due_, first);
    const auto with_drain = [&](const Queues& q) {
        if (q.unsettled && q.count[kReads] == 0 && q.direction == kReads && q.count[kWrites] != 0)
            next = std::min(next, drain_time(q));
    };
    if constexpr (kUsual)
        with_drain(queues_[0]);
    else if (mixed_)
        next = std::min(next, next_move(now));
    else
        for (const Queues& q : queues_) with_drain(q);
    next_ = std::max(next, now);
}

inline void DramScheduler::set_candidate(std::size_t lane, std::uint32_t bank, DramCommand command,
                                         std::uint16_t slot, std::uint64_t order, DramCycle time,
                                         Class order_class) {
    candidate_[lane][bank] = {slot, command};
    // Only PRE is not bound by rules between banks.
    keys_[lane].set(
        bank, time, lane != kRowLane || command != DramCommand::kPrecharge,
        order + ((static_cast<std::uint64_t>(order_class) << kClassShift) + (lane << kLaneShift)));
}

// Lanes of columns are named like their command.
inline void DramScheduler::add_column_candidate(std::uint32_t bank, std::uint16_t slot, Class order_class) {
    const Access& access = access_[slot];
    const std::size_t lane = access.write ? kWriteLane : kReadLane;
    const auto command = static_cast<DramCommand>(lane);
    set_candidate(lane, bank, command, slot, access.order,
                  std::max(banks_.bank_time(command, bank), access.ready), order_class);
}

inline void DramScheduler::add_row_candidate(std::uint32_t bank, DramCommand command, std::uint16_t slot,
                                             Class order_class) {
    const Access& access = access_[slot];
    set_candidate(kRowLane, bank, command, slot, access.order,
                  std::max(banks_.bank_time(command, bank), access.ready), order_class);
}

// Hits overtake older accesses to other rows only until those reach a cap.
inline bool DramScheduler::is_aged(const Access& access, DramCycle now) const {
    return now - access.arrival > config_.age_cap;
}

inline DramScheduler::Class DramScheduler::row_class(bool aged) const {
    if (aged) return kUrgent;
    return config_.arbitration == DramArbitration::kColumnFirst ? kLater : kNormal;
}

// After a PRE for a bank's oldest access, which now wants its row opened.
inline void DramScheduler::open_next(std::uint32_t bank, std::uint16_t oldest, DramCycle now) {
    const Access& access = access_[oldest];
    drop_candidate(access.write ? kWriteLane : kReadLane, bank);
    add_row_candidate(bank, DramCommand::kActivate, oldest, row_class(is_aged(access, now)));
}

// refresh_candidate() where all accesses that a bank sees are of one kind and none is promoted: the other
// kind's lane is empty. Most often the oldest is a hit.
template <bool kUsual>
inline void DramScheduler::refresh_plain_candidate(std::uint32_t bank, DramCycle now) {
    const Direction direction = queues_of<kUsual>(bank).direction;
    const std::uint16_t oldest = lists_.first(bank_list<kUsual>(direction, bank));
    if (lists_.is_end(oldest) || access_[oldest].row != banks_.open_row(bank) || blocked_by_refresh(bank))
        return refresh_row_candidate<kUsual>(bank, direction, oldest, now);
    drop_candidate(kRowLane, bank);
    add_column_candidate(bank, oldest, kNormal);
}

// What the bank could do next, for the accesses that it sees.
template <bool kUsual>
inline void DramScheduler::refresh_candidate(std::uint32_t bank, DramCycle now) {
    if (kUsual || plain_) return refresh_plain_candidate<kUsual>(bank, now);
    refresh_any_candidate(bank, now);
}

// Frees the access' entry.
template <bool kUsual>
inline void DramScheduler::leave_queue(Access& access, Direction direction, DramCycle now) {
    Queues& queues = queues_of<kUsual>(access.bank);
    access.queued = false;
    if (access.hurried) --queues.hurried;
    if (--queues.count[direction] == 0 && direction == kReads) queues.reads_gone = now;
    if (queues.batch != 0) --queues.batch;
    if (full_reads_ == nullptr || (full_reads_ == &queues && direction == kReads)) ++chances_;
}

}  // namespace ropsim
