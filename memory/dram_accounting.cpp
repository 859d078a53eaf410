// The bytes of requests, what each cycle of a pseudo-channel is spent on, and the closing of the accounts.
#include "base/error.h"
#include "memory/dram_scheduler_inline.h"

#include <algorithm>

namespace ropsim {

template <bool kUsual>
inline DramLabel DramScheduler::reason_to_wait(const Pseudochannel& pc, const Best& best) const {
    const Candidate& candidate = candidate_[best.lane()][best.bank()];
    const DramCycle limit = banks_.limit<kUsual>(candidate.command, best.bank());
    const DramCycle own = keys_[best.lane()].time_of(best.bank());
    if (bus_free_[bus_of_lane_[best.lane()]] > std::max(own, limit)) return DramLabel::kCommandBus;
    const bool between_banks = limit > own;
    switch (candidate.command) {
        case DramCommand::kRead:
        case DramCommand::kWrite:
            if (!between_banks) return DramLabel::kActivate;
            return candidate.command == pc.last_column ? DramLabel::kColumnGap : DramLabel::kTurnaround;
        case DramCommand::kActivate:
            if (between_banks) return DramLabel::kActivationWindow;
            return own <= pc.refresh_end ? DramLabel::kRefresh : DramLabel::kPrecharge;
        default:
            return candidate.slot == kNone ? DramLabel::kWriteWait : DramLabel::kPrecharge;
    }
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
void DramScheduler::account_wait(Pseudochannel& pc, DramCycle until) {
    statistics_.label_cycles[static_cast<std::size_t>(reason_of<kUsual>(pc))] += until - pc.labelled;
    pc.labelled = until;
}

template void DramScheduler::account_wait<true>(Pseudochannel&, DramCycle);
template void DramScheduler::account_wait<false>(Pseudochannel&, DramCycle);

void DramScheduler::finish(DramCycle end) {
    CHECK(idle(), "{} accesses still queued", present_[kReads] + present_[kWrites]);
    end = std::max(end, last_data());
    for (const Pseudochannel& pc : pseudochannels_) end = std::max(end, pc.labelled);
    catch_up(end);
    account<false>(end);
    statistics_.cycles = end;
    statistics_.bus_cycles = end * config_.pseudochannels;
    statistics_.rank_cycles = statistics_.bus_cycles * config_.ranks;
    statistics_.rank_active_cycles = banks_.active_cycles(end);
    statistics_.check(config_.burst_bytes(), config_.burst);
}

}  // namespace ropsim
