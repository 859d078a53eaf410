// Command decisions: direction of the bus, the next command of each pseudo-channel, and what each waiting
// cycle is spent on.
#include "memory/dram_scheduler.h"

#include "base/error.h"

#include <algorithm>
#include <bit>

namespace ropsim {

DramScheduler::DramScheduler(const DramConfig& config)
    : config_(config),
      mixed_(config.bank_queue != 0 || config.write_drain == DramWriteDrain::kNone),
      shared_(config.shared_queue),
      pseudochannel_shift_(std::countr_zero(config.banks_of_pseudochannel())),
      map_(config, "dram.mapping"),
      banks_(config),
      queues_(config.queue_pairs()),
      pieces_left_(config.max_reads(), 0),
      pseudochannels_(config.pseudochannels),
      bus_of_lane_{0, 0, static_cast<std::uint8_t>(config.separate_buses ? 1 : 0)} {
    const std::uint32_t ranks = config.pseudochannels * config.ranks;
    CHECK(config.banks() <= DramBanks::kMaxBanks && ranks <= DramBanks::kMaxRanks);
    const std::size_t slots = queues_.size() * (config.read_queue + config.write_queue) +
                              config.banks() * (config.bank_queue + (config.activated_leave_queue ? 1 : 0));
    CHECK(slots < kNone, "{} accesses", slots);
    access_.resize(slots);
    promoted_.fill(kNone);
    for (std::size_t slot = slots; slot > 0; --slot)
        free_slots_.push_back(static_cast<std::uint16_t>(slot - 1));
    finished_.reserve(64);
    if (config.refresh == DramRefresh::kNone) return;
    const bool by_bank = config.refresh == DramRefresh::kPerBank;
    const DramCycle interval = by_bank ? config.trefipb : config.trefi;
    if (interval == 0) return;
    refresh_units_.resize(ranks);
    for (std::uint32_t r = 0; r < ranks; ++r) {
        refresh_units_[r].due = interval * (r + 1) / ranks;
        refresh_units_[r].bank = r * config.banks_of_rank();
    }
    find_next_due();
}

void DramScheduler::step(DramCycle now) {
    account(now);
    if (idle()) return;
    if (now >= next_due_) [[unlikely]]
        start_refreshes(now);
    update_directions(now);
    while (issue_due(now)) {
    }
    if (config_.bank_queue != 0)
        for (Queues& queues : queues_)
            if (queues.last_move != now)
                if (const std::uint16_t slot = movable(queues); slot != kNone) move(queues, slot, now);
    plan(now);
}

void DramScheduler::update_directions(DramCycle now) {
    for (Queues& queues : queues_) update_direction(queues, now);
}

// Decides between reads and writes; true when it changed its mind (all candidates are then new).
bool DramScheduler::update_direction(Queues& q, DramCycle now) {
    const std::uint32_t reads = q.count[kReads];
    const std::uint32_t writes = q.count[kWrites];
    const bool snapshot = config_.write_drain == DramWriteDrain::kSnapshot;
    if (config_.write_drain == DramWriteDrain::kNone) return false;
    if (q.direction == kWrites) {
        if (q.hurried != 0) return false;
        if (writes != 0) {
            if (snapshot && q.batch != 0) return false;
            const std::uint32_t low = q.forced_drain ? config_.write_low : config_.write_idle_low;
            // A drain also ends after a batch, so that a stream of writes cannot starve the reads.
            const bool drained = writes <= low || (config_.write_batch != 0 && q.batch == 0);
            if (!snapshot && (reads == 0 || !drained)) return false;
        }
        set_direction(q, kReads);
    } else {
        const bool high = (writes >= config_.write_high || q.write_queue_short) &&
                          (snapshot || config_.write_batch == 0 || q.batch == 0 || reads == 0);
        if (writes == 0 || !(high || q.hurried != 0 || (reads == 0 && now >= drain_time(q)))) return false;
        q.forced_drain = high;
        set_direction(q, kWrites);
    }
    if (!mixed_) refresh_all_candidates(q, now);
    return true;
}

// When writes go though too few are queued for a forced drain, if no read comes meanwhile.
DramCycle DramScheduler::drain_time(const Queues& q) const {
    return q.count[kWrites] >= config_.write_idle_min ? q.reads_gone : q.reads_gone + config_.write_idle;
}

void DramScheduler::set_direction(Queues& q, Direction direction) {
    q.direction = direction;
    if (direction == kReads)
        q.batch = q.count[kReads];
    else
        q.batch =
            config_.write_drain == DramWriteDrain::kSnapshot ? q.count[kWrites] : config_.write_batch;
    if (direction == kWrites) q.write_queue_short = false;
}

// The smallest of (time from now, order) over the candidates, packed into one number, so that the scan has no
// branch to mispredict.
template <DramArbitration kArbitration, bool kInOrder>
std::uint64_t DramScheduler::scan(const Pseudochannel& pc, DramCycle now) const {
    constexpr DramCycle kFar = (DramCycle{1} << (64 - kTimeShift)) - 1;  // beyond every timing
    constexpr int kTurnShift = 33;  // above the age's low bits, which order the candidates of one bank
    constexpr std::uint64_t kTurnMask = ~(((std::uint64_t{1} << kClassShift) - 1) ^
                                          ((std::uint64_t{1} << kTurnShift) - 1));
    const std::uint32_t bank_mask = (1u << pseudochannel_shift_) - 1;
    std::uint64_t best = ~std::uint64_t{0};
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const DramCycle floor = std::max(now, bus_free_[bus_of_lane_[lane]]);
        for (std::uint64_t banks = pc.lanes[lane]; banks != 0; banks &= banks - 1) {
            const auto bank = static_cast<std::uint32_t>(std::countr_zero(banks));
            const Candidate& candidate = candidate_[lane][bank];
            std::uint64_t order = candidate.order;
            if constexpr (kArbitration == DramArbitration::kRoundRobin)
                order = (order & kTurnMask) |
                        std::uint64_t{(bank - pc.next_turn) & bank_mask} << kTurnShift;
            if constexpr (kInOrder) {
                best = std::min(best, order);
            } else {
                const DramCycle time =
                    std::max(std::max(candidate.time, banks_.limit(candidate.limit)), floor);
                best = std::min(best, std::min(time - now, kFar) << kTimeShift | order);
            }
        }
    }
    return best;
}

