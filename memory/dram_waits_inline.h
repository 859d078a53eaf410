// What each cycle of a pseudo-channel without a command is spent on.
#pragma once

#include "memory/dram_scheduler.h"

#include <algorithm>
#include <array>

namespace ropsim {

// What a command waits for, as far as it matters.
struct DramWait {
    bool bus;       // the command bus is free later than all else allows
    bool banks;     // rules between banks hold it longer than those of its own
    bool again;     // it is the command of the last column
    bool refresh;   // its bank was last closed by a refresh
    bool unwanted;  // no access wants it
};

constexpr DramLabel label_of(DramCommand command, DramWait wait) {
    if (wait.bus) return DramLabel::kCommandBus;
    switch (command) {
        case DramCommand::kRead:
        case DramCommand::kWrite:
            if (!wait.banks) return DramLabel::kActivate;
            return wait.again ? DramLabel::kColumnGap : DramLabel::kTurnaround;
        case DramCommand::kActivate:
            if (wait.banks) return DramLabel::kActivationWindow;
            return wait.refresh ? DramLabel::kRefresh : DramLabel::kPrecharge;
        default:
            return wait.unwanted ? DramLabel::kWriteWait : DramLabel::kPrecharge;
    }
}

// label_of() by command and the bits of a wait: any is as likely as another, and is looked up without a
// branch.
inline constexpr std::size_t kDramWaits = 32;
inline constexpr auto kDramWaitLabels = [] {
    std::array<DramLabel, 4 * kDramWaits> labels{};
    for (std::size_t i = 0; i < labels.size(); ++i)
        labels[i] = label_of(static_cast<DramCommand>(i / kDramWaits),
                             {(i & 1) != 0, (i & 2) != 0, (i & 4) != 0, (i & 8) != 0, (i & 16) != 0});
    return labels;
}();

template <bool kUsual>
inline DramLabel DramScheduler::reason_to_wait(const Pseudochannel& pc, const Best& best) const {
    const Candidate& candidate = candidate_[best.lane()][best.bank()];
    const DramCycle limit = banks_.limit<kUsual>(candidate.command, best.bank());
    const DramCycle own = keys_[best.lane()].time_of(best.bank());
    const auto bit = [](bool holds, int number) { return static_cast<std::size_t>(holds) << number; };
    return kDramWaitLabels[static_cast<std::size_t>(candidate.command) * kDramWaits +
                           (bit(bus_free_[bus_of_lane_[best.lane()]] > std::max(own, limit), 0) |
                            bit(limit > own, 1) | bit(candidate.command == pc.last_column, 2) |
                            bit(own <= pc.refresh_end, 3) | bit(candidate.slot == kNone, 4))];
}

// What the pseudo-channel waits for now: its first command.
template <bool kUsual>
inline DramLabel DramScheduler::reason_of(const Pseudochannel& pc) const {
    if (pc.present == 0) return DramLabel::kIdle;
    const Best& best = first_of<kUsual>(pc);
    if (best.time == kNoCycle) return refreshes_pending_ != 0 ? DramLabel::kRefresh : DramLabel::kWriteWait;
    if (best.lane() == kRefreshLane) return DramLabel::kRefresh;
    return reason_to_wait<kUsual>(pc, best);
}

// Labels the cycles before `until`, of which no command owns the last.
template <bool kUsual>
inline void DramScheduler::account_wait(Pseudochannel& pc, DramCycle until) {
    if (pc.labelled >= until) return;
    statistics_.label_cycles[static_cast<std::size_t>(reason_of<kUsual>(pc))] += until - pc.labelled;
    pc.labelled = until;
}

// Labels all cycles before `until`.
template <bool kUsual>
inline void DramScheduler::account(DramCycle until) {
    if constexpr (kUsual)
        account_wait<true>(pseudochannels_[0], until);
    else
        account_all(until);
}

}  // namespace ropsim
