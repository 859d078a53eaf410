// The command scheduler of a DRAM channel in whole cycles: first-ready scheduling with write drain over a
// per-bank command table.
#pragma once

#include "memory/address_map.h"
#include "memory/dram_banks.h"
#include "memory/dram_device.h"
#include "memory/dram_request.h"
#include "memory/dram_scan.h"
#include "memory/dram_scheduler_parts.h"
#include "memory/dram_statistics.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace ropsim {

// A request is split into accesses: bursts that lie in one row, one queue entry each (or one a burst). Each
// bank with accesses of the present direction (reads, or writes while draining; both where there is no such
// grouping) has up to three candidates: the column command of its oldest row hit of either kind, and PRE or
// ACT for its oldest access. Of the candidates the earliest wins, ties as `arbitration` says. One command a
// cycle and bus; nothing happens between step()s, whose times are exact.
class DramScheduler : DramSchedulerParts {
 public:
    struct Finished {
        std::uint32_t number;
        DramCycle cycle;  // end of the last data, and back_cycles
    };

    explicit DramScheduler(const DramConfig& config);

    // Queues a request at cycle `now`, not before any earlier call's; its latency counts from `arrival` <=
    // now. False: no room, or it needs bytes that a queued request of the other direction still has to move
    // (a write that stands in a read's way is then hurried); nothing was queued.
    bool push(const DramRequest& request, DramCycle arrival, DramCycle now);
    // Issues the commands that are due at `now`, if any.
    void step(DramCycle now);
    // Those before `end`, each at its time.
    void run(DramCycle end);
    // The next cycle at which step() has something to do; kNoCycle while idle.
    DramCycle next() const { return next_; }
    // No read is done before this cycle, and the last data do not end before it, unless a request is pushed;
    // kNoCycle while idle.
    DramCycle next_outcome() const;
    // A lower bound of that, at less cost.
    DramCycle soonest_outcome() const {
        return next_ == kNoCycle ? kNoCycle : next_ + std::min(read_outcome_, write_outcome_);
    }
    // Reads whose data are all scheduled; the caller takes them and clears the list.
    std::vector<Finished>& finished() { return finished_; }

    // How often something has left that could have kept the last refused request out: it has a new chance.
    // Accesses that left their queue, or the channel; if a read found no room and there are no writes, only
    // those of that queue.
    std::uint64_t chances() const { return chances_; }
    // From now on anything that leaves is a chance (for a request that waits for a number).
    void expect_any_chance() { full_reads_ = nullptr; }
    bool idle() const { return (present_[kReads] | present_[kWrites]) == 0; }
    // End of the last data so far.
    DramCycle last_data() const { return last_data_; }
    std::uint64_t capacity() const { return map_.capacity(); }

    // For observers: accesses queued now, over all pseudo-channels.
    std::uint32_t queued_reads() const { return present_[kReads]; }
    std::uint32_t queued_writes() const { return present_[kWrites]; }
    // Banks with a row open.
    std::uint32_t open_banks() const { return banks_.open_banks(); }
    // Pairs of queues that drain writes now. Where reads and writes are mixed: 0.
    std::uint32_t draining() const {
        std::uint32_t count = 0;
        for (const Queues& queues : queues_) count += queues.direction == kWrites ? 1 : 0;
        return count;
    }

    void count_blocked(DramCycle cycles) { statistics_.blocked_cycles += cycles; }
    void count_blocking_request(std::uint64_t bytes) {
        ++statistics_.blocking_requests;
        statistics_.blocking_bytes += bytes;
    }
    // Closes the accounting at `end` or the last data, whichever is later, and checks it. Requires idle().
    void finish(DramCycle end);
    const DramStatistics& statistics() const { return statistics_; }
    void set_trace(DramCommandTrace* trace) { trace_ = trace; }

 private:
    // admission
    template <class Visit>
    void for_each_of(const Access& access, Direction direction, Visit visit);
    Overlap overlap(const Access& access) {
        const Direction other = access.write ? kReads : kWrites;
        if (!mixed_ && lists_[other][access.bank].head == kNone) return Overlap::kNone;
        return find_overlap(access);
    }
    Overlap find_overlap(const Access& access);
    bool merge(std::size_t count);
    std::size_t split(const DramRequest& request);
    std::size_t split_up(const DramRequest& request);
    void set_piece(std::size_t i, const DramRequest& request, std::uint64_t from, std::uint64_t to);
    bool has_room(const DramRequest& request, std::size_t count);
    bool fits(Queues& queues, Direction direction, std::size_t entries);
    void enqueue(DramCycle now);
    // Part `i` of the request being admitted: in the slot that it will have, if there are as many free.
    Access& piece(std::size_t i) {
        return i < free_slots_.size() ? access_[free_slots_[free_slots_.size() - 1 - i]]
                                      : access_[access_.size() - 1 - i];
    }
    void count_request(const DramRequest& request, std::uint64_t bursts, std::uint64_t forwarded);
    bool admit(const DramRequest& request, DramCycle arrival, DramCycle now);
    void renumber();

