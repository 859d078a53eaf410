// Which of its candidates a pseudo-channel takes next.
#include "base/error.h"
#include "memory/dram_choice_inline.h"

#include <algorithm>

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
        for (std::uint32_t bank = pc.first_bank; bank <= pc.first_bank + bank_mask; ++bank) {
            if (!has_candidate(lane, bank)) continue;
            std::uint64_t order = keys_[lane].order_of(bank);
            if constexpr (kArbitration == DramArbitration::kRoundRobin)
                order = (order & kTurnMask) | std::uint64_t{(bank - pc.next_turn) & bank_mask} << kTurnShift;
            if constexpr (kInOrder) {
                best = std::min(best, order);
            } else {
                const DramCycle ahead = time_of(lane, bank, floor) - floor;
                best = std::min(best, std::min(ahead, kFar) << kTimeShift | order);
            }
        }
    }
    return best == ~std::uint64_t{0} ? kNoKey : best;
}

// The same of one lane by scan_.
std::uint64_t DramScheduler::scan_lane(const Pseudochannel& pc, std::size_t lane, DramCycle floor) const {
    const DramCommand command = lane == kRowLane ? DramCommand::kActivate : static_cast<DramCommand>(lane);
    const DramCycle* const limits = banks_.limits(command) + pc.first_group;
    if (lane == kRowLane)
        return scan_[kRows](keys_[lane], {pc.first_bank, groups_, config_.banks_per_group}, limits, floor);
    std::uint64_t best = DramScanKeys::kAbsent;
    for (std::uint32_t rank = 0; rank < config_.ranks; ++rank) {
        const std::uint32_t bank = pc.first_bank + rank * config_.banks_of_rank();
        const DramCycle from = std::max(floor, banks_.rank_limit(command, banks_.rank_of(bank)));
        const std::uint64_t key =
            scan_[kColumns](keys_[lane], {bank, config_.bank_groups, config_.banks_per_group},
                            limits + std::size_t{rank} * config_.bank_groups, from);
        best = std::min(best, key + ((from - floor) << kTimeShift));
    }
    return best;
}

// The same of one kind by whatever does it for this configuration.
template <DramScheduler::Kind kKind>
std::uint64_t DramScheduler::least_key(const Pseudochannel& pc, DramCycle floor) const {
    if (scan_[kRows] != nullptr) {
        std::uint64_t best = DramScanKeys::kAbsent;
        if constexpr (kKind == kRows) {
            best = scan_lane(pc, kRowLane, floor);
        } else {
            const Direction direction = queues_[shared_ ? 0 : pseudochannel_of(pc.first_bank)].direction;
            for (const Lane lane : {kReadLane, kWriteLane})  // plain: the other is empty
                if (!plain_ || static_cast<int>(lane) == static_cast<int>(direction))
                    best = std::min(best, scan_lane(pc, lane, floor));
        }
        return best ^ DramScanKeys::kKeyBias;
    }
    if (simple_) return scan<kKind, DramArbitration::kOldest, false>(pc, floor);
    if (in_order_) return scan<kKind, DramArbitration::kOldest, true>(pc, floor);
    return scan<kKind, DramArbitration::kRoundRobin, false>(pc, floor);
}

template std::uint64_t DramScheduler::least_key<DramScheduler::kColumns>(const Pseudochannel&,
                                                                         DramCycle) const;
template std::uint64_t DramScheduler::least_key<DramScheduler::kRows>(const Pseudochannel&, DramCycle) const;

void DramScheduler::choose_all(Pseudochannel& pc, DramCycle now) {
    choose_columns<false>(pc, now);
    choose<kRowLane, false>(pc, now);
}

// The bests that came before their bus is free. One that does not is the best from any time up to then.
void DramScheduler::choose_again(Pseudochannel& pc, DramCycle now) {
    const bool all = !simple_ || refreshes_pending_ != 0;
    if (all || pc.best[kColumns].time < std::max(now, bus_free_[0])) choose_columns<false>(pc, now);
    if (all || pc.best[kRows].time < std::max(now, bus_free_[bus_of_lane_[kRowLane]]))
        choose<kRowLane, false>(pc, now);
}

// A refresh goes before other row commands.
void DramScheduler::choose_refresh(Pseudochannel& pc, DramCycle now) {
    const auto index = static_cast<std::uint32_t>(&pc - pseudochannels_.begin());
    for (std::uint32_t r = index * config_.ranks; r < (index + 1) * config_.ranks; ++r) {
        if (!refresh_units_[r].pending) continue;
        const DramCycle time = std::max(now, refresh_command_time(refresh_units_[r]));
        if (time > pc.best[kRows].time || time == kNoCycle) continue;
        pc.best[kRows] = {time, kRefreshLane << kLaneShift | r};
    }
}

// The bests after only the candidates of `bank` have changed.
template <bool kUsual>
void DramScheduler::reconsider(Pseudochannel& pc, std::uint32_t bank, DramCycle now) {
    if (!kUsual && !simple_) return choose_all(pc, now);
    if (pc.best[kColumns].bank() == bank)
        choose_columns<kUsual>(pc, now);
    else
        reconsider_columns<kUsual>(pc, bank, now);
    if (pc.best[kRows].bank() == bank || refreshes_pending_ != 0)
        choose<kRowLane, kUsual>(pc, now);
    else if (has_candidate(kRowLane, bank))
        reconsider_lane(pc.best[kRows], kRowLane, bank, now);
}

template void DramScheduler::reconsider<true>(Pseudochannel&, std::uint32_t, DramCycle);
template void DramScheduler::reconsider<false>(Pseudochannel&, std::uint32_t, DramCycle);

}  // namespace ropsim
