// The candidates of each bank: the commands it could take next.
#include "base/error.h"
#include "memory/dram_scheduler.h"

#include <algorithm>
#include <bit>

namespace ropsim {

template <bool kUsual>
inline void DramScheduler::set_candidate(Lane lane, std::uint32_t bank, DramCommand command,
                                         std::uint16_t slot, DramCycle time, Class order_class) {
    const std::uint32_t age = slot == kNone ? 0 : access_[slot].age;
    candidate_[lane][bank] = {slot, command};
    DramScanKeys& keys = keys_[lane];
    keys.time[bank] = DramScanKeys::kTimeBias + time;
    if (lane == kRowLane) keys.bound[bank] = command == DramCommand::kPrecharge ? 0 : ~std::uint64_t{0};
    keys.order[bank] = DramScanKeys::kKeyBias + (static_cast<std::uint64_t>(order_class) << kClassShift |
                                                 std::uint64_t{age} << kAgeShift |
                                                 static_cast<std::uint64_t>(lane) << 6 | bank);
    channel_of<kUsual>(bank).lanes[lane] |= std::uint64_t{1} << bank;
}

template <bool kUsual>
inline void DramScheduler::drop_candidate(std::size_t lane, std::uint32_t bank) {
    channel_of<kUsual>(bank).lanes[lane] &= ~(std::uint64_t{1} << bank);
    keys_[lane].order[bank] = DramScanKeys::kAbsent;
}

template <DramCommand kCommand, bool kUsual>
inline void DramScheduler::add_column_candidate(std::uint32_t bank, std::uint16_t slot, Class order_class) {
    set_candidate<kUsual>(kCommand == DramCommand::kRead ? kReadLane : kWriteLane, bank, kCommand, slot,
                          std::max(banks_.bank_time(kCommand, bank), access_[slot].ready), order_class);
}

template <bool kUsual>
inline void DramScheduler::add_column_candidate(std::uint32_t bank, std::uint16_t slot, Class order_class) {
    if (access_[slot].write)
        add_column_candidate<DramCommand::kWrite, kUsual>(bank, slot, order_class);
    else
        add_column_candidate<DramCommand::kRead, kUsual>(bank, slot, order_class);
}

template <bool kUsual>
inline void DramScheduler::add_row_candidate(std::uint32_t bank, std::uint16_t slot, Class order_class) {
    const DramCommand command =
        banks_.open_row(bank) == DramBanks::kClosed ? DramCommand::kActivate : DramCommand::kPrecharge;
    set_candidate<kUsual>(kRowLane, bank, command, slot,
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
    set_candidate<false>(kRowLane, bank, DramCommand::kPrecharge, kNone, closing_time(bank), kLast);
}

// refresh_candidate() where all accesses that a bank sees are of one kind and none is promoted: the other
// kind's lane is empty. Most often the oldest is a hit.
template <bool kUsual>
inline void DramScheduler::refresh_plain_candidate(std::uint32_t bank, DramCycle now) {
    const Direction direction = queues_of<kUsual>(bank).direction;
    const std::uint16_t oldest = lists_[direction][bank].head;
    if (oldest == kNone || access_[oldest].row != banks_.open_row(bank) || blocked_by_refresh(bank))
        return refresh_row_candidate<kUsual>(bank, direction, oldest, now);
    drop_candidate<kUsual>(kRowLane, bank);
    if (direction == kReads)
        add_column_candidate<DramCommand::kRead, kUsual>(bank, oldest, kNormal);
    else
        add_column_candidate<DramCommand::kWrite, kUsual>(bank, oldest, kNormal);
}

// ... and where it is none.
template <bool kUsual>
[[gnu::noinline]] void DramScheduler::refresh_row_candidate(std::uint32_t bank, Direction direction,
                                                            std::uint16_t oldest, DramCycle now) {
    drop_candidate<kUsual>(direction, bank);
    if (oldest == kNone || blocked_by_refresh(bank)) {
        drop_candidate<kUsual>(kRowLane, bank);
        if (!blocked_by_refresh(bank)) add_closing_candidate(bank);
        return;
    }
    const Access& first = access_[oldest];
    const std::uint32_t row = banks_.open_row(bank);
    const bool aged = now - first.arrival > config_.age_cap;
    const bool column_first = config_.arbitration == DramArbitration::kColumnFirst;
    if (row != DramBanks::kClosed && !aged) {
        const bool capped = banks_.hits(bank) >= config_.hit_cap;
        std::uint16_t hit = first.after;
        while (hit != kNone && access_[hit].row != row) hit = access_[hit].after;
        if (hit != kNone && !(capped && column_first)) {
            add_column_candidate<kUsual>(bank, hit, kNormal);
            if (!capped) return drop_candidate<kUsual>(kRowLane, bank);
        }
    }
    add_row_candidate<kUsual>(bank, oldest, aged ? kUrgent : column_first ? kLater : kNormal);
}

// Those of some banks.
void DramScheduler::clear_candidates(Pseudochannel& pc, std::uint64_t banks) {
    for (std::uint64_t& lane : pc.lanes) lane &= ~banks;
    for (; banks != 0; banks &= banks - 1)
        for (DramScanKeys& keys : keys_)
            keys.order[static_cast<std::size_t>(std::countr_zero(banks))] = DramScanKeys::kAbsent;
}

// What the bank could do next, for the accesses that it sees.
template <bool kUsual>
void DramScheduler::refresh_candidate(std::uint32_t bank, DramCycle now) {
    if (kUsual || plain_) return refresh_plain_candidate<kUsual>(bank, now);
    clear_candidates(pseudochannels_[pseudochannel_of(bank)], std::uint64_t{1} << bank);
    // An access that left its queue has first claim to the row it opened, even before a refresh.
    const std::uint16_t promoted_slot = promoted_[bank];
    const bool promoted = promoted_slot != kNone;
    if (promoted) add_column_candidate<false>(bank, promoted_slot, kUrgent);
    if (blocked_by_refresh(bank)) return;
    const Queues& queues = queues_of<false>(bank);
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
        if (other != kNone) add_column_candidate<false>(bank, other, kNormal);
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
            if (slot != kNone) add_column_candidate<false>(bank, slot, kNormal);
    if (any_hit && !only_row && !capped) return;
    const bool last = column_first && !aged && !in_order_;
    add_row_candidate<false>(bank, oldest, aged ? kUrgent : last ? kLater : kNormal);
}

template void DramScheduler::refresh_candidate<true>(std::uint32_t, DramCycle);
template void DramScheduler::refresh_candidate<false>(std::uint32_t, DramCycle);

// After the queues have turned.
template <bool kUsual>
void DramScheduler::refresh_all_candidates(const Queues& queues, DramCycle now) {
    const std::uint32_t banks = config_.banks_of_pseudochannel();
    const bool closes = config_.page_policy != DramPagePolicy::kOpen;
    for (std::uint32_t i = 0; i < pseudochannels_.size(); ++i) {
        if (&queues_[shared_ ? 0 : i] != &queues) continue;
        Pseudochannel& pc = pseudochannels_[i];
        clear_candidates(pc, pc.lanes[0] | pc.lanes[1] | pc.lanes[2]);
        for (std::uint32_t bank = i * banks; bank < (i + 1) * banks; ++bank)
            if (closes || lists_[queues.direction][bank].head != kNone || promoted_[bank] != kNone)
                refresh_candidate<kUsual>(bank, now);
        choose_all(pc, now);
    }
}

template void DramScheduler::refresh_all_candidates<true>(const Queues&, DramCycle);
template void DramScheduler::refresh_all_candidates<false>(const Queues&, DramCycle);

}  // namespace ropsim
