// An independent check of DRAM timing: replays a command trace against every rule, by brute force over its
// past.
#pragma once

#include "dram_driver.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace ropsim {

// Looks back over all commands that can still matter. Shares nothing with the scheduler but the parameters.
class DramRules {
 public:
    explicit DramRules(const DramConfig& config)
        : c_(config),
          horizon_(config.trfc + config.trfcpb + config.trc + config.cl + config.cwl + config.twr + 100),
          open_(config.banks(), -1),
          activations_(std::size_t{config.pseudochannels} * config.ranks),
          refreshed_(config.banks(), 0) {}

    // Empty when the whole trace is legal, else the first violation.
    std::string check(const std::vector<IssuedCommand>& commands) {
        for (const IssuedCommand& now : commands) {
            if (std::string wrong = check_bus(now); !wrong.empty()) return wrong;
            for (const IssuedCommand& before : past_) {
                if (now.cycle < before.cycle) return fmt::format("time runs back at {}", now.cycle);
                const std::int64_t gap = required_gap(before, now);
                if (static_cast<std::int64_t>(now.cycle - before.cycle) < gap)
                    return fmt::format("command {} at {} is {} after command {} (bank {} and {}), needs {}",
                                       static_cast<int>(now.command), now.cycle, now.cycle - before.cycle,
                                       static_cast<int>(before.command), before.bank, now.bank, gap);
            }
            if (std::string wrong = check_windows(now); !wrong.empty()) return wrong;
            if (std::string wrong = check_state(now); !wrong.empty()) return wrong;
            past_.push_back(now);
            while (past_.front().cycle + horizon_ < now.cycle) past_.pop_front();
        }
        return "";
    }
    std::uint64_t refreshes = 0;
    std::uint64_t bank_refreshes = 0;

    // Fewest cycles from `a` to a later `b`, first cycle to first cycle; 0: none.
    std::int64_t required_gap(const IssuedCommand& a, const IssuedCommand& b) const {
        const std::int64_t time = required_time(a, b);
        return time == 0 ? 0 : time + length(a.command) - length(b.command);
    }

 private:
    std::uint32_t group(std::uint32_t bank) const { return bank / c_.banks_per_group; }
    std::uint32_t rank(std::uint32_t bank) const { return group(bank) / c_.bank_groups; }
    std::uint32_t pseudochannel(std::uint32_t bank) const { return rank(bank) / c_.ranks; }
    static bool of_rank(DramCommand command) {
        return command == DramCommand::kPrechargeAll || command == DramCommand::kRefresh;
    }
    static bool of_column(DramCommand command) {
        return command == DramCommand::kRead || command == DramCommand::kWrite;
    }
    std::int64_t length(DramCommand command) const {
        if (of_column(command)) return c_.column_bus;
        return command == DramCommand::kActivate ? c_.row_bus_act : c_.row_bus_pre;
    }

    // Column commands of two directions or ranks: what their data need.
    std::int64_t data_gap(std::uint32_t first, std::uint32_t second) const {
        return std::max<std::int64_t>(0, std::int64_t{first} + c_.burst + c_.trtrs - std::int64_t{second});
    }
    std::int64_t between_ranks(const IssuedCommand& a, const IssuedCommand& b) const {
        if (!of_column(a.command) || !of_column(b.command)) return 0;
        return data_gap(a.command == DramCommand::kRead ? c_.cl : c_.cwl,
                        b.command == DramCommand::kRead ? c_.cl : c_.cwl);
    }
    std::int64_t after_column(const IssuedCommand& a, const IssuedCommand& b, bool same_bank,
                              bool closes) const {
        const bool same_group = group(a.bank) == group(b.bank);
        const bool read = a.command == DramCommand::kRead;
        if (a.command == b.command) return std::max({same_group ? c_.tccd_l : c_.tccd_s, c_.burst});
        if (of_column(b.command))
            return read ? c_.trtw : c_.cwl + c_.burst + (same_group ? c_.twtr_l : c_.twtr_s);
        if (!closes || !same_bank) return 0;
        return read ? c_.trtp : c_.cwl + c_.burst + c_.twr;
    }

