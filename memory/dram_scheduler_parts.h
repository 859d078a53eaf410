// What the state of a DRAM command scheduler is made of.
#pragma once

#include "memory/dram_banks.h"
#include "memory/dram_scan.h"

#include <array>
#include <cstdint>

namespace ropsim {

struct DramSchedulerParts {
    enum Direction { kReads, kWrites };
    enum Lane { kReadLane, kWriteLane, kRowLane };
    static constexpr int kLanes = 3;
    static constexpr std::size_t kMaxParts = 66;
    static constexpr std::uint16_t kNone = 0xffff;
    // Of an order, from low to high: bank, lane, 31 bits of age (of arrival), class.
    static constexpr int kLaneShift = 6;
    static constexpr int kAgeShift = 8;
    static constexpr int kAgeBits = 31;
    static constexpr int kClassShift = kAgeShift + kAgeBits;
    static constexpr int kTimeShift = kClassShift + 2;
    static_assert(kTimeShift == DramScanKeys::kTimeShift);
    // An order without an age comes before all others of its class.
    static constexpr std::uint64_t kFirstAge = std::uint64_t{1} << kAgeShift;
    static constexpr std::uint64_t kEndOfAges = std::uint64_t{1} << kClassShift;
    static constexpr std::uint32_t kRefreshLane = 3;
    // Time ahead and order of no candidate.
    static constexpr std::uint64_t kNoKey = DramScanKeys::kAbsent ^ DramScanKeys::kKeyBias;
    enum Class : std::uint64_t { kUrgent, kNormal, kLater, kLast };

    // Accesses by the low bits of what an entry can hold: most have nobody else's bytes in theirs.
    static constexpr std::uint32_t kCrowds = 512;
    // The bytes of a request that one entry holds.
    struct Part {
        std::uint32_t row;
        std::uint32_t column;
        std::uint32_t bursts;
        std::uint8_t bank;
        bool whole;  // a write of every byte of its bursts
        std::uint16_t crowd;
    };
    struct alignas(64) Access {
        DramCycle arrival = 0;
        DramCycle ready = 0;      // no command for it before
        std::uint64_t order = 0;  // of its candidates, but for their lane and class
        std::uint32_t row = 0;
        std::uint32_t column = 0;
        std::uint32_t left = 0;    // bursts still to move
        std::uint32_t number = 0;  // of the read
        std::uint16_t crowd = 0;
        std::uint8_t bank = 0;
        bool write = false;
        bool whole = false;      // as Part::whole
        bool activated = false;  // an ACT was issued for it: a row miss, or a conflict if a PRE was, too
        bool precharged = false;
        bool queued = true;    // holds an entry of its queue
        bool hurried = false;  // a write that a read waits for
    };
    // A command that a bank could take next; its time and order are in keys_.
    struct Candidate {
        std::uint16_t slot = kNone;
        DramCommand command = DramCommand::kRead;
    };
    // One pair of queues and the direction they serve.
    struct Queues {
        std::array<std::uint32_t, 2> count{};  // entries
        Direction direction = kReads;
        bool forced_drain = false;       // draining though reads wait
        bool write_queue_short = false;  // a write found no room
        bool unsettled = true;           // the direction may turn by time alone, or the next step may
        std::uint32_t hurried = 0;       // writes that a read waits for
        std::uint32_t batch = 0;         // accesses to serve before the watermark may turn the bus again
        DramCycle reads_gone = 0;        // when the last read left the queue
        DramCycle last_move = kNoCycle;  // into a bank's queue
    };
    // The candidate that comes first.
    struct Best {
        DramCycle time = kNoCycle;
        std::uint64_t order = 0;

        std::uint32_t lane() const { return static_cast<std::uint32_t>(order >> kLaneShift & 3); }
        // Of a refresh: its unit.
        std::uint32_t bank() const { return static_cast<std::uint32_t>(order & ((1u << kLaneShift) - 1)); }
    };
    enum Kind { kColumns, kRows };
    struct Pseudochannel {
        std::array<Best, 2> best;  // column commands, row commands
        std::uint32_t first_bank = 0, first_group = 0;
        std::uint32_t next_turn = 0;                        // round robin: the bank that goes first
        std::uint32_t present = 0;                          // accesses
        DramCycle labelled = 0;                             // every cycle before has its label
        DramCommand last_column = DramCommand::kPrecharge;  // none yet
        DramCycle refresh_end = 0;
    };
    // One of each pseudo-channel at most, in place: most have one, which every step looks at.
    template <class T>
    class Few {
     public:
        explicit Few(std::size_t count) : count_(count) {}
        std::size_t size() const { return count_; }
        T* begin() { return items_.data(); }
        T* end() { return begin() + count_; }
        const T* begin() const { return items_.data(); }
        const T* end() const { return begin() + count_; }
        T& operator[](std::size_t i) { return items_[i]; }
        const T& operator[](std::size_t i) const { return items_[i]; }

     private:
        std::array<T, DramBanks::kMaxRanks> items_;
        std::size_t count_;
    };
    // What is refreshed at a time: a rank, or its banks in turn.
    struct RefreshUnit {
        DramCycle due = kNoCycle;
        bool pending = false;
        std::uint32_t bank = 0;  // whose turn it is
    };
    enum class Overlap { kNone, kCovered, kConflict };
};

}  // namespace ropsim
