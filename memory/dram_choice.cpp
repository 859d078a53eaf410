// Which of its candidates a pseudo-channel takes next.
#include "base/error.h"
#include "memory/dram_scheduler.h"

#include <algorithm>
#include <bit>

namespace ropsim {

// The smallest of (time from `floor`, order) over the candidates of one kind, packed into one number, so that
// the scan has no branch to mispredict.
template <DramScheduler::Kind kKind, DramArbitration kArbitration, bool kInOrder>
std::uint64_t DramScheduler::scan(const Pseudochannel& pc, DramCycle floor) const {
    constexpr DramCycle kFar = (DramCycle{1} << (64 - kTimeShift)) - 1;  // beyond every timing
    constexpr int kTurnShift = 33;  // above the age's low bits, which order the candidates of one bank
    constexpr std::uint64_t kTurnMask =
        ~(((std::uint64_t{1} << kClassShift) - 1) ^ ((std::uint64_t{1} << kTurnShift) - 1));
    const std::uint32_t bank_mask = (1u << pseudochannel_shift_) - 1;
    std::uint64_t best = ~std::uint64_t{0};
    for (std::size_t lane = kKind == kColumns ? 0 : kRowLane; lane < (kKind == kColumns ? kRowLane : kLanes);
         ++lane) {
        for (std::uint64_t banks = pc.lanes[lane]; banks != 0; banks &= banks - 1) {
            const auto bank = static_cast<std::uint32_t>(std::countr_zero(banks));
            std::uint64_t order = keys_[lane].order_of(bank);
            if constexpr (kArbitration == DramArbitration::kRoundRobin)
                order = (order & kTurnMask) | std::uint64_t{(bank - pc.next_turn) & bank_mask} << kTurnShift;
            if constexpr (kInOrder) {
                best = std::min(best, order);
            } else {
                const DramCycle limit = banks_.limit(candidate_[bank][lane].limit);
                const DramCycle time = std::max(std::max(keys_[lane].time_of(bank), limit), floor);
                best = std::min(best, std::min(time - floor, kFar) << kTimeShift | order);
            }
        }
    }
    return best;
}

// What scan_ makes of one candidate.
inline std::uint64_t DramScheduler::key_of(std::size_t lane, std::size_t bank, DramCycle floor) const {
    const DramScanKeys& keys = keys_[lane];
    const DramCycle limit = banks_.limit(candidate_[bank][lane].limit);
    const DramCycle time = std::max(std::max(keys.time_of(bank), limit), floor);
    return ((time - floor) << kTimeShift) + keys.order[bank];
}

// Finds the command of one kind that comes first from `now` on, as things stand.
template <DramScheduler::Kind kKind>
void DramScheduler::choose(Pseudochannel& pc, DramCycle now) {
    Best& found = pc.best[kKind];
    found.time = kNoCycle;
    const DramCycle floor = std::max(now, bus_free_[bus_of_lane_[kKind == kRows ? kRowLane : 0]]);
    if ((kKind == kRows ? pc.lanes[kRowLane] : pc.lanes[0] | pc.lanes[1]) != 0) {
        std::uint64_t best = 0;
        if (scan_ != nullptr) [[likely]] {
            best = DramScanKeys::kAbsent;
            for (std::size_t lane = kKind == kColumns ? 0 : kRowLane;
                 lane < (kKind == kColumns ? kRowLane : kLanes); ++lane) {
                const std::uint64_t banks = pc.lanes[lane];
                if (banks == 0) continue;
                constexpr std::array<DramCommand, kLanes> kRules = {DramCommand::kRead, DramCommand::kWrite,
                                                                    DramCommand::kActivate};
                const std::uint64_t key =
                    (banks & (banks - 1)) == 0
                        ? key_of(lane, static_cast<std::size_t>(std::countr_zero(banks)), floor)
                        : scan_(keys_[lane], pc.first_bank, groups_, config_.banks_per_group,
                                banks_.limits(kRules[lane]) + pc.first_group, floor);
                best = std::min(best, key);
            }
            best ^= DramScanKeys::kKeyBias;
        } else if (simple_)
            best = scan<kKind, DramArbitration::kOldest, false>(pc, floor);
        else if (in_order_)
            best = scan<kKind, DramArbitration::kOldest, true>(pc, floor);
        else
            best = scan<kKind, DramArbitration::kRoundRobin, false>(pc, floor);
        found.order = best & ((std::uint64_t{1} << kTimeShift) - 1);
        found.bank = static_cast<std::uint8_t>(best & 63);
        found.lane = static_cast<std::uint8_t>(best >> 6 & 3);
        found.time = floor + (best >> kTimeShift);
        if (in_order_) {
            const DramCycle limit = banks_.limit(candidate_[found.bank][found.lane].limit);
            found.time = std::max({floor, keys_[found.lane].time_of(found.bank), limit});
        }
    }
    if (kKind == kRows && refreshes_pending_ != 0) choose_refresh(pc, now);
}

template void DramScheduler::choose<DramScheduler::kColumns>(Pseudochannel&, DramCycle);
template void DramScheduler::choose<DramScheduler::kRows>(Pseudochannel&, DramCycle);

// A refresh goes before other row commands.
void DramScheduler::choose_refresh(Pseudochannel& pc, DramCycle now) {
    const auto index = static_cast<std::uint32_t>(&pc - pseudochannels_.data());
    for (std::uint32_t r = index * config_.ranks; r < (index + 1) * config_.ranks; ++r) {
        if (!refresh_units_[r].pending) continue;
        const DramCycle time = std::max(now, refresh_command_time(refresh_units_[r]));
        if (time > pc.best[kRows].time || time == kNoCycle) continue;
        pc.best[kRows] = {time, 0, kRefreshLane, static_cast<std::uint8_t>(r)};
    }
}

void DramScheduler::reconsider_lane(Best& best, std::size_t lane, std::uint32_t bank, DramCycle now) {
    const DramCycle limit = banks_.limit(candidate_[bank][lane].limit);
    const DramCycle bus = std::max(bus_free_[bus_of_lane_[lane]], now);
    const DramCycle time = std::max(std::max(keys_[lane].time_of(bank), limit), bus);
    const std::uint64_t order = keys_[lane].order_of(bank);
    if (time > best.time || (time == best.time && order > best.order)) return;
    best = {time, order, static_cast<std::uint8_t>(lane), static_cast<std::uint8_t>(bank)};
}

// The bests after only the candidates of `bank` have changed.
void DramScheduler::reconsider(Pseudochannel& pc, std::uint32_t bank, DramCycle now) {
    if (!simple_) return choose_all(pc, now);
    if (pc.best[kColumns].bank == bank)
        choose<kColumns>(pc, now);
    else
        for (std::size_t lane = 0; lane < kRowLane; ++lane)
            if ((pc.lanes[lane] >> bank & 1) != 0) reconsider_lane(pc.best[kColumns], lane, bank, now);
    if (pc.best[kRows].bank == bank || refreshes_pending_ != 0)
        choose<kRows>(pc, now);
    else if ((pc.lanes[kRowLane] >> bank & 1) != 0)
        reconsider_lane(pc.best[kRows], kRowLane, bank, now);
}

// ... and after a command of its was issued, which binds others of its kind. PRE binds none, but was the best
// of its kind.
void DramScheduler::choose_after(Pseudochannel& pc, std::uint32_t bank, DramCommand command, DramCycle now) {
    if (!simple_) return choose_all(pc, now);
    const bool column = command == DramCommand::kRead || command == DramCommand::kWrite;
    pc.best[column ? kColumns : kRows].bank = static_cast<std::uint8_t>(bank);
    if (column) {
        choose<kColumns>(pc, now);
        if (pc.best[kRows].bank == bank || refreshes_pending_ != 0 ||
            pc.best[kRows].time < bus_free_[bus_of_lane_[kRowLane]])
            choose<kRows>(pc, now);
        else if ((pc.lanes[kRowLane] >> bank & 1) != 0)
            reconsider_lane(pc.best[kRows], kRowLane, bank, now);
        return;
    }
    choose<kRows>(pc, now);
    if (pc.best[kColumns].bank == bank || pc.best[kColumns].time < bus_free_[0]) {
        choose<kColumns>(pc, now);
        return;
    }
    for (std::size_t lane = 0; lane < kRowLane; ++lane)
        if ((pc.lanes[lane] >> bank & 1) != 0) reconsider_lane(pc.best[kColumns], lane, bank, now);
}

}  // namespace ropsim
