// Command decisions: direction of the bus, and the next command of each pseudo-channel.
#include "memory/dram_scheduler.h"

#include "base/error.h"

#include <algorithm>
#include <bit>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace ropsim {

DramScheduler::DramScheduler(const DramConfig& config)
    : config_(config),
      mixed_(config.bank_queue != 0 || config.write_drain == DramWriteDrain::kNone),
      shared_(config.shared_queue),
      pseudochannel_shift_(std::countr_zero(config.banks_of_pseudochannel())),
      in_order_(config.scheduler == DramScheduling::kInOrder),
      simple_(!in_order_ && config.arbitration != DramArbitration::kRoundRobin),
      plain_(!in_order_ && !mixed_ && !config.activated_leave_queue),
      groups_(config.ranks * config.bank_groups),
      burst_shift_(std::countr_zero(config.burst_bytes())),
      entry_shift_(burst_shift_),
      map_(config, "dram.mapping"),
      banks_(config),
      queues_(config.queue_pairs()),
      pieces_left_(config.max_reads(), 0),
      pseudochannels_(config.pseudochannels),
      bus_of_lane_{0, 0, static_cast<std::uint8_t>(config.separate_buses ? 1 : 0)} {
    const std::uint32_t ranks = config.pseudochannels * config.ranks;
    CHECK(config.banks() <= DramBanks::kMaxBanks && ranks <= DramBanks::kMaxRanks);
#ifdef __SSE2__
    const std::uint64_t longest = std::uint64_t{config.page_timeout} + config.trfc + config.trfcpb +
                                  config.trrefd + config.tfaw + config.t32aw + config.trc + config.tras +
                                  config.trp + config.cl + config.cwl + config.burst + config.twr +
                                  config.twtr_l + config.trtw + config.front_cycles + 1024;
    pairs_ = simple_ && config.banks_per_group >= 2 && longest < kScanned;
#endif
    const std::size_t slots =
        queues_.size() * (config.read_queue + config.write_queue) +
        std::size_t{config.banks()} * (config.bank_queue + (config.activated_leave_queue ? 1 : 0));
    CHECK(slots < kNone, "{} accesses", slots);
    if (!config.queue_bursts) entry_shift_ = std::countr_zero(map_.contiguous_bytes());
    access_.resize(slots + kMaxPieces);
    promoted_.fill(kNone);
    for (CandidateKeys& keys : keys_) {
        keys.time.fill(kTimeBias);
        keys.order.fill(kAbsent);
    }
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
    DramCycle first = issue_due(now);
    while (first <= now) first = issue_due(now);
    if (config_.bank_queue != 0) {
        for (Queues& queues : queues_)
            if (queues.last_move != now)
                if (const std::uint16_t slot = movable(queues); slot != kNone) move(queues, slot, now);
        first = first_time();
    }
    plan(now, first);
}

void DramScheduler::update_directions(DramCycle now) {
    for (Queues& queues : queues_) update_direction(queues, now);
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

// When writes go though too few are queued for a forced drain, if no read comes meanwhile.
DramCycle DramScheduler::drain_time(const Queues& q) const {
    return q.count[kWrites] >= config_.write_idle_min ? q.reads_gone : q.reads_gone + config_.write_idle;
}

void DramScheduler::set_direction(Queues& q, Direction direction) {
    q.direction = direction;
    if (direction == kReads)
        q.batch = q.count[kReads];
    else
        q.batch = config_.write_drain == DramWriteDrain::kSnapshot ? q.count[kWrites] : config_.write_batch;
    if (direction == kWrites) q.write_queue_short = false;
}

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
            const Candidate& candidate = candidate_[lane][bank];
            std::uint64_t order = candidate.order;
            if constexpr (kArbitration == DramArbitration::kRoundRobin)
                order = (order & kTurnMask) | std::uint64_t{(bank - pc.next_turn) & bank_mask} << kTurnShift;
            if constexpr (kInOrder) {
                best = std::min(best, order);
            } else {
                const DramCycle time =
                    std::max(std::max(candidate.time, banks_.limit(candidate.limit)), floor);
                best = std::min(best, std::min(time - floor, kFar) << kTimeShift | order);
            }
        }
    }
    return best;
}

// What scan_pairs() makes of one candidate.
inline std::uint64_t DramScheduler::key_of(std::size_t lane, int bank, DramCycle floor) const {
    const Candidate& candidate = candidate_[lane][static_cast<std::size_t>(bank)];
    const DramCycle time = std::max(std::max(candidate.time, banks_.limit(candidate.limit)), floor);
    return ((time - floor) << kTimeShift | candidate.order) + kKeyBias;
}