    // lists and queues
    void append(List& list, std::uint16_t slot);
    void remove(List& list, std::uint16_t slot);
    List& list_of(const Access& access) { return lists_[mixed_ ? 0 : access.write][access.bank]; }
    Queues& queues_of(std::uint32_t bank) { return queues_[shared_ ? 0 : pseudochannel_of(bank)]; }
    std::uint32_t pseudochannel_of(std::uint32_t bank) const { return bank >> pseudochannel_shift_; }
    void leave_queue(Access& access, DramCycle now);
    void retire(std::uint16_t slot, DramCycle now);
    std::uint16_t movable(const Queues& queues) const;
    void move(Queues& queues, std::uint16_t slot, DramCycle now);

    // decision
    bool update_direction(Queues& queues, DramCycle now) {
        return !settled(queues) && reconsider_direction(queues, now);
    }
    // Surely no reason to turn, whatever the time: the common cases of reconsider_direction().
    bool settled(const Queues& q) const {
        const std::uint32_t writes = q.count[kWrites];
        if (q.direction == kReads)
            return writes == 0 || (q.count[kReads] != 0 && writes < config_.write_high &&
                                   !q.write_queue_short && q.hurried == 0);
        return writes > (q.forced_drain ? config_.write_low : config_.write_idle_low) &&
               (q.batch != 0 || drains_to_low_);
    }
    bool reconsider_direction(Queues& queues, DramCycle now);
    void set_direction(Queues& queues, Direction direction);
    void update_directions(DramCycle now) {
        for (Queues& queues : queues_) update_direction(queues, now);
    }
    void refresh_candidate(std::uint32_t bank, DramCycle now);
    void refresh_plain_candidate(std::uint32_t bank, DramCycle now);
    void add_column_candidate(std::uint32_t bank, std::uint16_t slot, Class order_class);
    void add_row_candidate(std::uint32_t bank, std::uint16_t slot, Class order_class);
    void add_closing_candidate(std::uint32_t bank);
    void set_candidate(Lane lane, std::uint32_t bank, DramCommand command, std::uint16_t slot, DramCycle time,
                       Class order_class);
    void refresh_all_candidates(const Queues& queues, DramCycle now);
    bool blocked_by_refresh(std::uint32_t bank) const;
    DramCycle closing_time(std::uint32_t bank) const;
    void clear_candidates(Pseudochannel& pc, std::uint64_t banks);
    std::uint64_t key_of(std::size_t lane, std::size_t bank, DramCycle floor) const;
    template <Kind kKind, DramArbitration kArbitration, bool kInOrder>
    std::uint64_t scan(const Pseudochannel& pc, DramCycle floor) const;
    template <Kind kKind>
    void choose(Pseudochannel& pc, DramCycle now);
    void choose_all(Pseudochannel& pc, DramCycle now) {
        choose<kColumns>(pc, now);
        choose<kRows>(pc, now);
    }
    void choose_again(Pseudochannel& pc, DramCycle now);
    void choose_refresh(Pseudochannel& pc, DramCycle now);
    void reconsider(Pseudochannel& pc, std::uint32_t bank, DramCycle now);
    void choose_after(Pseudochannel& pc, std::uint32_t bank, DramCommand command, DramCycle now);
    void reconsider_lane(Best& best, std::size_t lane, std::uint32_t bank, DramCycle now);
    static bool before(const Best& a, const Best& b) {
        const bool order = a.order < b.order;  // no branch: which is first is as good as random
        return a.time < b.time ||
               static_cast<bool>(static_cast<int>(a.time == b.time) & static_cast<int>(order));
    }
    // Of the two kinds; in order, the older goes first though it may have to wait.
    const Best& first_of(const Pseudochannel& pc) const {
        const Best& columns = pc.best[kColumns];
        const Best& rows = pc.best[kRows];
        if (in_order_ && columns.time != kNoCycle && rows.time != kNoCycle)
            return rows.order < columns.order ? rows : columns;
        return before(rows, columns) ? rows : columns;
    }
    // Of the commands.
    DramCycle first_time() const {
        DramCycle first = kNoCycle;
        for (const Pseudochannel& pc : pseudochannels_) first = std::min(first, first_of(pc).time);
        return first;
    }
    // Sets next_; `first` is first_time().
    void plan(DramCycle now, DramCycle first) {
        if (idle()) {
            next_ = kNoCycle;
            return;
        }
        DramCycle next = std::min(next_due_, first);
        if (!mixed_) {
            for (const Queues& q : queues_)
                if (q.count[kReads] == 0 && q.direction == kReads && q.count[kWrites] != 0)
                    next = std::min(next, drain_time(q));
        } else {
            next = std::min(next, next_move(now));
        }
        next_ = std::max(next, now);
    }
    DramCycle next_move(DramCycle now) const;
    DramLabel reason_of(const Pseudochannel& pc) const;
    DramLabel reason_to_wait(const Pseudochannel& pc, const Best& best) const;
    // When writes go though too few are queued for a forced drain, if no read comes meanwhile.
    DramCycle drain_time(const Queues& q) const {
        return q.count[kWrites] >= config_.write_idle_min ? q.reads_gone : q.reads_gone + config_.write_idle;
    }

