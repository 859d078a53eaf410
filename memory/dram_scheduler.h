// The command scheduler of a DRAM channel in whole cycles: FR-FCFS with write drain over a per-bank command
// table.
#pragma once

#include "memory/address_map.h"
#include "memory/dram_banks.h"
#include "memory/dram_device.h"
#include "memory/dram_statistics.h"

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

namespace ropsim {

// Sees every command as it is issued (in order, though not always at the wheel's present: an idle channel
// refreshes in arrears). For tests and command traces.
class DramCommandTrace {
 public:
    virtual ~DramCommandTrace() = default;
    // `bank`, `row`, `column` are 0 where the command has none.
    virtual void command(DramCycle cycle, DramCommand command, std::uint32_t bank, std::uint32_t row,
                         std::uint32_t column) = 0;
};

// One request as the scheduler sees it: bytes [address, address + bytes).
struct DramRequest {
    std::uint64_t address = 0;
    std::uint32_t bytes = 0;
    bool write = false;
    bool masked = false;  // a write with disabled bytes: cannot serve a later read
    std::uint8_t surface = 0;
    MemoryCause cause = MemoryCause::kFill;
    std::uint32_t number = 0;  // of a read, < config.read_queue; free again once in finished()
};

// A request is split into accesses: bursts that lie in one row, one queue entry each. Each bank with accesses
// of the present direction (reads, or writes while draining) has one candidate command: the column command of
// its oldest row hit, else PRE or ACT for its oldest access. Of the candidates the earliest wins, column
// commands before row commands, then the older. One command a cycle; nothing happens between step()s, whose
// times are exact.
class DramScheduler {
 public:
    struct Finished {
        std::uint32_t number;
        DramCycle cycle;  // end of the last data
    };

    explicit DramScheduler(const DramConfig& config);

    // Queues a request at cycle `now`, not before any earlier call's; its latency counts from `arrival` <=
    // now. False: no room, or it needs bytes that a queued request of the other direction still has to move
    // (a write that stands in a read's way is then hurried); nothing was queued.
    bool push(const DramRequest& request, DramCycle arrival, DramCycle now);
    // Issues the command that is due at `now`, if any.
    void step(DramCycle now);
    // The next cycle at which step() has something to do; kNoCycle while idle.
    DramCycle next() const { return next_; }
    // Reads whose data are all scheduled; the caller takes them and clears the list.
    std::vector<Finished>& finished() { return finished_; }

    // Accesses that have left the queue so far.
    std::uint64_t retired() const { return retired_; }
    bool idle() const { return used_ == 0; }
    // End of the last data so far.
    DramCycle last_data() const { return last_data_; }
    std::uint64_t capacity() const { return map_.capacity(); }

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
    enum Direction { kReads, kWrites };
    static constexpr int kMaxSlots = 64;
    // Of Candidate::order: 5 bits of bank, 31 of age, then this.
    static constexpr int kBankBits = 5;
    static constexpr int kAgeBits = 31;
    static constexpr std::uint64_t kRowCommand = std::uint64_t{1} << (kBankBits + kAgeBits);

    struct Access {
        DramCycle arrival = 0;
        std::uint32_t age = 0;  // order of arrival
        std::uint32_t row = 0;
        std::uint32_t column = 0;
        std::uint32_t left = 0;    // bursts still to move
        std::uint32_t number = 0;  // of the read
        std::uint8_t bank = 0;
        bool write = false;
        bool whole = false;      // a write of every byte of its bursts
        bool activated = false;  // an ACT was issued for it: a row miss, or a conflict if a PRE was, too
        bool precharged = false;
    };
    // What a bank would do next.
    struct Candidate {
        DramCycle time = kNoCycle;  // the bank's own earliest time; kNoCycle: nothing to do
        std::uint64_t order =
            0;  // who goes first at equal times: row command, age, bank from high to low bits
        std::uint16_t limit = 0;  // index of the rules between banks
        std::uint8_t slot = 0;
        DramCommand command = DramCommand::kRead;
    };
    enum class Overlap { kNone, kCovered, kConflict };

