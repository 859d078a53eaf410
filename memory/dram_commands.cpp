// The commands that are due: when there is one, and what issuing it changes.
#include "base/error.h"
#include "memory/dram_choice_inline.h"
#include "memory/dram_scheduler_inline.h"
#include "memory/dram_waits_inline.h"

#include <algorithm>

namespace ropsim {

void DramScheduler::close(std::uint32_t bank, DramCycle now) {
    bus_free_[bus_of_lane_[kRowLane]] = now + config_.row_bus_pre;
    trace(now, DramCommand::kPrecharge, bank, banks_.open_row(bank), 0);
    banks_.precharge(bank, now);
    ++statistics_.precharges;
}

template <bool kUsual>
inline void DramScheduler::issue_row(std::uint32_t bank, Candidate candidate, DramCycle now) {
    if (candidate.command == DramCommand::kPrecharge) {
        close(bank, now);
        if (candidate.slot != kNone) {
            access_[candidate.slot].precharged = true;
            if (kUsual || plain_) return open_next(bank, candidate.slot, now);
        }
    } else {
        Access& access = access_[candidate.slot];
        bus_free_[bus_of_lane_[kRowLane]] = now + config_.row_bus_act;
        trace(now, candidate.command, bank, access.row, 0);
        banks_.activate(bank, access.row, now);
        ++statistics_.activations;
        if (!access.activated) ++(access.precharged ? statistics_.row_conflicts : statistics_.row_misses);
        access.activated = true;
        if (kUsual || plain_) {  // the bank's oldest access is a hit now
            drop_candidate(kRowLane, bank);
            return add_column_candidate(bank, candidate.slot, kNormal);
        }
        if (config_.activated_leave_queue) {
            promoted_[bank] = candidate.slot;
            leave_queue<false>(access, access.write ? kWrites : kReads, now);
        }
    }
    refresh_candidate<kUsual>(bank, now);
}

// An access whose last burst was just issued leaves the channel.
template <DramCommand kCommand, bool kUsual>
inline void DramScheduler::retire(std::uint16_t slot, DramCycle now) {
    constexpr bool kWrite = kCommand == DramCommand::kWrite;
    constexpr Direction kDirection = kWrite ? kWrites : kReads;
    Access& access = access_[slot];
    if (kUsual || access.queued)
        leave_queue<kUsual>(access, kDirection, now);
    else
        ++chances_;
    if (!kUsual && config_.bank_queue != 0) --bank_fill_[access.bank];
    if (!kUsual && promoted_[access.bank] == slot) promoted_[access.bank] = kNone;
    lists_.remove(slot);
    free_slots_.push_back(slot);
    --present_[kDirection];
    --crowds_[kDirection][access.crowd];
    (kWrite ? statistics_.write_queue_sum : statistics_.read_queue_sum) += now;
    --channel_of<kUsual>(access.bank).present;
    statistics_.row_hits += access.activated ? 0 : 1;
    if (kWrite || --pieces_left_[access.number] != 0) return;
    const DramCycle done = now + data_cycles_[0] + config_.back_cycles;
    finished_.push_back({access.number, done});
    statistics_.read_latency.add(done - access.arrival);
}

// Whether an access leaves the channel with it.
template <DramCommand kCommand, bool kUsual>
[[gnu::always_inline]] inline bool DramScheduler::issue_column(Pseudochannel& pc, std::uint32_t bank,
                                                               std::uint16_t slot, DramCycle now) {
    constexpr bool kRead = kCommand == DramCommand::kRead;
    constexpr DramLabel kLabel = kRead ? DramLabel::kReadData : DramLabel::kWriteData;
    Access& access = access_[slot];
    bus_free_[0] = now + config_.column_bus;
    trace(now, kCommand, bank, access.row, access.column);
    if (kCommand != pc.last_column) {
        if (pc.last_column != DramCommand::kPrecharge) ++statistics_.turnarounds;
        pc.last_column = kCommand;
    }
    banks_.column<kCommand, kUsual>(bank, now);
    ++(kRead ? statistics_.read_bursts : statistics_.write_bursts);
    statistics_.label_cycles[static_cast<std::size_t>(kLabel)] += config_.burst;
    pc.labelled += config_.burst;
    data_end_[kRead ? 0 : 1] = now + data_cycles_[kRead ? 0 : 1];
    ++access.column;
    const bool last = --access.left == 0;
    if (last)
        retire<kCommand, kUsual>(slot, now);
    else if ((kUsual || plain_) && lists_.is_first(slot))
        return false;  // the bank's oldest access, a hit, goes on: its candidate stays as it is
    refresh_candidate<kUsual>(bank, now);
    return last;
}

template <bool kUsual>
inline void DramScheduler::issue(Pseudochannel& pc, const Best& best, DramCycle now) {
    const std::uint32_t bank = best.bank();
    const std::uint32_t lane = best.lane();
    if (lane == kRefreshLane) [[unlikely]] {
        issue_refresh_command(refresh_units_[bank], now);
        choose_all(pc, now);
        return;
    }
    if (!kUsual && config_.arbitration == DramArbitration::kRoundRobin) pc.next_turn = bank + 1;
    const Candidate candidate = candidate_[lane][bank];
    // What is settled stays so until an access leaves its queue.
    bool left = false;
    if (lane == kRowLane) {
        issue_row<kUsual>(bank, candidate, now);
        left = !kUsual && config_.activated_leave_queue;
    } else if (lane == kReadLane) {
        left = issue_column<DramCommand::kRead, kUsual>(pc, bank, candidate.slot, now);
    } else {
        left = issue_column<DramCommand::kWrite, kUsual>(pc, bank, candidate.slot, now);
    }
    Queues& queues = queues_of<kUsual>(bank);
    const bool turned = (left || queues.unsettled) && update_direction(queues, now);
    if (turned && (kUsual || !mixed_)) return;  // all is new
    choose_after<kUsual>(pc, lane, bank, now);
}

// Issues the commands that are due at `now`, and returns the time of the next. Pseudo-channels compete for
// the buses by the order of their commands.
template <>
inline DramCycle DramScheduler::issue_due<true>(DramCycle now) {
    DramCycle first = first_time<true>();
    while (first <= now) {
        issue<true>(pseudochannels_[0], first_of<true>(pseudochannels_[0]), now);
        first = first_time<true>();
    }
    return first;
}

template <>
inline DramCycle DramScheduler::issue_due<false>(DramCycle now) {
    while (true) {
        Pseudochannel* winner = pseudochannels_.begin();
        const Best* best = &first_of<false>(*winner);
        for (std::size_t i = 1; i < pseudochannels_.size(); ++i) {
            const Best& other = first_of<false>(pseudochannels_[i]);
            if (!before(other, *best)) continue;
            winner = &pseudochannels_[i];
            best = &other;
        }
        if (best->time > now) return best->time;
        const std::size_t bus = bus_of_lane_[std::min<std::uint32_t>(best->lane(), kRowLane)];
        if (bus_free_[bus] <= now)
            issue<false>(*winner, *best, now);
        else  // another pseudo-channel was faster
            choose_again(*winner, now);
    }
}

// Requires accesses.
template <bool kUsual>
[[gnu::always_inline]] inline void DramScheduler::step_as(DramCycle now) {
    account<kUsual>(now);
    if (now >= next_due_) [[unlikely]]
        start_refreshes(now);
    if constexpr (kUsual) {
        if (queues_[0].unsettled) update_direction(queues_[0], now);
    } else {
        for (Queues& queues : queues_)
            if (queues.unsettled) update_direction(queues, now);
    }
    DramCycle first = issue_due<kUsual>(now);
    if (!kUsual && config_.bank_queue != 0) {
        for (Queues& queues : queues_)
            if (queues.last_move != now)
                if (const std::uint16_t slot = movable(queues); slot != kNone) move(queues, slot, now);
        first = first_time<false>();
    }
    plan<kUsual>(now, first);
}

DramCycle DramScheduler::run_while(DramCycle end, std::uint64_t chances) {
    return usual_ ? run_as<true>(end, chances) : run_as<false>(end, chances);
}

template <bool kUsual>
DramCycle DramScheduler::run_as(DramCycle end, std::uint64_t chances) {
    DramCycle now = next_;
    do step_as<kUsual>(now = next_);
    while (next_ < end && chances_ < chances);
    return now;
}

DramCycle DramScheduler::run_to_chance() {
    const std::uint64_t chances = chances_ + 1;
    const DramCycle last = next_ == kNoCycle ? kNoCycle : run_while(kNoCycle, chances);
    CHECK(chances_ >= chances, "a request is held back, and nothing is queued");
    return last;
}

void DramScheduler::step(DramCycle now) {
    if (idle()) return account<false>(now);
    next_ = now;
    run_while(now, 0);  // one step
}

}  // namespace ropsim
