// Command decisions: direction of the bus, one candidate a bank, refresh, and what each waiting cycle is
// spent on.
#include "memory/dram_scheduler.h"

#include "base/error.h"

#include <algorithm>
#include <bit>

namespace ropsim {

DramScheduler::DramScheduler(const DramConfig& config)
    : config_(config),
      bank_count_(config.banks()),
      map_(config, "dram.mapping"),
      banks_(config),
      pieces_left_(config.read_queue, 0) {
    CHECK(config.read_queue + config.write_queue <= kMaxSlots && config.banks() <= DramBanks::kMaxBanks &&
          config.bank_groups <= DramBanks::kMaxGroups);
    finished_.reserve(kMaxSlots);
    if (config_.trefi != 0) refresh_due_ = config_.trefi;
}

void DramScheduler::step(DramCycle now) {
    account(now);
    if (idle()) return;
    if (refresh_due(now)) {
        if (now >= refresh_command_time()) issue_refresh_command(now);
        if (!refresh_due(now)) {
            update_direction(now);
            refresh_all_candidates(now);
            choose(now);
        }
    } else {
        if (update_direction(now)) choose(now);
        if (best_time_ <= now) {
            issue(best_bank_, now);
            update_direction(now);
            choose(now);
        }
    }
    plan(now);
}

// Decides between reads and writes; true when it changed its mind (all candidates are then new).
bool DramScheduler::update_direction(DramCycle now) {
    const std::uint32_t reads = count_[kReads];
    const std::uint32_t writes = count_[kWrites];
    if (direction_ == kWrites) {
        if (hurried_ != 0) return false;
        // A forced drain also ends after a queue's worth, so that a stream of writes cannot starve the reads.
        const bool drained = !forced_drain_ || writes <= config_.write_low || batch_ == 0;
        if (writes != 0 && (reads == 0 || !drained)) return false;
        set_direction(kReads);
    } else {
        const bool high = (writes >= config_.write_high || write_queue_short_) && (batch_ == 0 || reads == 0);
        const bool lonely = reads == 0 && now >= reads_gone_ + config_.write_idle;
        if (writes == 0 || !(high || lonely || hurried_ != 0)) return false;
        forced_drain_ = high;
        set_direction(kWrites);
    }
    refresh_all_candidates(now);
    return true;
}

void DramScheduler::set_direction(Direction direction) {
    direction_ = direction;
    batch_ = direction == kReads ? count_[kReads] : config_.write_queue;
    if (direction == kWrites) write_queue_short_ = false;
}

void DramScheduler::refresh_candidate(std::uint32_t bank, DramCycle now) {
    Candidate& candidate = candidate_[bank];
    std::uint64_t slots = bank_slots_[direction_][bank];
    if (slots == 0) {
        candidate.time = kNoCycle;
        active_banks_ &= ~(1u << bank);
        return;
    }
    const std::uint32_t row = banks_.open_row(bank);
    std::uint32_t oldest_age = ~0u, hit_age = ~0u;
    int oldest = 0, hit = -1;
    for (; slots != 0; slots &= slots - 1) {
        const int slot = std::countr_zero(slots);
        const Access& access = access_[static_cast<std::size_t>(slot)];
        if (access.age < oldest_age) oldest_age = access.age, oldest = slot;
        if (access.row == row && access.age < hit_age) hit_age = access.age, hit = slot;
    }
    // Hits overtake older accesses to other rows only until those reach the age cap.
    const bool aged = now - access_[static_cast<std::size_t>(oldest)].arrival > config_.age_cap;
    if (aged && hit != oldest) hit = -1;
    if (hit >= 0) {
        candidate.command = direction_ == kReads ? DramCommand::kRead : DramCommand::kWrite;
        candidate.slot = static_cast<std::uint8_t>(hit);
        candidate.order = std::uint64_t{hit_age} << kBankBits | bank;
    } else {
        candidate.command = row == DramBanks::kClosed ? DramCommand::kActivate : DramCommand::kPrecharge;
        candidate.slot = static_cast<std::uint8_t>(oldest);
        candidate.order = std::uint64_t{oldest_age} << kBankBits | bank | (aged ? 0 : kRowCommand);
    }
    candidate.time = banks_.bank_time(candidate.command, bank);
    candidate.limit = banks_.limit_index(candidate.command, bank);
    active_banks_ |= 1u << bank;
}

void DramScheduler::refresh_all_candidates(DramCycle now) {
    for (std::uint32_t bank = 0; bank < bank_count_; ++bank) refresh_candidate(bank, now);
}

// Finds the command that comes first from `now` on, as things stand: earliest time, then order. Both are
// packed into one number, so that the scan over the banks has no branch to mispredict.
void DramScheduler::choose(DramCycle now) {
    constexpr int kTimeShift = kBankBits + kAgeBits + 1;
    constexpr DramCycle kFar = (DramCycle{1} << (64 - kTimeShift)) - 1;  // beyond every timing; idle banks
    const DramCycle floor = std::max(now, command_free_);
    std::uint64_t best = ~std::uint64_t{0};
    for (std::uint32_t banks = active_banks_; banks != 0; banks &= banks - 1) {
        const Candidate& candidate = candidate_[static_cast<std::size_t>(std::countr_zero(banks))];
        const DramCycle time = std::max(std::max(candidate.time, banks_.limit(candidate.limit)), floor);
        best = std::min(best, std::min(time - floor, kFar) << kTimeShift | candidate.order);
    }
    best_time_ = active_banks_ == 0 ? kNoCycle : floor + (best >> kTimeShift);
    best_order_ = best & ((std::uint64_t{1} << kTimeShift) - 1);
    best_bank_ = static_cast<std::uint32_t>(best & ((1u << kBankBits) - 1));
}

// The same after only `bank` has changed.
void DramScheduler::reconsider(std::uint32_t bank, DramCycle now) {
    if (bank == best_bank_ || active_banks_ == 0) return choose(now);
    const Candidate& candidate = candidate_[bank];
    if (candidate.time == kNoCycle) return;
    const DramCycle time = std::max({candidate.time, banks_.limit(candidate.limit), command_free_, now});
    if (time > best_time_ || (time == best_time_ && candidate.order > best_order_)) return;
    best_time_ = time;
    best_order_ = candidate.order;
    best_bank_ = bank;
}

// Sets next_ and the label of the cycles until then.
void DramScheduler::plan(DramCycle now) {
    if (idle()) {
        next_ = kNoCycle;
        reason_ = DramLabel::kIdle;
    } else if (refresh_due(now)) {
        next_ = std::max(now, refresh_command_time());
        reason_ = DramLabel::kRefresh;
    } else if (active_banks_ == 0) {
        next_ = std::min(reads_gone_ + config_.write_idle, refresh_due_);
        reason_ = DramLabel::kWriteWait;
    } else {
        next_ = std::min(best_time_, refresh_due_);
        reason_ = reason_to_wait(candidate_[best_bank_]);
    }
}

DramLabel DramScheduler::reason_to_wait(const Candidate& candidate) const {
    const DramCycle limit = banks_.limit(candidate.limit);
    if (best_time_ > std::max(candidate.time, limit)) return DramLabel::kCommandBus;
    const bool between_banks = limit > candidate.time;
    switch (candidate.command) {
        case DramCommand::kRead:
        case DramCommand::kWrite:
            if (!between_banks) return DramLabel::kActivate;
            return candidate.command == last_column_ ? DramLabel::kColumnGap : DramLabel::kTurnaround;
        case DramCommand::kActivate:
            if (between_banks) return DramLabel::kActivationWindow;
            return candidate.time <= refresh_end_ ? DramLabel::kRefresh : DramLabel::kPrecharge;
        default:
            return DramLabel::kPrecharge;
    }
}

void DramScheduler::issue(std::uint32_t bank, DramCycle now) {
    const Candidate candidate = candidate_[bank];
    Access& access = access_[candidate.slot];
    command_free_ = now + 1;
    switch (candidate.command) {
        case DramCommand::kPrecharge:
            trace(now, candidate.command, bank, banks_.open_row(bank), 0);
            banks_.precharge(bank, now);
            access.precharged = true;
            ++statistics_.precharges;
            break;
        case DramCommand::kActivate:
            trace(now, candidate.command, bank, access.row, 0);
            banks_.activate(bank, access.row, now);
            ++statistics_.activations;
            if (!access.activated) ++(access.precharged ? statistics_.row_conflicts : statistics_.row_misses);
            access.activated = true;
            break;
        default:
            issue_column(bank, candidate, now);
            break;
    }
    refresh_candidate(bank, now);
}

void DramScheduler::issue_column(std::uint32_t bank, const Candidate& candidate, DramCycle now) {
    Access& access = access_[candidate.slot];
    trace(now, candidate.command, bank, access.row, access.column);
    const std::uint64_t bursts = statistics_.read_bursts + statistics_.write_bursts;
    if (bursts != 0 && candidate.command != last_column_) ++statistics_.turnarounds;
    last_column_ = candidate.command;
    slot_end_ = now + config_.burst;
    if (candidate.command == DramCommand::kRead) {
        banks_.read(bank, now);
        ++statistics_.read_bursts;
        slot_label_ = DramLabel::kReadData;
        last_data_ = slot_end_ + config_.cl;
    } else {
        banks_.write(bank, now);
        ++statistics_.write_bursts;
        slot_label_ = DramLabel::kWriteData;
        last_data_ = slot_end_ + config_.cwl;
    }
    ++access.column;
    if (--access.left == 0) retire(candidate.slot, now);
}

DramCycle DramScheduler::refresh_command_time() const {
    const DramCycle ready = banks_.all_closed() ? banks_.refresh_time() : banks_.precharge_all_time();
    return std::max({ready, refresh_due_, command_free_});
}

void DramScheduler::issue_refresh_command(DramCycle now) {
    command_free_ = now + 1;
    if (!banks_.all_closed()) {
        trace(now, DramCommand::kPrechargeAll, 0, 0, 0);
        for (std::uint32_t bank = 0; bank < config_.banks(); ++bank) {
            if (banks_.open_row(bank) == DramBanks::kClosed) continue;
            banks_.precharge(bank, now);
            ++statistics_.precharges;
        }
        return;
    }
    trace(now, DramCommand::kRefresh, 0, 0, 0);
    banks_.refresh(now);
    ++statistics_.refreshes;
    refresh_end_ = now + config_.trfc;
    refresh_due_ += config_.trefi;
}

// Refreshes that came due while nothing was queued: issued in arrears, at the times they would have had.
void DramScheduler::catch_up_refreshes(DramCycle now) {
    while (refresh_due_ < now) {
        const DramCycle time = refresh_command_time();
        if (time >= now) return;
        issue_refresh_command(time);
    }
}

}  // namespace ropsim
