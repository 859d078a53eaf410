// The bytes of requests, what each cycle of a pseudo-channel is spent on, and the closing of the accounts.
#include "base/error.h"
#include "memory/dram_scheduler.h"

#include <algorithm>

namespace ropsim {

inline DramLabel DramScheduler::reason_to_wait(const Pseudochannel& pc, const Best& best) const {
    const Candidate& candidate = candidate_[best.bank][best.lane];
    const DramCycle limit = banks_.limit(candidate.limit);
    const DramCycle own = keys_[best.lane].time_of(best.bank);
    if (bus_free_[bus_of_lane_[best.lane]] > std::max(own, limit)) return DramLabel::kCommandBus;
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
inline DramLabel DramScheduler::reason_of(const Pseudochannel& pc) const {
    if (pc.present == 0) return DramLabel::kIdle;
    const Best& best = first_of(pc);
    if (best.time == kNoCycle) return refreshes_pending_ != 0 ? DramLabel::kRefresh : DramLabel::kWriteWait;
    if (best.lane == kRefreshLane) return DramLabel::kRefresh;
    return reason_to_wait(pc, best);
}

// Labels all cycles before `until`, which some are.
void DramScheduler::account_span(DramCycle until) {
    const DramCycle span = until - accounted_;
    accounted_ = until;
    statistics_.read_queue_sum += span * present_[kReads];
    statistics_.write_queue_sum += span * present_[kWrites];
    auto& labels = statistics_.label_cycles;
    for (Pseudochannel& pc : pseudochannels_) {
        const DramCycle reads = std::min(span, pc.owned[kReads]);
        const DramCycle writes = std::min(span - reads, pc.owned[kWrites]);
        pc.owned[kReads] -= reads;
        pc.owned[kWrites] -= writes;
        labels[static_cast<std::size_t>(DramLabel::kReadData)] += reads;
        labels[static_cast<std::size_t>(DramLabel::kWriteData)] += writes;
        if (const DramCycle left = span - reads - writes; left != 0)
            labels[static_cast<std::size_t>(reason_of(pc))] += left;
    }
}

void DramScheduler::count_request(const DramRequest& request, std::uint64_t bursts, std::uint64_t forwarded) {
    auto& clients = request.write ? statistics_.write : statistics_.read;
    DramBytes& bytes = clients[request.surface][static_cast<std::size_t>(request.cause)];
    ++(request.write ? statistics_.writes : statistics_.reads);
    bytes.useful += request.bytes;
    bytes.bus += bursts * config_.burst_bytes();
    bytes.forwarded += forwarded;
    if (forwarded != 0) ++(request.write ? statistics_.merged_writes : statistics_.forwarded_reads);
}

void DramScheduler::finish(DramCycle end) {
    CHECK(idle(), "{} accesses still queued", present_[kReads] + present_[kWrites]);
    end = std::max({end, last_data_, accounted_});
    catch_up(end);
    account(end);
    statistics_.cycles = end;
    statistics_.bus_cycles = end * config_.pseudochannels;
    statistics_.rank_cycles = statistics_.bus_cycles * config_.ranks;
    statistics_.rank_active_cycles = banks_.active_cycles(end);
    statistics_.check(config_.burst_bytes(), config_.burst);
}

}  // namespace ropsim