// Finds the command of a pseudo-channel that comes first from `now` on, as things stand.
void DramScheduler::choose(Pseudochannel& pc, DramCycle now) {
    pc.best_time = kNoCycle;
    if ((pc.lanes[0] | pc.lanes[1] | pc.lanes[2]) != 0) {
        std::uint64_t best = 0;
        const bool in_order = config_.scheduler == DramScheduling::kInOrder;
        if (in_order)
            best = scan<DramArbitration::kOldest, true>(pc, now);
        else if (config_.arbitration == DramArbitration::kRoundRobin)
            best = scan<DramArbitration::kRoundRobin, false>(pc, now);
        else
            best = scan<DramArbitration::kOldest, false>(pc, now);
        pc.best_order = best & ((std::uint64_t{1} << kTimeShift) - 1);
        pc.best_bank = static_cast<std::uint8_t>(best & 63);
        pc.best_lane = static_cast<std::uint8_t>(best >> 6 & 3);
        pc.best_time = now + (best >> kTimeShift);
        if (in_order) {
            const Candidate& candidate = candidate_[pc.best_lane][pc.best_bank];
            pc.best_time = std::max({now, candidate.time, banks_.limit(candidate.limit),
                                     bus_free_[bus_of_lane_[pc.best_lane]]});
        }
    }
    if (refreshes_pending_ == 0) [[likely]]
        return;
    const auto index = static_cast<std::uint32_t>(&pc - pseudochannels_.data());
    for (std::uint32_t r = index * config_.ranks; r < (index + 1) * config_.ranks; ++r) {
        if (!refresh_units_[r].pending) continue;
        const DramCycle time = std::max(now, refresh_command_time(refresh_units_[r]));
        if (time > pc.best_time) continue;
        pc.best_time = time;
        pc.best_order = 0;
        pc.best_lane = kRefreshLane;
        pc.best_bank = static_cast<std::uint8_t>(r);
    }
}