    // commands
    DramCycle issue_due(DramCycle now);
    void issue(Pseudochannel& pc, const Best& best, DramCycle now);
    bool goes_on(std::uint16_t slot, DramCommand command) const;
    void issue_column(Pseudochannel& pc, std::uint32_t bank, std::uint16_t slot, DramCommand command,
                      DramCycle now);
    void close(std::uint32_t bank, DramCycle now);
    void start_refreshes(DramCycle now);
    std::uint32_t refresh_rank(const RefreshUnit& unit) const;
    DramCycle refresh_command_time(const RefreshUnit& unit) const;
    void issue_refresh_command(RefreshUnit& unit, DramCycle now);
    void find_next_due();
    void catch_up(DramCycle now);

    void account(DramCycle until) {
        if (until > accounted_) account_span(until);
    }
    void account_span(DramCycle until);
    void trace(DramCycle cycle, DramCommand command, std::uint32_t bank, std::uint32_t row,
               std::uint32_t column) {
        if (trace_ != nullptr) [[unlikely]]
            trace_->command(cycle, command, bank, row, column);
    }

    // What every step looks at comes first and together.
    bool mixed_;   // reads and writes are one list a bank
    bool shared_;  // one pair of queues
    bool in_order_;
    bool simple_;         // first-ready, no round robin: one command changes little
    bool plain_;          // first-ready over lists of one kind, as refresh_plain_candidate() wants it
    bool drains_to_low_;  // a drain ends by the watermark alone
    std::array<std::uint8_t, kLanes> bus_of_lane_{};
    int pseudochannel_shift_;
    std::uint32_t groups_;  // of a pseudo-channel
    int burst_shift_, entry_shift_;
    DramCycle read_outcome_, write_outcome_;     // from a column command to the end of what it does
    DramCycle opening_, write_to_read_outcome_;  // from an ACT to a column command; from a write to a read's
    std::array<std::uint32_t, 2> present_{};
    DramCycle next_ = kNoCycle;
    DramCycle next_due_ = kNoCycle;
    DramCycle accounted_ = 0;
    DramCycle last_data_ = 0;
    std::array<DramCycle, 2> bus_free_{};  // command buses: column, row
    std::uint64_t blocked_banks_ = 0;      // waiting to be refreshed
    std::uint32_t refreshes_pending_ = 0;
    std::uint32_t next_age_ = 0;
    std::uint64_t chances_ = 0;
    std::vector<Pseudochannel> pseudochannels_;
    std::vector<Queues> queues_;
    std::vector<Access> access_;  // and, behind all slots, room for piece()
    std::vector<std::uint16_t> free_slots_;
    std::vector<Finished> finished_;
    std::vector<std::uint32_t> pieces_left_;  // of a read, by number
    const Queues* full_reads_ = nullptr;      // where the last refused request, a read, found no room
    DramScan scan_ = nullptr;                 // if simple_, and its range and the bank groups allow
    DramCommandTrace* trace_ = nullptr;

    std::array<std::array<List, DramBanks::kMaxBanks>, 2> lists_;  // what a bank can see, oldest first
    std::array<std::array<Candidate, kLanes>, DramBanks::kMaxBanks> candidate_{};
    std::array<DramScanKeys, kLanes> keys_;
    DramBanks banks_;
    DramConfig config_;
    AddressMap map_;
    std::array<std::uint8_t, DramBanks::kMaxBanks> bank_fill_{};  // of a bank's own queue
    std::array<std::uint16_t, DramBanks::kMaxBanks> promoted_;    // has opened the row and left its queue
    std::vector<RefreshUnit> refresh_units_;                      // by rank
    DramStatistics statistics_;
};

}  // namespace ropsim