    // How bytes of `access` relate to queued accesses of the other direction; adds those in the way to
    // `*in_the_way`.
    Overlap overlap(const Access& access, std::uint64_t* in_the_way) const;
    int split(const DramRequest& request, std::array<Access, kMaxSlots>& pieces) const;
    void enqueue(const Access& access);
    void count_request(const DramRequest& request, std::uint64_t bursts, bool forwarded);
    bool admit(const DramRequest& request, DramCycle arrival, DramCycle now);
    void renumber();

    bool update_direction(DramCycle now);
    void set_direction(Direction direction);
    void refresh_candidate(std::uint32_t bank, DramCycle now);
    void refresh_all_candidates(DramCycle now);
    void choose(DramCycle now);
    void reconsider(std::uint32_t bank, DramCycle now);
    void plan(DramCycle now);
    DramLabel reason_to_wait(const Candidate& candidate) const;

    void issue(std::uint32_t bank, DramCycle now);
    void issue_column(std::uint32_t bank, const Candidate& candidate, DramCycle now);
    void retire(std::uint8_t slot, DramCycle now);
    bool refresh_due(DramCycle now) const { return now >= refresh_due_; }
    DramCycle refresh_command_time() const;
    void issue_refresh_command(DramCycle now);
    void catch_up_refreshes(DramCycle now);

    void account(DramCycle until);
    void trace(DramCycle cycle, DramCommand command, std::uint32_t bank, std::uint32_t row,
               std::uint32_t column) {
        if (trace_ != nullptr) [[unlikely]]
            trace_->command(cycle, command, bank, row, column);
    }

    DramConfig config_;
    std::uint32_t bank_count_;
    AddressMap map_;
    DramBanks banks_;

    // queue: slots [0, read_queue) hold reads, the next write_queue hold writes
    std::array<Access, kMaxSlots> access_{};
    std::array<Access, kMaxSlots> pieces_{};  // of the request being admitted
    std::uint64_t used_ = 0;                  // slots
    std::array<std::uint64_t, 2> direction_slots_{};
    std::array<std::array<std::uint64_t, DramBanks::kMaxBanks>, 2> bank_slots_{};
    std::array<std::uint32_t, 2> count_{};
    std::uint32_t next_age_ = 0;
    std::vector<std::uint32_t> pieces_left_;  // of a read, by number
    std::vector<Finished> finished_;
    std::uint64_t retired_ = 0;

    // decision
    std::array<Candidate, DramBanks::kMaxBanks> candidate_{};
    std::uint32_t active_banks_ = 0;  // with a candidate
    Direction direction_ = kReads;
    bool forced_drain_ = false;       // draining down to the low watermark, reads or not
    bool write_queue_short_ = false;  // a write found no room
    std::uint64_t hurried_ = 0;       // write slots that a read waits for
    std::uint32_t batch_ = 0;         // accesses to serve before the watermark may turn the bus again
    DramCycle reads_gone_ = 0;        // when the last read left the queue
    DramCycle command_free_ = 0;      // the command bus
    DramCycle best_time_ = kNoCycle;
    std::uint64_t best_order_ = 0;
    std::uint32_t best_bank_ = 0;
    DramCycle next_ = kNoCycle;

    DramCycle refresh_due_ = kNoCycle;
    DramCycle refresh_end_ = 0;

    // accounting
    DramCycle accounted_ = 0;
    DramCycle slot_end_ = 0;  // end of the last column command's cycles
    DramLabel slot_label_ = DramLabel::kReadData;
    DramCommand last_column_ = DramCommand::kRead;
    DramLabel reason_ = DramLabel::kIdle;
    DramCycle last_data_ = 0;
    DramStatistics statistics_;
    DramCommandTrace* trace_ = nullptr;
};

}  // namespace ropsim
