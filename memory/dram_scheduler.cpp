// Command decisions: what a cycle does, and the direction of the bus.
#include "memory/dram_scheduler.h"

#include "base/error.h"

#include <algorithm>
#include <bit>

namespace ropsim {

DramScheduler::DramScheduler(const DramConfig& config)
    : mixed_(config.bank_queue != 0 || config.write_drain == DramWriteDrain::kNone),
      shared_(config.shared_queue),
      in_order_(config.scheduler == DramScheduling::kInOrder),
      simple_(!in_order_ && config.arbitration != DramArbitration::kRoundRobin),
      plain_(!in_order_ && !mixed_ && !config.activated_leave_queue),
      usual_(false),
      drains_to_low_(config.write_drain != DramWriteDrain::kSnapshot && config.write_batch == 0),
      bus_of_lane_{0, 0, static_cast<std::uint8_t>(config.separate_buses ? 1 : 0)},
      pseudochannel_shift_(std::countr_zero(config.banks_of_pseudochannel())),
      groups_(config.ranks * config.bank_groups),
      burst_shift_(std::countr_zero(config.burst_bytes())),
      entry_shift_(burst_shift_),
      pseudochannels_(config.pseudochannels),
      queues_(config.queue_pairs()),
      pieces_left_(config.max_reads(), 0),
      banks_(config),
      config_(config),
      map_(config, "dram.mapping") {
    const std::uint32_t ranks = config.pseudochannels * config.ranks;
    CHECK(config.banks() <= DramBanks::kMaxBanks && ranks <= DramBanks::kMaxRanks);
    const std::uint64_t longest = std::uint64_t{config.page_timeout} + config.trfc + config.trfcpb +
                                  config.trrefd + config.tfaw + config.t32aw + config.trc + config.tras +
                                  config.trp + config.cl + config.cwl + config.burst + config.twr +
                                  config.twtr_l + config.trtw + config.front_cycles + 1024;
    if (simple_ && longest < DramScanKeys::kFarthest) scan_ = dram_scan_for(config.banks_per_group);
    usual_ = plain_ && ranks == 1 && scan_ != nullptr;
    const std::size_t slots =
        queues_.size() * (config.read_queue + config.write_queue) +
        std::size_t{config.banks()} * (config.bank_queue + (config.activated_leave_queue ? 1 : 0));
    CHECK(slots < kNone, "{} accesses", slots);
    if (!config.queue_bursts) entry_shift_ = std::countr_zero(map_.contiguous_bytes());
    access_.resize(slots);
    for (std::uint32_t i = 0; i < config.pseudochannels; ++i) {
        pseudochannels_[i].first_bank = i << pseudochannel_shift_;
        pseudochannels_[i].first_group = i * groups_;
    }
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

// Issues the commands that are due at `now`, and returns the time of the next. Pseudo-channels compete for
// the buses by the order of their commands.
template <bool kUsual>
inline DramCycle DramScheduler::issue_due(DramCycle now) {
    while (true) {
        Pseudochannel* winner = pseudochannels_.data();
        const Best* best = &first_of<kUsual>(*winner);
        if constexpr (!kUsual)
            for (std::size_t i = 1; i < pseudochannels_.size(); ++i) {
                const Best& other = first_of<false>(pseudochannels_[i]);
                if (!before(other, *best)) continue;
                winner = &pseudochannels_[i];
                best = &other;
            }
        if (best->time > now) return best->time;
        const std::size_t bus = bus_of_lane_[best->lane == kRefreshLane ? std::size_t{kRowLane} : best->lane];
        if (kUsual || bus_free_[bus] <= now)
            issue<kUsual>(*winner, *best, now);
        else  // another pseudo-channel was faster
            choose_again(*winner, now);
    }
}

// Sets next_; `first` is first_time().
template <bool kUsual>
inline void DramScheduler::plan(DramCycle now, DramCycle first) {
    if (idle()) {
        next_ = kNoCycle;
        return;
    }
    DramCycle next = std::min(next_due_, first);
    const auto with_drain = [&](const Queues& q) {
        if (q.unsettled && q.count[kReads] == 0 && q.direction == kReads && q.count[kWrites] != 0)
            next = std::min(next, drain_time(q));
    };
    if constexpr (kUsual)
        with_drain(queues_[0]);
    else if (mixed_)
        next = std::min(next, next_move(now));
    else
        for (const Queues& q : queues_) with_drain(q);
    next_ = std::max(next, now);
}

void DramScheduler::run(DramCycle end) {
    if (usual_)
        run_as<true>(end);
    else
        run_as<false>(end);
}

template <bool kUsual>
void DramScheduler::run_as(DramCycle end) {
    while (next_ < end) step_as<kUsual>(next_);
}

void DramScheduler::step(DramCycle now) {
    if (idle())
        account<false>(now);
    else if (usual_)
        step_as<true>(now);
    else
        step_as<false>(now);
}

// Requires accesses.
template <bool kUsual>
inline void DramScheduler::step_as(DramCycle now) {
    account<kUsual>(now);
    if (now >= next_due_) [[unlikely]]
        start_refreshes(now);
    if constexpr (kUsual) {
        if (queues_[0].unsettled) update_direction(queues_[0], now);
    } else {
        for (Queues& queues : queues_)
            if (queues.unsettled) update_direction(queues, now);
    }
    DramCycle first = issue_due<kUsual>(now);
    if (!kUsual && config_.bank_queue != 0) {
        for (Queues& queues : queues_)
            if (queues.last_move != now)
                if (const std::uint16_t slot = movable(queues); slot != kNone) move(queues, slot, now);
        first = first_time<false>();
    }
    plan<kUsual>(now, first);
}

bool DramScheduler::push(const DramRequest& request, DramCycle arrival, DramCycle now) {
    return usual_ ? push_as<true>(request, arrival, now) : push_as<false>(request, arrival, now);
}

template <bool kUsual>
bool DramScheduler::push_as(const DramRequest& request, DramCycle arrival, DramCycle now) {
    if (idle()) catch_up(now);
    account<kUsual>(now);
    full_reads_ = nullptr;
    const bool admitted = admit<kUsual>(request, arrival, now);
    if (idle()) return admitted;
    bool turned = false;
    if constexpr (kUsual)
        turned = update_direction(queues_[0], now);
    else
        for (Queues& queues : queues_) turned |= update_direction(queues, now);
    if (!admitted && !turned) return false;
    plan<kUsual>(now, first_time<kUsual>());
    return admitted;
}

// Decides between reads and writes; true when it changed its mind (all candidates are then new).
bool DramScheduler::reconsider_direction(Queues& q, DramCycle now) {
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

void DramScheduler::set_direction(Queues& q, Direction direction) {
    q.direction = direction;
    if (direction == kReads)
        q.batch = q.count[kReads];
    else
        q.batch = config_.write_drain == DramWriteDrain::kSnapshot ? q.count[kWrites] : config_.write_batch;
    if (direction == kWrites) q.write_queue_short = false;
}

// The bests that came before their bus is free. One that does not is the best from any time up to then.
void DramScheduler::choose_again(Pseudochannel& pc, DramCycle now) {
    const bool all = !simple_ || refreshes_pending_ != 0;
    if (all || pc.best[kColumns].time < std::max(now, bus_free_[0])) choose<kColumns, false>(pc, now);
    if (all || pc.best[kRows].time < std::max(now, bus_free_[bus_of_lane_[kRowLane]])) choose<kRows, false>(pc, now);
}

// The next thing that happens to the queues, where reads and writes are mixed: an access moves into its
// bank's queue, or a drain begins.
DramCycle DramScheduler::next_move(DramCycle now) const {
    DramCycle next = kNoCycle;
    if (config_.write_drain != DramWriteDrain::kNone)
        for (const Queues& q : queues_)
            if (q.count[kReads] == 0 && q.count[kWrites] != 0 && q.direction == kReads)
                next = std::min(next, drain_time(q));
    if (config_.bank_queue != 0)
        for (const Queues& q : queues_)
            if (movable(q) != kNone) next = std::min(next, q.last_move == now ? now + 1 : now);
    return next;
}

}  // namespace ropsim
