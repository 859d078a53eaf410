// The candidates of each bank: the commands it could take next.
#include "base/error.h"
#include "memory/dram_scheduler_inline.h"

#include <algorithm>
#include <bit>

namespace ropsim {

// When the page policy closes an open row that no access wants.
DramCycle DramScheduler::closing_time(std::uint32_t bank) const {
    const DramCycle time = banks_.bank_time(DramCommand::kPrecharge, bank);
    if (config_.page_policy == DramPagePolicy::kClosed) return time;
    return std::max(time, banks_.last_column(bank) + config_.page_timeout);
}

void DramScheduler::add_closing_candidate(std::uint32_t bank) {
    if (config_.page_policy == DramPagePolicy::kOpen || banks_.open_row(bank) == DramBanks::kClosed) return;
    set_candidate(kRowLane, bank, DramCommand::kPrecharge, kNone, bank, closing_time(bank), kLast);
}

// What the bank's oldest access needs, if it is no hit.
inline DramCommand DramScheduler::row_command(std::uint32_t bank) const {
    return banks_.open_row(bank) == DramBanks::kClosed ? DramCommand::kActivate : DramCommand::kPrecharge;
}

// refresh_plain_candidate() where the oldest is no hit.
template <bool kUsual>
void DramScheduler::refresh_row_candidate(std::uint32_t bank, Direction direction, std::uint16_t oldest,
                                          DramCycle now) {
    drop_candidate(direction, bank);
    if (lists_.is_end(oldest) || blocked_by_refresh(bank)) {
        drop_candidate(kRowLane, bank);
        if (!blocked_by_refresh(bank)) add_closing_candidate(bank);
        return;
    }
    const Access& first = access_[oldest];
    const std::uint32_t row = banks_.open_row(bank);
    const bool aged = is_aged(first, now);
    if (row != DramBanks::kClosed && !aged) {
        const bool capped = banks_.hits(bank) >= config_.hit_cap;
        const std::uint16_t end = lists_.end(bank_list<kUsual>(direction, bank));
        std::uint16_t hit = lists_.after(oldest);
        while (hit != end && access_[hit].row != row) hit = lists_.after(hit);
        if (hit != end && !(capped && config_.arbitration == DramArbitration::kColumnFirst)) {
            add_column_candidate(bank, hit, kNormal);
            if (!capped) return drop_candidate(kRowLane, bank);
        }
    }
    add_row_candidate(bank, row_command(bank), oldest, row_class(aged));
}

template void DramScheduler::refresh_row_candidate<true>(std::uint32_t, Direction, std::uint16_t, DramCycle);
template void DramScheduler::refresh_row_candidate<false>(std::uint32_t, Direction, std::uint16_t, DramCycle);

void DramScheduler::clear_candidates(std::uint32_t bank) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) drop_candidate(lane, bank);
}

void DramScheduler::refresh_any_candidate(std::uint32_t bank, DramCycle now) {
    clear_candidates(bank);
    // An access that left its queue has first claim to the row it opened, even before a refresh.
    const std::uint16_t promoted_slot = promoted_[bank];
    const bool promoted = promoted_slot != kNone;
    if (promoted) add_column_candidate(bank, promoted_slot, kUrgent);
    if (blocked_by_refresh(bank)) return;
    const Queues& queues = queues_of<false>(bank);
    const std::uint32_t row = banks_.open_row(bank);
    const std::uint16_t oldest = lists_.first(bank_list<false>(queues.direction, bank));
    std::array<std::uint16_t, 2> hit = {kNone, kNone};
    if (row != DramBanks::kClosed)
        for (std::uint16_t slot = oldest; !lists_.is_end(slot); slot = lists_.after(slot)) {
            const Access& access = access_[slot];
            if (access.row != row || hit[access.write] != kNone) continue;
            hit[access.write] = slot;
            if (!mixed_ || hit[!access.write] != kNone) break;
        }
    if (promoted) {  // of its own kind it goes first; nothing closes its row
        const std::uint16_t other = hit[!access_[promoted_slot].write];
        if (other != kNone) add_column_candidate(bank, other, kNormal);
        return;
    }
    if (lists_.is_end(oldest)) return add_closing_candidate(bank);
    const bool any_hit = hit[kReads] != kNone || hit[kWrites] != kNone;
    bool aged = false, capped = false;
    if (access_[oldest].row != row) {
        aged = config_.scheduler == DramScheduling::kFirstReady && is_aged(access_[oldest], now);
        capped = banks_.hits(bank) >= config_.hit_cap;
    }
    const bool column_first = config_.arbitration == DramArbitration::kColumnFirst;
    const bool only_row =
        any_hit && access_[oldest].row != row && (aged || in_order_ || (capped && column_first));
    if (any_hit && !only_row)
        for (const std::uint16_t slot : hit)
            if (slot != kNone) add_column_candidate(bank, slot, kNormal);
    if (any_hit && !only_row && !capped) return;
    const bool last = column_first && !aged && !in_order_;
    add_row_candidate(bank, row_command(bank), oldest, aged ? kUrgent : last ? kLater : kNormal);
}

// After the queues have turned.
template <bool kUsual>
void DramScheduler::refresh_all_candidates(const Queues& queues, DramCycle now) {
    const std::uint32_t banks = config_.banks_of_pseudochannel();
    const bool closes = config_.page_policy != DramPagePolicy::kOpen;
    for (std::uint32_t i = 0; i < pseudochannels_.size(); ++i) {
        if (&queues_[shared_ ? 0 : i] != &queues) continue;
        std::uint64_t wanted = 0;  // banks, found without a branch: any may be empty
        for (std::uint32_t bank = i * banks; bank < (i + 1) * banks; ++bank) {
            clear_candidates(bank);
            const int any = static_cast<int>(closes) |
                            static_cast<int>(!lists_.empty(bank_list<kUsual>(queues.direction, bank))) |
                            static_cast<int>(promoted_[bank] != kNone);
            wanted |= static_cast<std::uint64_t>(any) << bank;
        }
        for (; wanted != 0; wanted &= wanted - 1)
            refresh_candidate<kUsual>(static_cast<std::uint32_t>(std::countr_zero(wanted)), now);
        choose_all(pseudochannels_[i], now);
    }
}

template void DramScheduler::refresh_all_candidates<true>(const Queues&, DramCycle);
template void DramScheduler::refresh_all_candidates<false>(const Queues&, DramCycle);

}  // namespace ropsim
