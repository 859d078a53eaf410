// The timing state of a channel's banks: when each command becomes legal, after every command issued.
#pragma once

#include "memory/dram_device.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <limits>

namespace ropsim {

using DramCycle = std::uint64_t;
inline constexpr DramCycle kNoCycle = std::numeric_limits<DramCycle>::max();

enum class DramCommand : std::uint8_t {
    kRead,
    kWrite,
    kActivate,
    kPrecharge,
    kPrechargeAll,
    kRefresh,
    kRefreshBank
};

// Every rule is "not before": a command raises the earliest time of others. Rules of one bank are kept a
// bank; rules between banks are kept a bank group or a rank (`limit`), since no rule here is finer than that.
// All times are those of a command's first cycle. No command comes before its own limits, so that it may
// replace them where it does not raise them. Pseudo-channels share no rule but the command buses, which the
// scheduler keeps. Banks, bank groups and ranks are numbered over the channel.
class DramBanks {
 public:
    static constexpr std::uint32_t kMaxBanks = 64;
    static constexpr std::uint32_t kMaxRanks = 16;
    static constexpr std::uint32_t kClosed = ~0u;

    explicit DramBanks(const DramConfig& c)
        : groups_(c.bank_groups),
          ranks_(c.ranks),
          banks_of_rank_(c.banks_of_rank()),
          rank_shift_(std::countr_zero(c.banks_of_rank())),
          tfaw_(c.tfaw),
          t32aw_(c.t32aw),
          act_rd_(c.activate_to_read()),
          act_wr_(c.activate_to_write()),
          act_pre_(DramConfig::issue_gap(c.row_bus_act, c.tras, c.row_bus_pre)),
          act_act_(c.trc),
          rrd_s_(c.trrd_s),
          rrd_l_(c.trrd_l),
          pre_act_(DramConfig::issue_gap(c.row_bus_pre, c.trp, c.row_bus_act)),
          column_s_(c.column_interval()),
          column_l_(std::max(c.tccd_l, c.burst)),
          column_rank_(c.burst + c.trtrs),
          after_{AfterColumn{DramConfig::issue_gap(c.column_bus, c.trtp, c.row_bus_pre), c.trtw, c.trtw,
                             gap_of_data(c.cl, c.cwl, c.burst + c.trtrs)},
                 AfterColumn{DramConfig::issue_gap(c.column_bus, c.cwl + c.burst + c.twr, c.row_bus_pre),
                             c.cwl + c.burst + c.twtr_s, c.cwl + c.burst + c.twtr_l,
                             gap_of_data(c.cwl, c.cl, c.burst + c.trtrs)}},
          ref_act_(DramConfig::issue_gap(c.row_bus_pre, c.trfc, c.row_bus_act)),
          refpb_act_(DramConfig::issue_gap(c.row_bus_pre, c.trfcpb, c.row_bus_act)),
          refd_act_(DramConfig::issue_gap(c.row_bus_pre, c.trrefd, c.row_bus_act)),
          act_before_ref_(c.row_bus_act - std::min(c.row_bus_act, c.row_bus_pre)) {
        for (std::uint32_t b = 0; b < c.banks(); ++b)
            bank_[b].group = static_cast<std::uint8_t>(b / c.banks_per_group);
    }

    std::uint32_t open_row(std::uint32_t bank) const { return bank_[bank].open_row; }
    // Column commands since the row was opened.
    std::uint32_t hits(std::uint32_t bank) const { return bank_[bank].hits; }
    DramCycle last_column(std::uint32_t bank) const { return bank_[bank].last_column; }
    std::uint32_t rank_of(std::uint32_t bank) const { return bank >> rank_shift_; }
    bool all_closed(std::uint32_t rank) const { return open_count_[rank] == 0; }
    std::uint32_t open_banks() const {
        std::uint32_t sum = 0;
        for (const std::uint32_t count : open_count_) sum += count;
        return sum;
    }
    // Rank-cycles with a row open until `now`.
    std::uint64_t active_cycles(DramCycle now) const {
        std::uint64_t sum = active_cycles_;
        for (std::uint32_t r = 0; r < kMaxRanks; ++r)
            if (open_count_[r] != 0) sum += now - active_since_[r];
        return sum;
    }