    // Fewest cycles from the last cycle of `a` to that of `b`.
    std::int64_t required_time(const IssuedCommand& a, const IssuedCommand& b) const {
        using enum DramCommand;
        if (pseudochannel(a.bank) != pseudochannel(b.bank)) return 0;
        if (rank(a.bank) != rank(b.bank)) return between_ranks(a, b);
        const bool same_bank = of_rank(a.command) || of_rank(b.command) || a.bank == b.bank;
        const bool same_group = group(a.bank) == group(b.bank);
        const bool closes = b.command == kPrecharge || b.command == kPrechargeAll;
        const bool refreshes_one = b.command == kRefreshBank;
        const bool opens = b.command == kActivate || b.command == kRefresh || refreshes_one;
        switch (a.command) {
            case kRead:
            case kWrite:
                return after_column(a, b, same_bank, closes);
            case kActivate:
                if (b.command == kActivate || refreshes_one)
                    return same_bank ? c_.trc : same_group ? c_.trrd_l : c_.trrd_s;
                if (b.command == kRead && same_bank) return c_.trcd_rd;
                if (b.command == kWrite && same_bank) return c_.trcd_wr;
                return closes && same_bank ? c_.tras : b.command == kRefresh ? c_.trc : 0;
            case kPrecharge:
            case kPrechargeAll:
                return opens && same_bank ? c_.trp : 0;
            case kRefresh:
                return c_.trfc;
            case kRefreshBank:
                if (!opens) return 0;
                return a.bank == b.bank ? c_.trfcpb : c_.trrefd;
        }
        return 0;
    }

    std::string check_bus(const IssuedCommand& now) {
        DramCycle& free = free_[c_.separate_buses && !of_column(now.command) ? 1 : 0];
        if (now.cycle < free) return fmt::format("the command bus is taken at {}", now.cycle);
        free = now.cycle + static_cast<DramCycle>(length(now.command));
        return "";
    }

    std::string check_windows(const IssuedCommand& now) {
        if (now.command != DramCommand::kActivate) return "";
        std::vector<DramCycle>& times = activations_[rank(now.bank)];
        const auto too_many = [&](std::size_t count, std::uint32_t window) {
            return window != 0 && times.size() >= count && now.cycle < times[times.size() - count] + window;
        };
        if (too_many(4, c_.tfaw)) return fmt::format("tFAW at {}", now.cycle);
        if (too_many(32, c_.t32aw)) return fmt::format("t32AW at {}", now.cycle);
        times.push_back(now.cycle);
        return "";
    }

    std::string check_state(const IssuedCommand& now) {
        using enum DramCommand;
        std::int64_t& row = open_[now.bank];
        const auto first = open_.begin() + static_cast<std::ptrdiff_t>(rank(now.bank) * c_.banks_of_rank());
        const auto end = first + static_cast<std::ptrdiff_t>(c_.banks_of_rank());
        switch (now.command) {
            case kRead:
            case kWrite:
                if (row != now.row)
                    return fmt::format("column command to closed row {} at {}", now.row, now.cycle);
                break;
            case kActivate:
                if (row >= 0) return fmt::format("ACT to an open bank at {}", now.cycle);
                row = now.row;
                break;
            case kPrecharge:
                row = -1;
                break;
            case kPrechargeAll:
                std::fill(first, end, -1);
                break;
            case kRefresh:
                if (std::any_of(first, end, [](std::int64_t r) { return r >= 0; }))
                    return fmt::format("REF with an open bank at {}", now.cycle);
                ++refreshes;
                return check_refreshed(now.bank, c_.trefi, now.cycle);
            case kRefreshBank:
                if (row >= 0) return fmt::format("REF of an open bank at {}", now.cycle);
                ++bank_refreshes;
                return check_refreshed(now.bank, c_.trefipb * c_.banks_of_rank(), now.cycle);
        }
        return "";
    }
    // Nothing is refreshed later than its interval and what closing it takes.
    std::string check_refreshed(std::uint32_t bank, std::uint32_t interval, DramCycle cycle) {
        if (cycle > ++refreshed_[bank] * interval + horizon_)
            return fmt::format("refresh {} of bank {} is late: cycle {}", refreshed_[bank], bank, cycle);
        return "";
    }

    DramConfig c_;
    std::uint64_t horizon_;  // longer than any rule
    std::vector<std::int64_t> open_;
    std::deque<IssuedCommand> past_;
    std::vector<std::vector<DramCycle>> activations_;  // by rank
    std::vector<std::uint64_t> refreshed_;
    std::array<DramCycle, 2> free_{};  // column (or the only) command bus, row bus
};

}  // namespace ropsim
