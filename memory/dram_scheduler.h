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
#include "memory/slot_lists.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
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
    void run(DramCycle end) {
        if (next_ < end) run_while(end, ~std::uint64_t{0});
    }
    // Those up to the next of the chances(); returns its cycle.
    DramCycle run_to_chance();
    // The next cycle at which step() has something to do; kNoCycle while idle.
    DramCycle next() const { return next_; }
    // No read is done before this cycle, and the last data do not end before it, unless a request is pushed;
    // kNoCycle while idle.
    DramCycle next_outcome() const;
    // A lower bound of that, at less cost.
    DramCycle soonest_outcome() const { return next_ == kNoCycle ? kNoCycle : next_ + soonest_outcome_; }
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
    DramCycle last_data() const { return std::max(data_end_[kReads], data_end_[kWrites]); }
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
    // Functions with kUsual are the ones that every request and command takes. With it they leave out what
    // cannot be where usual_ holds; without it they are right for any configuration.

    // admission
    template <class Visit>
    void for_each_of(std::uint32_t bank, Direction direction, Visit visit);
    static bool overlaps(const Access& access, const Part& part);
    Overlap overlap(const Part& part, bool write) {
        return crowds_[write ? kReads : kWrites][part.crowd] == 0 ? Overlap::kNone
                                                                  : find_overlap(part, write);
    }
    Overlap find_overlap(const Part& part, bool write);
    bool merge(std::span<const Part> parts);
    Part part_of(const DramRequest& request, std::uint64_t from, std::uint64_t to) const;
    std::span<const Part> split_up(const DramRequest& request);
    template <bool kUsual, class Parts>
    bool has_room(const Parts& parts, Direction direction);
    bool fits(Queues& queues, Direction direction, std::size_t entries);
    template <bool kUsual>
    bool push_as(const DramRequest& request, DramCycle arrival, DramCycle now);
    template <bool kUsual>
    bool admit(const DramRequest& request, DramCycle arrival, DramCycle now);
    template <bool kUsual, class Parts>
    bool admit_parts(const Parts& parts, const DramRequest& request, DramCycle arrival, DramCycle now);
    template <bool kUsual>
    void enqueue(Part part, const DramRequest& request, DramCycle arrival, DramCycle now);
    void count_request(const DramRequest& request, std::uint64_t bursts, std::uint64_t forwarded);
    void renumber();

    // lists and queues
    // What a bank can see of a direction, oldest first; where reads and writes are mixed it is one list.
    template <bool kUsual>
    std::size_t bank_list(std::size_t direction, std::uint32_t bank) const {
        return (!kUsual && mixed_ ? 0 : direction) * DramBanks::kMaxBanks + bank;
    }
    // What waits for room in its bank's queue.
    std::size_t waiting_list(std::size_t direction, const Queues& queues) const {
        const auto index = static_cast<std::size_t>(&queues - queues_.begin());
        return 2 * (DramBanks::kMaxBanks + index) + direction;
    }
    template <class Visit>
    void for_each_in(std::size_t list, Visit visit) const {
        for (std::uint16_t slot = lists_.first(list); !lists_.is_end(slot); slot = lists_.after(slot))
            visit(slot);
    }
    template <bool kUsual>
    Queues& queues_of(std::uint32_t bank) {
        return queues_[kUsual || shared_ ? 0 : pseudochannel_of(bank)];
    }
    template <bool kUsual>
    Pseudochannel& channel_of(std::uint32_t bank) {
        return pseudochannels_[kUsual ? 0 : pseudochannel_of(bank)];
    }
    std::uint32_t pseudochannel_of(std::uint32_t bank) const { return bank >> pseudochannel_shift_; }
    template <bool kUsual>
    void leave_queue(Access& access, Direction direction, DramCycle now);
    std::uint16_t movable(const Queues& queues) const;
    void move(Queues& queues, std::uint16_t slot, DramCycle now);

    // decision
    DramCycle run_while(DramCycle end, std::uint64_t chances);
    template <bool kUsual>
    DramCycle run_as(DramCycle end, std::uint64_t chances);
    template <bool kUsual>
    void step_as(DramCycle now);
    bool update_direction(Queues& queues, DramCycle now);
    bool settled(const Queues& q) const;
    bool reconsider_direction(Queues& queues, DramCycle now);
    void set_direction(Queues& queues, Direction direction);
    template <bool kUsual>
    void refresh_candidate(std::uint32_t bank, DramCycle now);
    void refresh_any_candidate(std::uint32_t bank, DramCycle now);
    template <bool kUsual>
    void refresh_plain_candidate(std::uint32_t bank, DramCycle now);
    template <bool kUsual>
    void refresh_row_candidate(std::uint32_t bank, Direction direction, std::uint16_t oldest, DramCycle now);
    bool is_aged(const Access& access, DramCycle now) const;
    Class row_class(bool aged) const;
    void open_next(std::uint32_t bank, std::uint16_t oldest, DramCycle now);
    bool has_candidate(std::size_t lane, std::uint32_t bank) const { return keys_[lane].has(bank); }
    void drop_candidate(std::size_t lane, std::uint32_t bank) { keys_[lane].drop(bank); }
    void add_column_candidate(std::uint32_t bank, std::uint16_t slot, Class order_class);
    void add_row_candidate(std::uint32_t bank, DramCommand command, std::uint16_t slot, Class order_class);
    DramCommand row_command(std::uint32_t bank) const;
    void add_closing_candidate(std::uint32_t bank);
    void set_candidate(std::size_t lane, std::uint32_t bank, DramCommand command, std::uint16_t slot,
                       std::uint64_t order, DramCycle time, Class order_class);
    template <bool kUsual>
    void refresh_all_candidates(const Queues& queues, DramCycle now);
    bool blocked_by_refresh(std::uint32_t bank) const { return (blocked_banks_ >> bank & 1) != 0; }
    DramCycle closing_time(std::uint32_t bank) const;
    void clear_candidates(std::uint32_t bank);
    DramCycle time_of(std::size_t lane, std::uint32_t bank, DramCycle floor) const {
        const DramCycle limit = banks_.limit(candidate_[lane][bank].command, bank);
        return std::max(std::max(keys_[lane].time_of(bank), limit), floor);
    }
    template <Kind kKind, DramArbitration kArbitration, bool kInOrder>
    std::uint64_t scan(const Pseudochannel& pc, DramCycle floor) const;
    std::uint64_t scan_lane(const Pseudochannel& pc, std::size_t lane, DramCycle floor) const;
    template <Kind kKind>
    std::uint64_t least_key(const Pseudochannel& pc, DramCycle floor) const;
    template <Lane kLane, bool kUsual>
    void choose(Pseudochannel& pc, DramCycle now);
    template <bool kUsual>
    void choose_columns(Pseudochannel& pc, DramCycle now);
    void choose_all(Pseudochannel& pc, DramCycle now);
    void choose_again(Pseudochannel& pc, DramCycle now);
    void choose_refresh(Pseudochannel& pc, DramCycle now);
    template <bool kUsual>
    void reconsider(Pseudochannel& pc, std::uint32_t bank, DramCycle now);
    template <bool kUsual>
    void choose_after(Pseudochannel& pc, std::size_t lane, std::uint32_t bank, DramCycle now);
    template <bool kUsual>
    void reconsider_columns(Pseudochannel& pc, std::uint32_t bank, DramCycle now);
    void reconsider_lane(Best& best, std::size_t lane, std::uint32_t bank, DramCycle now);
    static bool before(const Best& a, const Best& b);
    template <bool kUsual>
    const Best& first_of(const Pseudochannel& pc) const;
    template <bool kUsual>
    DramCycle first_time() const;
    template <bool kUsual>
    void plan(DramCycle now, DramCycle first);
    DramCycle next_move(DramCycle now) const;
    template <bool kUsual>
    DramLabel reason_of(const Pseudochannel& pc) const;
    template <bool kUsual>
    DramLabel reason_to_wait(const Pseudochannel& pc, const Best& best) const;
    // When writes go though too few are queued for a forced drain, if no read comes meanwhile.
    DramCycle drain_time(const Queues& q) const {
        return q.count[kWrites] >= config_.write_idle_min ? q.reads_gone : q.reads_gone + config_.write_idle;
    }

    DramCycle outcome_of(const Pseudochannel& pc, const Queues& queues) const;

    // commands
    template <bool kUsual>
    DramCycle issue_due(DramCycle now);
    template <bool kUsual>
    void issue(Pseudochannel& pc, const Best& best, DramCycle now);
    template <bool kUsual>
    void issue_row(std::uint32_t bank, Candidate candidate, DramCycle now);
    template <DramCommand kCommand, bool kUsual>
    void retire(std::uint16_t slot, DramCycle now);
    template <DramCommand kCommand, bool kUsual>
    bool issue_column(Pseudochannel& pc, std::uint32_t bank, std::uint16_t slot, DramCycle now);
    void close(std::uint32_t bank, DramCycle now);
    void start_refreshes(DramCycle now);
    std::uint32_t refresh_rank(const RefreshUnit& unit) const;
    DramCycle refresh_command_time(const RefreshUnit& unit) const;
    void issue_refresh_command(RefreshUnit& unit, DramCycle now);
    void find_next_due();
    void catch_up(DramCycle now);

    template <bool kUsual>
    void account(DramCycle until);
    void account_all(DramCycle until);
    template <bool kUsual>
    void account_wait(Pseudochannel& pc, DramCycle until);
    void trace(DramCycle cycle, DramCommand command, std::uint32_t bank, std::uint32_t row,
               std::uint32_t column) {
        if (trace_ != nullptr) [[unlikely]]
            trace_->command(cycle, command, bank, row, column);
    }

    // What every step looks at comes first and together.
    bool mixed_;   // reads and writes are one list a bank
    bool shared_;  // one pair of queues
    bool in_order_;
    bool simple_;            // first-ready, no round robin: one command changes little
    bool plain_;             // first-ready over lists of one kind, as refresh_plain_candidate() wants it
    bool usual_;             // simple_ and plain_, one pseudo-channel of one rank, and there is a scan_
    bool snapshot_;          // a drain ends with the writes that it found
    bool drains_to_low_;     // ... by the watermark alone
    bool reads_in_batches_;  // a watermark turns the bus to writes only after a batch of reads
    std::array<std::uint8_t, kLanes> bus_of_lane_{};
    std::array<std::uint32_t, 2> data_cycles_;  // from a read, a write to the end of its data
    int pseudochannel_shift_;
    std::uint32_t groups_;  // of a pseudo-channel
    int burst_shift_, entry_shift_;
    // from a column command to the end of what it does, and the shorter of the two
    DramCycle read_outcome_, write_outcome_, soonest_outcome_;
    DramCycle opening_, write_to_read_outcome_;  // from an ACT to a column command; from a write to a read's
    std::array<std::uint32_t, 2> present_{};
    DramCycle next_ = kNoCycle;
    DramCycle next_due_ = kNoCycle;
    std::array<DramCycle, 2> data_end_{};  // of the last read, the last write
    std::array<DramCycle, 2> bus_free_{};  // command buses: column, row
    std::uint64_t blocked_banks_ = 0;      // waiting to be refreshed
    std::uint32_t refreshes_pending_ = 0;
    bool unplanned_ = false;              // push() has changed candidates, or has found none
    std::uint64_t next_age_ = kFirstAge;  // a multiple of it
    std::uint64_t chances_ = 0;
    Few<Pseudochannel> pseudochannels_;
    Few<Queues> queues_;
    std::vector<Access> access_;
    SlotLists lists_;
    std::vector<std::uint16_t> free_slots_;
    std::vector<Finished> finished_;
    std::vector<std::uint32_t> pieces_left_;  // of a read, by number
    const Queues* full_reads_ = nullptr;      // where the last refused request, a read, found no room
    std::array<DramScan, 2> scan_{};          // by Kind, if simple_, and its range and the bank groups allow
    DramScanRange range_;                     // of all banks
    DramCommandTrace* trace_ = nullptr;

    std::array<std::array<Candidate, DramBanks::kMaxBanks>, kLanes> candidate_{};
    std::array<DramScanKeys, kLanes> keys_;
    std::array<std::array<std::uint16_t, kCrowds>, 2> crowds_{};
    std::array<Part, kMaxParts> parts_;  // of the request that split_up() saw last
    DramBanks banks_;
    DramConfig config_;
    AddressMap map_;
    std::array<std::uint8_t, DramBanks::kMaxBanks> bank_fill_{};  // of a bank's own queue
    std::array<std::uint16_t, DramBanks::kMaxBanks> promoted_;    // has opened the row and left its queue
    std::vector<RefreshUnit> refresh_units_;                      // by rank
    DramStatistics statistics_;
};

}  // namespace ropsim