// The same over one lane, two neighbouring banks at a time, without a branch for those that have no
// candidate. kKeyBias is on top.
inline std::uint64_t DramScheduler::scan_pairs(const Pseudochannel& pc, std::size_t lane, DramCycle floor) const {
#ifdef __SSE2__
    const auto load = [](const std::uint64_t& from) {
        return _mm_load_pd(reinterpret_cast<const double*>(&from));
    };
    const auto both = [](std::uint64_t value) {
        return _mm_castsi128_pd(_mm_set1_epi64x(static_cast<long long>(value)));
    };
    const CandidateKeys& keys = keys_[lane];
    const DramCycle* limit = banks_.limits(lane == kRowLane     ? DramCommand::kActivate
                                           : lane == kWriteLane ? DramCommand::kWrite
                                                                : DramCommand::kRead);
    const std::uint32_t in_group = config_.banks_per_group;
    const auto index = static_cast<std::uint32_t>(&pc - pseudochannels_.data());
    std::uint32_t bank = index << pseudochannel_shift_;
    limit += index * groups_;
    const __m128d low = both(kTimeBias + floor);
    __m128d best = both(kAbsent);
    for (std::uint32_t group = groups_; group != 0; --group, ++limit) {
        const __m128d bound = both(kTimeBias + *limit);
        for (const std::uint32_t end = bank + in_group; bank < end; bank += 2) {
            const __m128d time = _mm_max_pd(_mm_and_pd(bound, load(keys.bound[bank])), load(keys.time[bank]));
            const __m128i ahead =
                _mm_sub_epi64(_mm_castpd_si128(_mm_max_pd(time, low)), _mm_castpd_si128(low));
            const __m128d key = _mm_or_pd(_mm_castsi128_pd(_mm_slli_epi64(ahead, kTimeShift)),
                                          load(keys.order[bank]));
            best = _mm_min_pd(best, key);
        }
    }
    best = _mm_min_sd(best, _mm_unpackhi_pd(best, best));
    return static_cast<std::uint64_t>(_mm_cvtsi128_si64(_mm_castpd_si128(best)));
#else
    CHECK(false, "{} {}", lane, floor + pc.present);
    return 0;
#endif
}

// Finds the command of one kind that comes first from `now` on, as things stand.
template <DramScheduler::Kind kKind>
void DramScheduler::choose(Pseudochannel& pc, DramCycle now) {
    Best& found = pc.best[kKind];
    found.time = kNoCycle;
    const DramCycle floor = std::max(now, bus_free_[bus_of_lane_[kKind == kRows ? kRowLane : 0]]);
    if ((kKind == kRows ? pc.lanes[kRowLane] : pc.lanes[0] | pc.lanes[1]) != 0) {
        std::uint64_t best = 0;
        if (pairs_) [[likely]] {
            best = kAbsent;
            for (std::size_t lane = kKind == kColumns ? 0 : kRowLane;
                 lane < (kKind == kColumns ? kRowLane : kLanes); ++lane) {
                const std::uint64_t banks = pc.lanes[lane];
                if (banks == 0) continue;
                const std::uint64_t key = (banks & (banks - 1)) == 0
                                              ? key_of(lane, std::countr_zero(banks), floor)
                                              : scan_pairs(pc, lane, floor);
                best = std::min(best, key);
            }
            best ^= kKeyBias;
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
            const Candidate& candidate = candidate_[found.lane][found.bank];
            found.time = std::max({floor, candidate.time, banks_.limit(candidate.limit)});
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
    const Candidate& candidate = candidate_[lane][bank];
    const DramCycle time =
        std::max({candidate.time, banks_.limit(candidate.limit), bus_free_[bus_of_lane_[lane]], now});
    if (time > best.time || (time == best.time && candidate.order > best.order)) return;
    best = {time, candidate.order, static_cast<std::uint8_t>(lane), static_cast<std::uint8_t>(bank)};
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

// Of the commands.
DramCycle DramScheduler::first_time() const {
    DramCycle first = kNoCycle;
    for (const Pseudochannel& pc : pseudochannels_) first = std::min(first, first_of(pc).time);
    return first;
}

// The bests that came before their bus is free. One that does not is the best from any time up to then.
void DramScheduler::choose_again(Pseudochannel& pc, DramCycle now) {
    const bool all = !simple_ || refreshes_pending_ != 0;
    if (all || pc.best[kColumns].time < std::max(now, bus_free_[0])) choose<kColumns>(pc, now);
    if (all || pc.best[kRows].time < std::max(now, bus_free_[bus_of_lane_[kRowLane]])) choose<kRows>(pc, now);
}

// Sets next_; `first` is first_time().
void DramScheduler::plan(DramCycle now, DramCycle first) {
    next_ = kNoCycle;
    if (idle()) return;
    next_ = std::min(next_due_, first);
    if (config_.write_drain != DramWriteDrain::kNone)
        for (const Queues& queues : queues_)
            if (queues.count[kReads] == 0 && queues.count[kWrites] != 0 && queues.direction == kReads)
                next_ = std::min(next_, std::max(now, drain_time(queues)));
    if (config_.bank_queue != 0)
        for (const Queues& queues : queues_)
            if (movable(queues) != kNone) next_ = std::min(next_, queues.last_move == now ? now + 1 : now);
    next_ = std::max(next_, now);
}

}  // namespace ropsim
