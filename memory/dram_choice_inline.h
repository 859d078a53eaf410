// Which of its candidates a pseudo-channel takes next, as far as every command asks.
#pragma once

#include "memory/dram_scheduler.h"

#include <algorithm>

namespace ropsim {

// Finds the command of one kind that comes first from `now` on, as things stand.
template <DramScheduler::Lane kLane, bool kUsual>
[[gnu::always_inline]] inline void DramScheduler::choose(Pseudochannel& pc, DramCycle now) {
    constexpr Kind kKind = kLane == kRowLane ? kRows : kColumns;
    // Lanes of columns are named like their command; of rows only activates are bound between banks.
    constexpr DramCommand kBound =
        kLane == kRowLane ? DramCommand::kActivate : static_cast<DramCommand>(kLane);
    Best& found = pc.best[kKind];
    DramCycle floor = std::max(now, bus_free_[bus_of_lane_[kLane]]);
    std::uint64_t key = 0;
    if constexpr (kUsual) {
        // The rank's limit binds all columns.
        if constexpr (kKind == kColumns) floor = std::max(floor, banks_.rank_limit(kBound, 0));
        key = scan_[kKind](keys_[kLane], range_, banks_.limits(kBound), floor) ^ DramScanKeys::kKeyBias;
    } else {
        key = least_key<kKind>(pc, floor);
    }
    if (key == kNoKey) {
        found.time = kNoCycle;
    } else {
        found.order = key & ((std::uint64_t{1} << kTimeShift) - 1);
        found.time = floor + (key >> kTimeShift);
        if (!kUsual && in_order_) found.time = time_of(found.lane(), found.bank(), floor);
    }
    if (kKind == kRows && refreshes_pending_ != 0) choose_refresh(pc, now);
}

// The lane does not matter but where only one is in use.
template <bool kUsual>
inline void DramScheduler::choose_columns(Pseudochannel& pc, DramCycle now) {
    if (kUsual && queues_[0].direction == kWrites)
        choose<kWriteLane, kUsual>(pc, now);
    else
        choose<kReadLane, kUsual>(pc, now);
}

inline void DramScheduler::reconsider_lane(Best& best, std::size_t lane, std::uint32_t bank, DramCycle now) {
    const DramCycle time = time_of(lane, bank, std::max(bus_free_[bus_of_lane_[lane]], now));
    const std::uint64_t order = keys_[lane].order_of(bank);
    if (time > best.time || (time == best.time && order > best.order)) return;
    best = {time, order};
}

template <bool kUsual>
inline void DramScheduler::reconsider_columns(Pseudochannel& pc, std::uint32_t bank, DramCycle now) {
    const auto consider = [&](std::size_t lane) {
        if (has_candidate(lane, bank)) reconsider_lane(pc.best[kColumns], lane, bank, now);
    };
    if constexpr (kUsual) return consider(queues_[0].direction);
    consider(kReadLane);
    consider(kWriteLane);
}

// The bests after a command of a lane was issued, which binds others of its kind. PRE binds none, but was the
// best of its kind. Of the other kind only the candidate of `bank` has changed, and the bus is taken.
template <bool kUsual>
[[gnu::always_inline]] inline void DramScheduler::choose_after(Pseudochannel& pc, std::size_t lane,
                                                               std::uint32_t bank, DramCycle now) {
    if (!kUsual && !simple_) return choose_all(pc, now);
    if (lane == kRowLane) {
        choose<kRowLane, kUsual>(pc, now);
        if (pc.best[kColumns].bank() == bank || pc.best[kColumns].time < bus_free_[0])
            choose_columns<kUsual>(pc, now);
        else
            reconsider_columns<kUsual>(pc, bank, now);
        return;
    }
    if (lane == kReadLane)
        choose<kReadLane, kUsual>(pc, now);
    else
        choose<kWriteLane, kUsual>(pc, now);
    if (pc.best[kRows].bank() == bank || refreshes_pending_ != 0 ||
        pc.best[kRows].time < bus_free_[bus_of_lane_[kRowLane]])
        choose<kRowLane, kUsual>(pc, now);
    else if (has_candidate(kRowLane, bank))
        reconsider_lane(pc.best[kRows], kRowLane, bank, now);
}

}  // namespace ropsim
