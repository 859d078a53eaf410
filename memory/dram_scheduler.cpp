// A scheduler's set-up, and the direction of its bus.
#include "base/error.h"
#include "memory/dram_scheduler_inline.h"
#include "memory/dram_waits_inline.h"

#include <algorithm>
#include <bit>

namespace ropsim {

namespace {

// As many accesses as there can be.
std::size_t slots_of(const DramConfig& config) {
    return std::size_t{config.queue_pairs()} * (config.read_queue + config.write_queue) +
           std::size_t{config.banks()} * (config.bank_queue + (config.activated_leave_queue ? 1 : 0));
}

}  // namespace

DramScheduler::DramScheduler(const DramConfig& config)
    : mixed_(config.bank_queue != 0 || config.write_drain == DramWriteDrain::kNone),
      shared_(config.shared_queue),
      in_order_(config.scheduler == DramScheduling::kInOrder),
      simple_(!in_order_ && config.arbitration != DramArbitration::kRoundRobin),
      plain_(!in_order_ && !mixed_ && !config.activated_leave_queue),
      usual_(false),
      snapshot_(config.write_drain == DramWriteDrain::kSnapshot),
      drains_to_low_(!snapshot_ && config.write_batch == 0),
      reads_in_batches_(!snapshot_ && config.write_batch != 0),
      bus_of_lane_{0, 0, static_cast<std::uint8_t>(config.separate_buses ? 1 : 0)},
      data_cycles_{config.read_cycles(), config.write_cycles()},
      pseudochannel_shift_(std::countr_zero(config.banks_of_pseudochannel())),
      groups_(config.ranks * config.bank_groups),
      burst_shift_(std::countr_zero(config.burst_bytes())),
      entry_shift_(burst_shift_),
      read_outcome_(config.read_cycles() + config.back_cycles),
      write_outcome_(config.write_cycles()),
      soonest_outcome_(std::min(read_outcome_, write_outcome_)),
      opening_(std::min(config.activate_to_read(), config.activate_to_write())),
      // Where another rank or pseudo-channel may read after a write of this one: at once.
      write_to_read_outcome_(read_outcome_ + (config.ranks * config.pseudochannels == 1
                                                  ? config.cwl + config.burst + config.twtr_s
                                                  : 0)),
      pseudochannels_(config.pseudochannels),
      queues_(config.queue_pairs()),
      lists_(slots_of(config), 2 * std::size_t{DramBanks::kMaxBanks + config.queue_pairs()}),
      pieces_left_(config.max_reads(), 0),
      range_{0, groups_, config.banks_per_group},
      banks_(config),
      config_(config),
      map_(config, "dram.mapping") {
    const std::uint32_t ranks = config.pseudochannels * config.ranks;
    CHECK(config.banks() <= DramBanks::kMaxBanks && ranks <= DramBanks::kMaxRanks);
    const std::uint64_t longest = std::uint64_t{config.page_timeout} + config.trfc + config.trfcpb +
                                  config.trrefd + config.tfaw + config.t32aw + config.trc + config.tras +
                                  config.trp + config.cl + config.cwl + config.burst + config.twr +
                                  config.twtr_l + config.trtw + config.front_cycles + 1024;
    if (simple_ && longest < DramScanKeys::kFarthest)
        scan_ = {dram_scan_for(config.bank_groups, config.banks_per_group, true),
                 dram_scan_for(groups_, config.banks_per_group, false)};
    usual_ = plain_ && ranks == 1 && scan_[kRows] != nullptr;
    const std::size_t slots = slots_of(config);
    CHECK(slots + lists_.lists() < kNone, "{} accesses", slots);
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

// A row command moves nothing: the column command of its bank follows tRCD later at the earliest. While
// writes go no read does, unless none is left to end the run. Where the bus may turn without another command,
// the next step may bring anything.
inline DramCycle DramScheduler::outcome_of(const Pseudochannel& pc, const Queues& queues) const {
    const DramCycle rows = pc.best[kRows].time;
    const DramCycle column = std::min(pc.best[kColumns].time, rows == kNoCycle ? kNoCycle : rows + opening_);
    const DramCycle outcome = queues.direction == kReads ? read_outcome_
                              : present_[kReads] != 0    ? write_to_read_outcome_
                                                         : write_outcome_;
    return column == kNoCycle ? kNoCycle : column + outcome;
}

DramCycle DramScheduler::next_outcome() const {
    const DramCycle soonest = soonest_outcome();
    if (!plain_ || soonest == kNoCycle) return soonest;
    DramCycle first = kNoCycle;
    if (usual_) {
        if (queues_[0].unsettled) return soonest;
        first = outcome_of(pseudochannels_[0], queues_[0]);
    } else {
        for (std::size_t i = 0; i < pseudochannels_.size(); ++i) {
            const Queues& queues = queues_[shared_ ? 0 : i];
            if (queues.unsettled) return soonest;
            first = std::min(first, outcome_of(pseudochannels_[i], queues));
        }
    }
    return first == kNoCycle ? soonest : std::max(first, soonest);
}

// Decides between reads and writes; true when it changed its mind (all candidates are then new).
bool DramScheduler::reconsider_direction(Queues& q, DramCycle now) {
    const std::uint32_t reads = q.count[kReads];
    const std::uint32_t writes = q.count[kWrites];
    if (config_.write_drain == DramWriteDrain::kNone) return false;
    if (q.direction == kWrites) {
        if (q.hurried != 0) return false;
        if (writes != 0) {
            if (snapshot_ && q.batch != 0) return false;
            const std::uint32_t low = q.forced_drain ? config_.write_low : config_.write_idle_low;
            // A drain also ends after a batch, so that a stream of writes cannot starve the reads.
            const bool drained = writes <= low || (config_.write_batch != 0 && q.batch == 0);
            if (!snapshot_ && (reads == 0 || !drained)) return false;
        }
        set_direction(q, kReads);
    } else {
        const bool high = (writes >= config_.write_high || q.write_queue_short) &&
                          (snapshot_ || config_.write_batch == 0 || q.batch == 0 || reads == 0);
        if (writes == 0 || !(high || q.hurried != 0 || (reads == 0 && now >= drain_time(q)))) return false;
        q.forced_drain = high;
        set_direction(q, kWrites);
    }
    if (usual_) {
        account<true>(now);
        refresh_all_candidates<true>(q, now);
    } else if (!mixed_) {
        refresh_all_candidates<false>(q, now);
    }
    return true;
}

void DramScheduler::set_direction(Queues& q, Direction direction) {
    q.direction = direction;
    if (direction == kReads)
        q.batch = q.count[kReads];
    else
        q.batch = snapshot_ ? q.count[kWrites] : config_.write_batch;
    if (direction == kWrites) q.write_queue_short = false;
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
