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
                const DramCycle ahead = time_of(lane, bank, floor) - floor;
                best = std::min(best, std::min(ahead, kFar) << kTimeShift | order);
            }
        }
    }
    return best;
}

// The same of one lane by scan_, which some bank has.
template <bool kUsual>
inline std::uint64_t DramScheduler::scan_lane(const Pseudochannel& pc, std::size_t lane,
                                              DramCycle floor) const {
    // Lanes of columns are named like their command.
    const DramCommand command = lane == kRowLane ? DramCommand::kActivate : static_cast<DramCommand>(lane);
    const std::uint32_t in_group = config_.banks_per_group;
    const std::uint32_t first = kUsual ? 0 : pc.first_bank;
    const DramCycle* const limits = banks_.limits(command) + (kUsual ? 0 : pc.first_group);
    if (lane == kRowLane) return scan_(keys_[lane], first, groups_, in_group, limits, floor);
    // Every candidate of a rank is bound by its limit.
    const auto of_rank = [&](std::uint32_t rank) {
        const std::uint32_t bank = first + rank * config_.banks_of_rank();
        const DramCycle from = std::max(floor, banks_.rank_limit(command, kUsual ? 0 : banks_.rank_of(bank)));
        return scan_(keys_[lane], bank, config_.bank_groups, in_group,
                     limits + std::size_t{rank} * config_.bank_groups, from) +
               ((from - floor) << kTimeShift);
    };
    if constexpr (kUsual) return of_rank(0);
    std::uint64_t best = DramScanKeys::kAbsent;
    for (std::uint32_t rank = 0; rank < config_.ranks; ++rank) best = std::min(best, of_rank(rank));
    return best;
}

// The same of one kind by whatever does it for this configuration.
template <DramScheduler::Kind kKind, bool kUsual>
inline std::uint64_t DramScheduler::least_key(const Pseudochannel& pc, DramCycle floor) const {
    if (kUsual || scan_ != nullptr) {
        std::uint64_t best = DramScanKeys::kAbsent;
        if constexpr (kKind == kRows)
            best = scan_lane<kUsual>(pc, kRowLane, floor);
        else if constexpr (kUsual)
            best = scan_lane<true>(pc, queues_[0].direction, floor);
        else
            for (const Lane lane : {kReadLane, kWriteLane})
                if (pc.lanes[lane] != 0) best = std::min(best, scan_lane<false>(pc, lane, floor));
        return best ^ DramScanKeys::kKeyBias;
    }
    if (simple_) return scan<kKind, DramArbitration::kOldest, false>(pc, floor);
    if (in_order_) return scan<kKind, DramArbitration::kOldest, true>(pc, floor);
    return scan<kKind, DramArbitration::kRoundRobin, false>(pc, floor);
}

// Finds the command of one kind that comes first from `now` on, as things stand.
template <DramScheduler::Kind kKind, bool kUsual>
void DramScheduler::choose(Pseudochannel& pc, DramCycle now) {
    Best& found = pc.best[kKind];
    if ((kKind == kRows ? pc.lanes[kRowLane] : pc.lanes[0] | pc.lanes[1]) != 0) {
        const DramCycle floor = std::max(now, bus_free_[bus_of_lane_[kKind == kRows ? kRowLane : 0]]);
        const std::uint64_t best = least_key<kKind, kUsual>(pc, floor);
        found.order = best & ((std::uint64_t{1} << kTimeShift) - 1);
        found.bank = static_cast<std::uint8_t>(best & 63);
        found.lane = static_cast<std::uint8_t>(best >> 6 & 3);
        found.time = floor + (best >> kTimeShift);
        if (!kUsual && in_order_) found.time = time_of(found.lane, found.bank, floor);
    } else {
        found.time = kNoCycle;
    }
    if (kKind == kRows && refreshes_pending_ != 0) choose_refresh(pc, now);
}

template void DramScheduler::choose<DramScheduler::kColumns, false>(Pseudochannel&, DramCycle);
template void DramScheduler::choose<DramScheduler::kRows, false>(Pseudochannel&, DramCycle);

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

inline void DramScheduler::reconsider_lane(Best& best, std::size_t lane, std::uint32_t bank, DramCycle now) {
    const DramCycle time = time_of(lane, bank, std::max(bus_free_[bus_of_lane_[lane]], now));
    const std::uint64_t order = keys_[lane].order_of(bank);
    if (time > best.time || (time == best.time && order > best.order)) return;
    best = {time, order, static_cast<std::uint8_t>(lane), static_cast<std::uint8_t>(bank)};
}

template <bool kUsual>
inline void DramScheduler::reconsider_columns(Pseudochannel& pc, std::uint32_t bank, DramCycle now) {
    const auto consider = [&](std::size_t lane) {
        if ((pc.lanes[lane] >> bank & 1) != 0) reconsider_lane(pc.best[kColumns], lane, bank, now);
    };
    if constexpr (kUsual) return consider(queues_[0].direction);
    consider(kReadLane);
    consider(kWriteLane);
}

// The bests after only the candidates of `bank` have changed.
template <bool kUsual>
void DramScheduler::reconsider(Pseudochannel& pc, std::uint32_t bank, DramCycle now) {
    if (!kUsual && !simple_) return choose_all(pc, now);
    if (pc.best[kColumns].bank == bank)
        choose<kColumns, kUsual>(pc, now);
    else
        reconsider_columns<kUsual>(pc, bank, now);
    if (pc.best[kRows].bank == bank || refreshes_pending_ != 0)
        choose<kRows, kUsual>(pc, now);
    else if ((pc.lanes[kRowLane] >> bank & 1) != 0)
        reconsider_lane(pc.best[kRows], kRowLane, bank, now);
}

template void DramScheduler::reconsider<true>(Pseudochannel&, std::uint32_t, DramCycle);
template void DramScheduler::reconsider<false>(Pseudochannel&, std::uint32_t, DramCycle);

// ... and after a command of its was issued, which binds others of its kind. PRE binds none, but was the best
// of its kind.
template <DramScheduler::Kind kKind, bool kUsual>
void DramScheduler::choose_after(Pseudochannel& pc, std::uint32_t bank, DramCycle now) {
    if (!kUsual && !simple_) return choose_all(pc, now);
    choose<kKind, kUsual>(pc, now);
    if constexpr (kKind == kColumns) {
        if (pc.best[kRows].bank == bank || refreshes_pending_ != 0 ||
            pc.best[kRows].time < bus_free_[bus_of_lane_[kRowLane]])
            choose<kRows, kUsual>(pc, now);
        else if ((pc.lanes[kRowLane] >> bank & 1) != 0)
            reconsider_lane(pc.best[kRows], kRowLane, bank, now);
    } else {
        if (pc.best[kColumns].bank == bank || pc.best[kColumns].time < bus_free_[0])
            choose<kColumns, kUsual>(pc, now);
        else
            reconsider_columns<kUsual>(pc, bank, now);
    }
}

template void DramScheduler::choose_after<DramScheduler::kColumns, true>(Pseudochannel&, std::uint32_t,
                                                                         DramCycle);
template void DramScheduler::choose_after<DramScheduler::kColumns, false>(Pseudochannel&, std::uint32_t,
                                                                          DramCycle);
template void DramScheduler::choose_after<DramScheduler::kRows, true>(Pseudochannel&, std::uint32_t,
                                                                      DramCycle);
template void DramScheduler::choose_after<DramScheduler::kRows, false>(Pseudochannel&, std::uint32_t,
                                                                       DramCycle);

}  // namespace ropsim