    // The bank's own earliest time for a command.
    DramCycle bank_time(DramCommand command, std::uint32_t bank) const {
        return bank_[bank].time[static_cast<std::size_t>(command)];
    }
    // The rules between banks that hold for this command in this bank; kOneRank if the channel has but one.
    template <bool kOneRank = false>
    DramCycle limit(DramCommand command, std::uint32_t bank) const {
        return std::max(limits(command)[bank_[bank].group],
                        rank_limit(command, kOneRank ? 0 : rank_of(bank)));
    }
    // Those of a command between banks of a group, by group; of an activate all.
    const DramCycle* limits(DramCommand command) const {
        return limits_[static_cast<std::size_t>(command)].data();
    }
    // The others.
    DramCycle rank_limit(DramCommand command, std::uint32_t rank) const {
        return rank_limits_[static_cast<std::size_t>(command)][rank];
    }

    void activate(std::uint32_t bank, std::uint32_t row, DramCycle now) {
        const std::uint32_t rank = rank_of(bank);
        Bank& b = bank_[bank];
        b.open_row = row;
        b.hits = 0;
        b.last_column = now;
        if (open_count_[rank]++ == 0) active_since_[rank] = now;
        b.time = {now + act_rd_, now + act_wr_, now + act_act_, now + act_pre_};
        DramCycle all = now + rrd_s_;
        std::uint64_t& count = activations_[rank];
        std::array<DramCycle, 32>& times = activated_[rank];
        // the next activate is the fifth (33rd) from the one that opened the window
        if (tfaw_ != 0 && count >= 3) all = std::max(all, times[(count - 3) & 31] + tfaw_);
        if (t32aw_ != 0 && count >= 31) all = std::max(all, times[(count - 31) & 31] + t32aw_);
        times[count++ & 31] = now;
        raise_activates(rank, all);
        raise(limits_[static_cast<std::size_t>(DramCommand::kActivate)][b.group], now + rrd_l_);
    }
    void precharge(std::uint32_t bank, DramCycle now) {
        const std::uint32_t rank = rank_of(bank);
        bank_[bank].open_row = kClosed;
        if (--open_count_[rank] == 0) active_cycles_ += now - active_since_[rank];
        raise(DramCommand::kActivate, bank, now + pre_act_);
    }
    // A read or a write.
    template <DramCommand kCommand, bool kOneRank>
    void column(std::uint32_t bank, DramCycle now) {
        constexpr auto kOwn = static_cast<std::size_t>(kCommand);
        constexpr std::size_t kOther = kOwn ^ 1;
        const AfterColumn& after = after_[kOwn];
        const std::uint32_t rank = kOneRank ? 0 : rank_of(bank);
        Bank& b = bank_[bank];
        ++b.hits;
        b.last_column = now;
        raise(b.time[static_cast<std::size_t>(DramCommand::kPrecharge)], now + after.precharge);
        limits_[kOwn][b.group] = now + column_l_;
        rank_limits_[kOwn][rank] = now + column_s_;
        raise(limits_[kOther][b.group], now + after.other_l);
        raise(rank_limits_[kOther][rank], now + after.other_s);
        if (kOneRank || ranks_ == 1) return;
        const std::uint32_t first = rank / ranks_ * ranks_;
        for (std::uint32_t r = first; r < first + ranks_; ++r) {
            if (r == rank) continue;
            raise(rank_limits_[kOwn][r], now + column_rank_);
            raise(rank_limits_[kOther][r], now + after.other_rank);
        }
    }
    // Requires all_closed(rank).
    void refresh(std::uint32_t rank, DramCycle now) {
        for (std::uint32_t b = rank * banks_of_rank_; b < (rank + 1) * banks_of_rank_; ++b)
            raise(DramCommand::kActivate, b, now + ref_act_);
    }
    // Requires the bank to be closed.
    void refresh_bank(std::uint32_t bank, DramCycle now) {
        raise(DramCommand::kActivate, bank, now + refpb_act_);
        raise_activates(rank_of(bank), now + refd_act_);
    }
    // The earliest time for precharging every open bank of a rank at once.
    DramCycle precharge_all_time(std::uint32_t rank) const {
        DramCycle time = 0;
        for (std::uint32_t b = rank * banks_of_rank_; b < (rank + 1) * banks_of_rank_; ++b)
            if (bank_[b].open_row != kClosed) time = std::max(time, bank_time(DramCommand::kPrecharge, b));
        return time;
    }
    // The earliest time for a refresh of a rank, once all its banks are closed.
    DramCycle refresh_time(std::uint32_t rank) const {
        DramCycle time = 0;
        for (std::uint32_t b = rank * banks_of_rank_; b < (rank + 1) * banks_of_rank_; ++b)
            time = std::max(time, bank_time(DramCommand::kActivate, b));
        return time + act_before_ref_;
    }
    // The earliest time for a refresh of one closed bank: like an activate's.
    DramCycle refresh_bank_time(std::uint32_t bank) const {
        return std::max(bank_time(DramCommand::kActivate, bank), limit(DramCommand::kActivate, bank)) +
               act_before_ref_;
    }