// The same after only the candidates of `bank` have come or become earlier.
void DramScheduler::reconsider(Pseudochannel& pc, std::uint32_t bank, DramCycle now) {
    if (pc.best_time == kNoCycle || pc.best_lane == kRefreshLane || pc.best_bank == bank ||
        config_.arbitration == DramArbitration::kRoundRobin ||
        config_.scheduler == DramScheduling::kInOrder)
        return choose(pc, now);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        if ((pc.lanes[lane] >> bank & 1) == 0) continue;
        const Candidate& candidate = candidate_[lane][bank];
        const DramCycle time = std::max(
            {candidate.time, banks_.limit(candidate.limit), bus_free_[bus_of_lane_[lane]], now});
        if (time > pc.best_time || (time == pc.best_time && candidate.order > pc.best_order)) continue;
        pc.best_time = time;
        pc.best_order = candidate.order;
        pc.best_lane = static_cast<std::uint8_t>(lane);
        pc.best_bank = static_cast<std::uint8_t>(bank);
    }
}

// Sets next_ and the labels of the cycles until then.
void DramScheduler::plan(DramCycle now) {
    next_ = kNoCycle;
    if (idle()) {
        for (Pseudochannel& pc : pseudochannels_) pc.reason = DramLabel::kIdle;
        return;
    }
    next_ = next_due_;
    for (Pseudochannel& pc : pseudochannels_) {
        next_ = std::min(next_, pc.best_time);
        pc.reason = reason_of(pc);
    }
    if (config_.write_drain != DramWriteDrain::kNone)
        for (const Queues& queues : queues_)
            if (queues.count[kReads] == 0 && queues.count[kWrites] != 0 && queues.direction == kReads)
                next_ = std::min(next_, std::max(now, drain_time(queues)));
    if (config_.bank_queue != 0)
        for (const Queues& queues : queues_)
            if (movable(queues) != kNone)
                next_ = std::min(next_, queues.last_move == now ? now + 1 : now);
    next_ = std::max(next_, now);
}

DramLabel DramScheduler::reason_of(const Pseudochannel& pc) const {
    if (pc.present == 0) return DramLabel::kIdle;
    if (pc.best_time == kNoCycle) return DramLabel::kWriteWait;
    if (pc.best_lane == kRefreshLane) return DramLabel::kRefresh;
    return reason_to_wait(pc, candidate_[pc.best_lane][pc.best_bank]);
}

DramLabel DramScheduler::reason_to_wait(const Pseudochannel& pc, const Candidate& candidate) const {
    const DramCycle limit = banks_.limit(candidate.limit);
    if (bus_free_[bus_of_lane_[pc.best_lane]] > std::max(candidate.time, limit))
        return DramLabel::kCommandBus;
    const bool between_banks = limit > candidate.time;
    switch (candidate.command) {
        case DramCommand::kRead:
        case DramCommand::kWrite:
            if (!between_banks) return DramLabel::kActivate;
            return candidate.command == pc.last_column ? DramLabel::kColumnGap : DramLabel::kTurnaround;
        case DramCommand::kActivate:
            if (between_banks) return DramLabel::kActivationWindow;
            return candidate.time <= pc.refresh_end ? DramLabel::kRefresh : DramLabel::kPrecharge;
        default:
            return candidate.slot == kNone ? DramLabel::kWriteWait : DramLabel::kPrecharge;
    }
}

// Labels all cycles before `until`.
void DramScheduler::account(DramCycle until) {
    if (until <= accounted_) return;
    const DramCycle span = until - accounted_;
    statistics_.read_queue_sum += span * present_[kReads];
    statistics_.write_queue_sum += span * present_[kWrites];
    for (Pseudochannel& pc : pseudochannels_) {
        DramCycle left = span;
        for (const DramLabel label : {DramLabel::kReadData, DramLabel::kWriteData}) {
            DramCycle& owned = pc.owned[static_cast<std::size_t>(label)];
            const DramCycle data = std::min(left, owned);
            statistics_.label_cycles[static_cast<std::size_t>(label)] += data;
            owned -= data;
            left -= data;
        }
        statistics_.label_cycles[static_cast<std::size_t>(pc.reason)] += left;
    }
    accounted_ = until;
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
