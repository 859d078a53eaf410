// The candidates of each bank, and what issuing a command changes.
#include "base/error.h"
#include "memory/dram_scheduler.h"

#include <algorithm>
#include <bit>

namespace ropsim {

inline void DramScheduler::set_candidate(Lane lane, std::uint32_t bank, DramCommand command,
                                         std::uint16_t slot, DramCycle time, Class order_class) {
    const std::uint32_t age = slot == kNone ? 0 : access_[slot].age;
    candidate_[bank][lane] = {banks_.limit_index(command, bank), slot, command};
    DramScanKeys& keys = keys_[lane];
    keys.time[bank] = DramScanKeys::kTimeBias + time;
    keys.bound[bank] = command == DramCommand::kPrecharge ? 0 : ~std::uint64_t{0};
    keys.order[bank] = DramScanKeys::kKeyBias + (static_cast<std::uint64_t>(order_class) << kClassShift |
                                                 std::uint64_t{age} << kAgeShift |
                                                 static_cast<std::uint64_t>(lane) << 6 | bank);
    pseudochannels_[pseudochannel_of(bank)].lanes[lane] |= std::uint64_t{1} << bank;
}

inline void DramScheduler::add_column_candidate(std::uint32_t bank, std::uint16_t slot, Class order_class) {
    const Access& access = access_[slot];
    const DramCommand command = access.write ? DramCommand::kWrite : DramCommand::kRead;
    set_candidate(access.write ? kWriteLane : kReadLane, bank, command, slot,
                  std::max(banks_.bank_time(command, bank), access.ready), order_class);
}

inline void DramScheduler::add_row_candidate(std::uint32_t bank, std::uint16_t slot, Class order_class) {
    const DramCommand command =
        banks_.open_row(bank) == DramBanks::kClosed ? DramCommand::kActivate : DramCommand::kPrecharge;
    set_candidate(kRowLane, bank, command, slot,
                  std::max(banks_.bank_time(command, bank), access_[slot].ready), order_class);
}

// When the page policy closes an open row that no access wants.
DramCycle DramScheduler::closing_time(std::uint32_t bank) const {
    const DramCycle time = banks_.bank_time(DramCommand::kPrecharge, bank);
    if (config_.page_policy == DramPagePolicy::kClosed) return time;
    return std::max(time, banks_.last_column(bank) + config_.page_timeout);
}

void DramScheduler::add_closing_candidate(std::uint32_t bank) {
    if (config_.page_policy == DramPagePolicy::kOpen || banks_.open_row(bank) == DramBanks::kClosed) return;
    set_candidate(kRowLane, bank, DramCommand::kPrecharge, kNone, closing_time(bank), kLast);
}

bool DramScheduler::blocked_by_refresh(std::uint32_t bank) const {
    return (blocked_banks_ >> bank & 1) != 0;
}

// refresh_candidate() where all accesses that a bank sees are of one kind and none is promoted: the other
// kind's lane is empty.
inline void DramScheduler::refresh_plain_candidate(std::uint32_t bank, DramCycle now) {
    Pseudochannel& pc = pseudochannels_[pseudochannel_of(bank)];
    const Direction direction = queues_of(bank).direction;
    const std::uint64_t others = ~(std::uint64_t{1} << bank);
    pc.lanes[direction] &= others;
    pc.lanes[kRowLane] &= others;
    keys_[direction].order[bank] = keys_[kRowLane].order[bank] = DramScanKeys::kAbsent;
    if (blocked_by_refresh(bank)) return;
    const std::uint16_t oldest = lists_[direction][bank].head;
    if (oldest == kNone) return add_closing_candidate(bank);
    const std::uint32_t row = banks_.open_row(bank);
    const Access& first = access_[oldest];
    if (first.row == row) return add_column_candidate(bank, oldest, kUsual);
    const bool aged = now - first.arrival > config_.age_cap;
    const bool column_first = config_.arbitration == DramArbitration::kColumnFirst;
    if (row != DramBanks::kClosed && !aged) {
        const bool capped = banks_.hits(bank) >= config_.hit_cap;
        std::uint16_t hit = first.after;
        while (hit != kNone && access_[hit].row != row) hit = access_[hit].after;
        if (hit != kNone && !(capped && column_first)) {
            add_column_candidate(bank, hit, kUsual);
            if (!capped) return;
        }
    }
    add_row_candidate(bank, oldest, aged ? kUrgent : column_first ? kLater : kUsual);
}

// Those of some banks.
void DramScheduler::clear_candidates(Pseudochannel& pc, std::uint64_t banks) {
    for (std::uint64_t& lane : pc.lanes) lane &= ~banks;
    for (; banks != 0; banks &= banks - 1)
        for (DramScanKeys& keys : keys_)
            keys.order[static_cast<std::size_t>(std::countr_zero(banks))] = DramScanKeys::kAbsent;
}

// What the bank could do next, for the accesses that it sees.
void DramScheduler::refresh_candidate(std::uint32_t bank, DramCycle now) {
    if (plain_) return refresh_plain_candidate(bank, now);
    clear_candidates(pseudochannels_[pseudochannel_of(bank)], std::uint64_t{1} << bank);
    // An access that left its queue has first claim to the row it opened, even before a refresh.
    const std::uint16_t promoted_slot = promoted_[bank];
    const bool promoted = promoted_slot != kNone;
    if (promoted) add_column_candidate(bank, promoted_slot, kUrgent);
    if (blocked_by_refresh(bank)) return;
    const Queues& queues = queues_of(bank);
    const std::uint32_t row = banks_.open_row(bank);
    const std::uint16_t oldest = lists_[mixed_ ? kReads : queues.direction][bank].head;
    std::array<std::uint16_t, 2> hit = {kNone, kNone};
    if (row != DramBanks::kClosed)
        for (std::uint16_t slot = oldest; slot != kNone; slot = access_[slot].after) {
            const Access& access = access_[slot];
            if (access.row != row || hit[access.write] != kNone) continue;
            hit[access.write] = slot;
            if (!mixed_ || hit[!access.write] != kNone) break;
        }
    if (promoted) {  // of its own kind it goes first; nothing closes its row
        const std::uint16_t other = hit[!access_[promoted_slot].write];
        if (other != kNone) add_column_candidate(bank, other, kUsual);
        return;
    }
    if (oldest == kNone) return add_closing_candidate(bank);
    const bool any_hit = hit[kReads] != kNone || hit[kWrites] != kNone;
    bool aged = false, capped = false;
    if (access_[oldest].row != row) {
        // Hits overtake older accesses to other rows only until those reach a cap.
        aged = config_.scheduler == DramScheduling::kFirstReady &&
               now - access_[oldest].arrival > config_.age_cap;
        capped = banks_.hits(bank) >= config_.hit_cap;
    }
    const bool column_first = config_.arbitration == DramArbitration::kColumnFirst;
    const bool only_row =
        any_hit && access_[oldest].row != row && (aged || in_order_ || (capped && column_first));
    if (any_hit && !only_row)
        for (const std::uint16_t slot : hit)
            if (slot != kNone) add_column_candidate(bank, slot, kUsual);
    if (any_hit && !only_row && !capped) return;
    const bool last = column_first && !aged && !in_order_;
    add_row_candidate(bank, oldest, aged ? kUrgent : last ? kLater : kUsual);
}

// After the queues have turned.
void DramScheduler::refresh_all_candidates(const Queues& queues, DramCycle now) {
    const std::uint32_t banks = config_.banks_of_pseudochannel();
    const bool closes = config_.page_policy != DramPagePolicy::kOpen;
    for (std::uint32_t i = 0; i < pseudochannels_.size(); ++i) {
        if (&queues_[shared_ ? 0 : i] != &queues) continue;
        Pseudochannel& pc = pseudochannels_[i];
        clear_candidates(pc, pc.lanes[0] | pc.lanes[1] | pc.lanes[2]);
        for (std::uint32_t bank = i * banks; bank < (i + 1) * banks; ++bank)
            if (closes || lists_[queues.direction][bank].head != kNone || promoted_[bank] != kNone)
                refresh_candidate(bank, now);
        choose_all(pc, now);
    }
}

// Issues the commands that are due at `now`, and returns the time of the next. Pseudo-channels compete for
// the buses by the order of their commands.
DramCycle DramScheduler::issue_due(DramCycle now) {
    while (true) {
        Pseudochannel* winner = pseudochannels_.data();
        const Best* best = &first_of(*winner);
        for (std::size_t i = 1; i < pseudochannels_.size(); ++i) {
            const Best& other = first_of(pseudochannels_[i]);
            if (!before(other, *best)) continue;
            winner = &pseudochannels_[i];
            best = &other;
        }
        if (best->time > now) return best->time;
        const std::size_t bus = bus_of_lane_[best->lane == kRefreshLane ? std::size_t{kRowLane} : best->lane];
        if (bus_free_[bus] <= now)
            issue(*winner, *best, now);
        else  // another pseudo-channel was faster
            choose_again(*winner, now);
    }
}

// Whether a bank's oldest access, a hit, has more bursts to move: its candidate stays as it is.
inline bool DramScheduler::goes_on(std::uint16_t slot, DramCommand command) const {
    if (!plain_ || slot == kNone || (command != DramCommand::kRead && command != DramCommand::kWrite))
        return false;
    return access_[slot].left != 0 && access_[slot].before == kNone;
}

void DramScheduler::issue(Pseudochannel& pc, const Best& best, DramCycle now) {
    const std::uint32_t bank = best.bank;
    if (best.lane == kRefreshLane) {
        issue_refresh_command(refresh_units_[bank], now);
        choose_all(pc, now);
        return;
    }
    const std::uint16_t slot = candidate_[bank][best.lane].slot;
    const DramCommand command = candidate_[bank][best.lane].command;
    if (config_.arbitration == DramArbitration::kRoundRobin) pc.next_turn = bank + 1;
    switch (command) {
        case DramCommand::kPrecharge:
            if (slot != kNone) access_[slot].precharged = true;
            close(bank, now);
            break;
        case DramCommand::kActivate: {
            Access& access = access_[slot];
            bus_free_[bus_of_lane_[kRowLane]] = now + config_.row_bus_act;
            trace(now, command, bank, access.row, 0);
            banks_.activate(bank, access.row, now);
            ++statistics_.activations;
            if (!access.activated) ++(access.precharged ? statistics_.row_conflicts : statistics_.row_misses);
            access.activated = true;
            if (config_.activated_leave_queue) {
                promoted_[bank] = slot;
                leave_queue(access, now);
            }
            break;
        }
        default:
            issue_column(pc, bank, slot, command, now);
            break;
    }
    if (!goes_on(slot, command)) refresh_candidate(bank, now);
    if (!update_direction(queues_of(bank), now) || mixed_) choose_after(pc, bank, command, now);
}

void DramScheduler::close(std::uint32_t bank, DramCycle now) {
    bus_free_[bus_of_lane_[kRowLane]] = now + config_.row_bus_pre;
    trace(now, DramCommand::kPrecharge, bank, banks_.open_row(bank), 0);
    banks_.precharge(bank, now);
    ++statistics_.precharges;
}

void DramScheduler::issue_column(Pseudochannel& pc, std::uint32_t bank, std::uint16_t slot,
                                 DramCommand command, DramCycle now) {
    Access& access = access_[slot];
    bus_free_[0] = now + config_.column_bus;
    trace(now, command, bank, access.row, access.column);
    if (command != pc.last_column && pc.last_column != DramCommand::kPrecharge) ++statistics_.turnarounds;
    pc.last_column = command;
    if (command == DramCommand::kRead) {
        banks_.read(bank, now);
        ++statistics_.read_bursts;
        pc.owned[0] += config_.burst;
        last_data_ = std::max(last_data_, now + config_.read_cycles());
    } else {
        banks_.write(bank, now);
        ++statistics_.write_bursts;
        pc.owned[1] += config_.burst;
        last_data_ = std::max(last_data_, now + config_.write_cycles());
    }
    ++access.column;
    if (--access.left == 0) retire(slot, now);
}

}  // namespace ropsim
