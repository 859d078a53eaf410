// The timing state of a channel's banks: when each command becomes legal, after every command issued.
#pragma once

#include "memory/dram_device.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

namespace ropsim {

using DramCycle = std::uint64_t;
inline constexpr DramCycle kNoCycle = std::numeric_limits<DramCycle>::max();

enum class DramCommand : std::uint8_t { kRead, kWrite, kActivate, kPrecharge, kPrechargeAll, kRefresh };

// Every rule is "not before": a command raises the earliest time of others. Rules of one bank are kept a
// bank; rules between banks are kept a bank group (`limit`), since no rule here is finer than that.
class DramBanks {
 public:
    static constexpr std::uint32_t kMaxBanks = 32;
    static constexpr std::uint32_t kMaxGroups = 8;
    static constexpr std::uint32_t kClosed = ~0u;

    explicit DramBanks(const DramConfig& config)
        : config_(config), banks_(config.banks()), groups_(config.bank_groups) {
        open_row_.fill(kClosed);
        for (std::uint32_t b = 0; b < banks_; ++b)
            group_[b] = static_cast<std::uint8_t>(b / config.banks_per_group);
    }

    std::uint32_t open_row(std::uint32_t bank) const { return open_row_[bank]; }
    bool all_closed() const { return open_count_ == 0; }

    // The bank's own earliest time for a command.
    DramCycle bank_time(DramCommand command, std::uint32_t bank) const {
        return bank_time_[static_cast<std::size_t>(command)][bank];
    }
    // Index into limits() of the rules between banks that hold for this command in this bank.
    std::uint16_t limit_index(DramCommand command, std::uint32_t bank) const {
        return static_cast<std::uint16_t>(static_cast<std::uint32_t>(command) * kMaxGroups + group_[bank]);
    }
    DramCycle limit(std::uint16_t index) const { return limits_[index]; }

    void activate(std::uint32_t bank, std::uint32_t row, DramCycle now) {
        open_row_[bank] = row;
        ++open_count_;
        raise(DramCommand::kRead, bank, now + config_.trcd_rd);
        raise(DramCommand::kWrite, bank, now + config_.trcd_wr);
        raise(DramCommand::kPrecharge, bank, now + config_.tras);
        raise(DramCommand::kActivate, bank, now + config_.trc);
        DramCycle all = now + config_.trrd_s;
        // the next activate is the fifth (33rd) from the one that opened the window
        if (config_.tfaw != 0 && activations_ >= 3)
            all = std::max(all, activated_[(activations_ - 3) & 31] + config_.tfaw);
        if (config_.t32aw != 0 && activations_ >= 31)
            all = std::max(all, activated_[(activations_ - 31) & 31] + config_.t32aw);
        activated_[activations_++ & 31] = now;
        raise_limits(DramCommand::kActivate, bank, all, now + config_.trrd_l);
    }
    void precharge(std::uint32_t bank, DramCycle now) {
        open_row_[bank] = kClosed;
        --open_count_;
        raise(DramCommand::kActivate, bank, now + config_.trp);
    }
    void read(std::uint32_t bank, DramCycle now) {
        raise(DramCommand::kPrecharge, bank, now + config_.trtp);
        raise_limits(DramCommand::kRead, bank, now + config_.column_interval(), now + config_.tccd_l);
        raise_limits(DramCommand::kWrite, bank, now + config_.trtw, now + config_.trtw);
    }
    void write(std::uint32_t bank, DramCycle now) {
        const DramCycle data_end = now + config_.cwl + config_.burst;
        raise(DramCommand::kPrecharge, bank, data_end + config_.twr);
        raise_limits(DramCommand::kWrite, bank, now + config_.column_interval(), now + config_.tccd_l);
        raise_limits(DramCommand::kRead, bank, data_end + config_.twtr_s, data_end + config_.twtr_l);
    }
    // Requires all_closed().
    void refresh(DramCycle now) {
        for (std::uint32_t b = 0; b < banks_; ++b) raise(DramCommand::kActivate, b, now + config_.trfc);
    }
    // The earliest time for precharging every open bank at once.
    DramCycle precharge_all_time() const {
        DramCycle time = 0;
        for (std::uint32_t b = 0; b < banks_; ++b)
            if (open_row_[b] != kClosed) time = std::max(time, bank_time(DramCommand::kPrecharge, b));
        return time;
    }
    // The earliest time for a refresh, once all banks are closed.
    DramCycle refresh_time() const {
        DramCycle time = 0;
        for (std::uint32_t b = 0; b < banks_; ++b)
            time = std::max(time, bank_time(DramCommand::kActivate, b));
        return time;
    }

 private:
    void raise(DramCommand command, std::uint32_t bank, DramCycle time) {
        DramCycle& earliest = bank_time_[static_cast<std::size_t>(command)][bank];
        earliest = std::max(earliest, time);
    }
    void raise_limits(DramCommand command, std::uint32_t bank, DramCycle all, DramCycle same_group) {
        const std::size_t base = static_cast<std::size_t>(command) * kMaxGroups;
        for (std::uint32_t g = 0; g < groups_; ++g) limits_[base + g] = std::max(limits_[base + g], all);
        DramCycle& own = limits_[base + group_[bank]];
        own = std::max(own, same_group);
    }

    DramConfig config_;
    std::uint32_t banks_;
    std::uint32_t groups_;
    std::array<std::uint32_t, kMaxBanks> open_row_{};
    std::uint32_t open_count_ = 0;
    std::array<std::uint8_t, kMaxBanks> group_{};
    std::array<std::array<DramCycle, kMaxBanks>, 4> bank_time_{};  // [read, write, activate, precharge]
    std::array<DramCycle, std::size_t{4} * kMaxGroups> limits_{};  // the same commands; precharge has none
    std::array<DramCycle, 32> activated_{};                        // times of the last 32 activates
    std::uint64_t activations_ = 0;
};

}  // namespace ropsim
