// Refresh of ranks or of their banks in turn, and what an idle channel does in arrears.
#include "base/error.h"
#include "memory/dram_scheduler_inline.h"

#include <algorithm>

namespace ropsim {

void DramScheduler::find_next_due() {
    next_due_ = kNoCycle;
    for (const RefreshUnit& unit : refresh_units_)
        if (!unit.pending) next_due_ = std::min(next_due_, unit.due);
}

std::uint32_t DramScheduler::refresh_rank(const RefreshUnit& unit) const {
    return static_cast<std::uint32_t>(&unit - refresh_units_.data());
}

// Bars the banks of every refresh that has come due from all other commands.
void DramScheduler::start_refreshes(DramCycle now) {
    for (RefreshUnit& unit : refresh_units_) {
        if (unit.pending || unit.due > now) continue;
        unit.pending = true;
        ++refreshes_pending_;
        const std::uint32_t rank = refresh_rank(unit);
        const std::uint32_t banks = config_.banks_of_rank();
        const bool by_bank = config_.refresh == DramRefresh::kPerBank;
        const std::uint32_t first = by_bank ? unit.bank : rank * banks;
        for (std::uint32_t bank = first; bank < (by_bank ? first + 1 : first + banks); ++bank) {
            blocked_banks_ |= std::uint64_t{1} << bank;
            refresh_candidate<false>(bank, now);
        }
        choose_all(pseudochannels_[pseudochannel_of(first)], now);
    }
    find_next_due();
}

DramCycle DramScheduler::refresh_command_time(const RefreshUnit& unit) const {
    const std::uint32_t rank = refresh_rank(unit);
    const bool by_bank = config_.refresh == DramRefresh::kPerBank;
    const std::uint32_t first = by_bank ? unit.bank : rank * config_.banks_of_rank();
    const std::uint32_t end = by_bank ? first + 1 : first + config_.banks_of_rank();
    if (config_.activated_leave_queue)
        for (std::uint32_t bank = first; bank < end; ++bank)
            if (promoted_[bank] != kNone) return kNoCycle;
    DramCycle ready = 0;
    if (by_bank) {
        ready = banks_.open_row(unit.bank) == DramBanks::kClosed
                    ? banks_.refresh_bank_time(unit.bank)
                    : banks_.bank_time(DramCommand::kPrecharge, unit.bank);
    } else if (banks_.all_closed(rank)) {
        ready = banks_.refresh_time(rank);
    } else if (config_.refresh_closes_singly) {
        std::uint32_t bank = first;
        while (banks_.open_row(bank) == DramBanks::kClosed) ++bank;
        ready = banks_.bank_time(DramCommand::kPrecharge, bank);
    } else {
        ready = banks_.precharge_all_time(rank);
    }
    return std::max({ready, unit.due, bus_free_[bus_of_lane_[kRowLane]]});
}

void DramScheduler::issue_refresh_command(RefreshUnit& unit, DramCycle now) {
    const std::uint32_t rank = refresh_rank(unit);
    const std::uint32_t first = rank * config_.banks_of_rank();
    const std::uint32_t end = first + config_.banks_of_rank();
    const bool by_bank = config_.refresh == DramRefresh::kPerBank;
    if (by_bank && banks_.open_row(unit.bank) != DramBanks::kClosed) return close(unit.bank, now);
    if (!by_bank && !banks_.all_closed(rank)) {
        if (!config_.refresh_closes_singly) trace(now, DramCommand::kPrechargeAll, first, 0, 0);
        for (std::uint32_t bank = first; bank < end; ++bank) {
            if (banks_.open_row(bank) == DramBanks::kClosed) continue;
            if (config_.refresh_closes_singly) return close(bank, now);
            banks_.precharge(bank, now);
            ++statistics_.precharges;
        }
        bus_free_[bus_of_lane_[kRowLane]] = now + config_.row_bus_pre;
        return;
    }
    bus_free_[bus_of_lane_[kRowLane]] = now + config_.row_bus_pre;
    Pseudochannel& pc = pseudochannels_[pseudochannel_of(first)];
    if (unit.pending) --refreshes_pending_;
    unit.pending = false;
    if (by_bank) {
        trace(now, DramCommand::kRefreshBank, unit.bank, 0, 0);
        banks_.refresh_bank(unit.bank, now);
        ++statistics_.bank_refreshes;
        unit.due += config_.trefipb;
        blocked_banks_ &= ~(std::uint64_t{1} << unit.bank);
        refresh_candidate<false>(unit.bank, now);
        pc.refresh_end = now + config_.trfcpb;
        if (++unit.bank == end) unit.bank = first;
    } else {
        trace(now, DramCommand::kRefresh, first, 0, 0);
        banks_.refresh(rank, now);
        ++statistics_.refreshes;
        unit.due += config_.trefi;
        pc.refresh_end = now + config_.trfc;
        for (std::uint32_t bank = first; bank < end; ++bank) {
            blocked_banks_ &= ~(std::uint64_t{1} << bank);
            refresh_candidate<false>(bank, now);
        }
    }
    find_next_due();
}

// What came due while nothing was queued is done in arrears, at the times it would have had: refreshes, and
// the closing of rows by the page policy.
void DramScheduler::catch_up(DramCycle now) {
    while (true) {
        DramCycle first = now;
        RefreshUnit* unit = nullptr;
        std::uint32_t closing = DramBanks::kMaxBanks;
        if (config_.page_policy != DramPagePolicy::kOpen)
            for (std::uint32_t bank = 0; bank < config_.banks(); ++bank) {
                if (banks_.open_row(bank) == DramBanks::kClosed || blocked_by_refresh(bank)) continue;
                const DramCycle time = std::max(closing_time(bank), bus_free_[bus_of_lane_[kRowLane]]);
                if (time < first) first = time, closing = bank;
            }
        for (RefreshUnit& candidate : refresh_units_) {
            if (candidate.due >= now) continue;
            const DramCycle time = refresh_command_time(candidate);
            if (time < first || (time == first && closing != DramBanks::kMaxBanks))
                first = time, unit = &candidate;
        }
        if (unit != nullptr)
            issue_refresh_command(*unit, first);
        else if (closing != DramBanks::kMaxBanks)
            close(closing, first), refresh_candidate<false>(closing, first);
        else
            break;
    }
    for (Pseudochannel& pc : pseudochannels_) choose_all(pc, now);
}

}  // namespace ropsim