 private:
    // Column commands so far apart that data after `second` start `apart` after those after `first`.
    static std::uint32_t gap_of_data(std::uint32_t first, std::uint32_t second, std::uint32_t apart) {
        return first + apart > second ? first + apart - second : 0;
    }
    static void raise(DramCycle& earliest, DramCycle time) {
        earliest = earliest < time ? time : earliest;  // a value, for no branch
    }
    void raise(DramCommand command, std::uint32_t bank, DramCycle time) {
        raise(bank_[bank].time[static_cast<std::size_t>(command)], time);
    }
    // In a rank.
    void raise_activates(std::uint32_t rank, DramCycle time) {
        DramCycle* limits =
            &limits_[static_cast<std::size_t>(DramCommand::kActivate)][std::size_t{rank} * groups_];
        for (std::uint32_t g = 0; g < groups_; ++g) raise(limits[g], time);
    }

    // From a read (a write) to a precharge of its bank, and to a write (a read) of its rank, of its bank
    // group, of another rank.
    struct AfterColumn {
        std::uint32_t precharge, other_s, other_l, other_rank;
    };
    // What a command to a bank looks at lies in one line of the host's cache.
    struct alignas(64) Bank {
        std::uint32_t open_row = kClosed;
        std::uint32_t hits = 0;
        DramCycle last_column = 0;        // or when the row was opened
        std::array<DramCycle, 4> time{};  // read, write, activate, precharge
        std::uint8_t group = 0;
    };
    std::array<Bank, kMaxBanks> bank_{};
    std::uint32_t groups_, ranks_, banks_of_rank_;
    int rank_shift_;
    // gaps between first cycles
    std::uint32_t tfaw_, t32aw_;
    std::uint32_t act_rd_, act_wr_, act_pre_, act_act_, rrd_s_, rrd_l_, pre_act_;
    std::uint32_t column_s_, column_l_, column_rank_;
    std::array<AfterColumn, 2> after_;
    std::uint32_t ref_act_, refpb_act_, refd_act_;
    std::uint32_t act_before_ref_;  // an activate may start so much before a refresh

    std::array<std::uint32_t, kMaxRanks> open_count_{};
    // by command as Bank::time; a precharge has none
    std::array<std::array<DramCycle, kMaxBanks>, 4> limits_{};       // by bank group
    std::array<std::array<DramCycle, kMaxRanks>, 4> rank_limits_{};  // of reads and writes
    std::array<std::array<DramCycle, 32>, kMaxRanks> activated_{};   // times of the last 32 activates
    std::array<std::uint64_t, kMaxRanks> activations_{};
    std::array<DramCycle, kMaxRanks> active_since_{};
    std::uint64_t active_cycles_ = 0;
};

}  // namespace ropsim
