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
// bank; rules between banks are kept a bank group (`limit`), since no rule here is finer than that. All times
// are those of a command's first cycle. Pseudo-channels share no rule but the command buses, which the
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
          rd_pre_(DramConfig::issue_gap(c.column_bus, c.trtp, c.row_bus_pre)),
          wr_pre_(DramConfig::issue_gap(c.column_bus, c.cwl + c.burst + c.twr, c.row_bus_pre)),
          column_s_(c.column_interval()),
          column_l_(std::max(c.tccd_l, c.burst)),
          column_rank_(c.burst + c.trtrs),
          rd_wr_(c.trtw),
          rd_wr_rank_(gap_of_data(c.cl, c.cwl, c.burst + c.trtrs)),
          wr_rd_s_(c.cwl + c.burst + c.twtr_s),
          wr_rd_l_(c.cwl + c.burst + c.twtr_l),
          wr_rd_rank_(gap_of_data(c.cwl, c.cl, c.burst + c.trtrs)),
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
    // Index into limits() of the rules between banks that hold for this command in this bank.
    std::uint16_t limit_index(DramCommand command, std::uint32_t bank) const {
        return static_cast<std::uint16_t>(static_cast<std::uint32_t>(command) * kMaxBanks +
                                          bank_[bank].group);
    }
    DramCycle limit(std::uint16_t index) const { return limits_[index]; }
    // Those of a command, by bank group.
    const DramCycle* limits(DramCommand command) const {
        return &limits_[static_cast<std::size_t>(command) * kMaxBanks];
    }

    void activate(std::uint32_t bank, std::uint32_t row, DramCycle now) {
        const std::uint32_t rank = rank_of(bank);
        bank_[bank].open_row = row;
        bank_[bank].hits = 0;
        bank_[bank].last_column = now;
        if (open_count_[rank]++ == 0) active_since_[rank] = now;
        raise(DramCommand::kRead, bank, now + act_rd_);
        raise(DramCommand::kWrite, bank, now + act_wr_);
        raise(DramCommand::kPrecharge, bank, now + act_pre_);
        raise(DramCommand::kActivate, bank, now + act_act_);
        DramCycle all = now + rrd_s_;
        std::uint64_t& count = activations_[rank];
        std::array<DramCycle, 32>& times = activated_[rank];
        // the next activate is the fifth (33rd) from the one that opened the window
        if (tfaw_ != 0 && count >= 3) all = std::max(all, times[(count - 3) & 31] + tfaw_);
        if (t32aw_ != 0 && count >= 31) all = std::max(all, times[(count - 31) & 31] + t32aw_);
        times[count++ & 31] = now;
        raise_rank(DramCommand::kActivate, rank, all);
        raise_group(DramCommand::kActivate, bank, now + rrd_l_);
    }
    void precharge(std::uint32_t bank, DramCycle now) {
        const std::uint32_t rank = rank_of(bank);
        bank_[bank].open_row = kClosed;
        if (--open_count_[rank] == 0) active_cycles_ += now - active_since_[rank];
        raise(DramCommand::kActivate, bank, now + pre_act_);
    }
    void read(std::uint32_t bank, DramCycle now) {
        ++bank_[bank].hits;
        bank_[bank].last_column = now;
        raise(DramCommand::kPrecharge, bank, now + rd_pre_);
        raise_column(DramCommand::kRead, bank, now + column_s_, now + column_rank_);
        raise_group(DramCommand::kRead, bank, now + column_l_);
        raise_column(DramCommand::kWrite, bank, now + rd_wr_, now + rd_wr_rank_);
    }
    void write(std::uint32_t bank, DramCycle now) {
        ++bank_[bank].hits;
        bank_[bank].last_column = now;
        raise(DramCommand::kPrecharge, bank, now + wr_pre_);
        raise_column(DramCommand::kWrite, bank, now + column_s_, now + column_rank_);
        raise_group(DramCommand::kWrite, bank, now + column_l_);
        raise_column(DramCommand::kRead, bank, now + wr_rd_s_, now + wr_rd_rank_);
        raise_group(DramCommand::kRead, bank, now + wr_rd_l_);
    }
    // Requires all_closed(rank).
    void refresh(std::uint32_t rank, DramCycle now) {
        for (std::uint32_t b = rank * banks_of_rank_; b < (rank + 1) * banks_of_rank_; ++b)
            raise(DramCommand::kActivate, b, now + ref_act_);
    }
    // Requires the bank to be closed.
    void refresh_bank(std::uint32_t bank, DramCycle now) {
        raise(DramCommand::kActivate, bank, now + refpb_act_);
        raise_rank(DramCommand::kActivate, rank_of(bank), now + refd_act_);
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
        return std::max(bank_time(DramCommand::kActivate, bank),
                        limit(limit_index(DramCommand::kActivate, bank))) +
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
    void raise_group(DramCommand command, std::uint32_t bank, DramCycle time) {
        raise(limits_[limit_index(command, bank)], time);
    }
    void raise_rank(DramCommand command, std::uint32_t rank, DramCycle time) {
        DramCycle* limits =
            &limits_[static_cast<std::size_t>(command) * kMaxBanks + std::size_t{rank} * groups_];
        if (groups_ == 4) {  // the usual number, unrolled
            for (std::uint32_t g = 0; g < 4; ++g) raise(limits[g], time);
            return;
        }
        for (std::uint32_t g = 0; g < groups_; ++g) raise(limits[g], time);
    }
    // The bank's own rank, and the other ranks of its pseudo-channel.
    void raise_column(DramCommand command, std::uint32_t bank, DramCycle own, DramCycle others) {
        const std::uint32_t rank = rank_of(bank);
        raise_rank(command, rank, own);
        if (ranks_ == 1) [[likely]]
            return;
        const std::uint32_t first = rank / ranks_ * ranks_;
        for (std::uint32_t r = first; r < first + ranks_; ++r)
            if (r != rank) raise_rank(command, r, others);
    }

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
    std::uint32_t act_rd_, act_wr_, act_pre_, act_act_, rrd_s_, rrd_l_, pre_act_, rd_pre_, wr_pre_;
    std::uint32_t column_s_, column_l_, column_rank_, rd_wr_, rd_wr_rank_, wr_rd_s_, wr_rd_l_, wr_rd_rank_;
    std::uint32_t ref_act_, refpb_act_, refd_act_;
    std::uint32_t act_before_ref_;  // an activate may start so much before a refresh

    std::array<std::uint32_t, kMaxRanks> open_count_{};
    std::array<DramCycle, std::size_t{4} * kMaxBanks>
        limits_{};  // by command as Bank::time, bank group; precharge has none
    std::array<std::array<DramCycle, 32>, kMaxRanks> activated_{};  // times of the last 32 activates
    std::array<std::uint64_t, kMaxRanks> activations_{};
    std::array<DramCycle, kMaxRanks> active_since_{};
    std::uint64_t active_cycles_ = 0;
};

}  // namespace ropsim
