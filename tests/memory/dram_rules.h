// An independent check of DRAM timing: replays a command trace against every rule, by brute force over its
// past.
#pragma once

#include "dram_driver.h"

#include <algorithm>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace ropsim {

// Looks back over all commands that can still matter. Shares nothing with the scheduler but the parameters.
class DramRules {
 public:
    explicit DramRules(const DramConfig& config) : c_(config), open_(config.banks(), -1) {}

    // Empty when the whole trace is legal, else the first violation.
    std::string check(const std::vector<IssuedCommand>& commands) {
        for (const IssuedCommand& now : commands) {
            if (!past_.empty() && now.cycle <= past_.back().cycle)
                return fmt::format("two commands in cycle {}", now.cycle);
            for (const IssuedCommand& before : past_) {
                const std::int64_t gap = required_gap(before, now);
                if (now.cycle < before.cycle + static_cast<std::uint64_t>(gap))
                    return fmt::format("command {} at {} is {} after command {} (bank {} and {}), needs {}",
                                       static_cast<int>(now.command), now.cycle, now.cycle - before.cycle,
                                       static_cast<int>(before.command), before.bank, now.bank, gap);
            }
            if (std::string wrong = check_windows(now); !wrong.empty()) return wrong;
            if (std::string wrong = check_state(now); !wrong.empty()) return wrong;
            past_.push_back(now);
            while (past_.front().cycle + kHorizon < now.cycle) past_.pop_front();
        }
        return "";
    }
    std::uint64_t refreshes = 0;

 private:
    static constexpr std::uint64_t kHorizon = 600;  // longer than any rule of the presets

    std::uint32_t group(std::uint32_t bank) const { return bank / c_.banks_per_group; }

    std::int64_t required_gap(const IssuedCommand& a, const IssuedCommand& b) const {
        using enum DramCommand;
        const bool all = a.command == kPrechargeAll || b.command == kPrechargeAll || b.command == kRefresh;
        const bool same_bank = all || a.bank == b.bank;
        const bool same_group = group(a.bank) == group(b.bank);
        const bool b_closes = b.command == kPrecharge || b.command == kPrechargeAll;
        const bool b_opens = b.command == kActivate || b.command == kRefresh;
        switch (a.command) {
            case kRead:
                if (b.command == kRead) return std::max({same_group ? c_.tccd_l : c_.tccd_s, c_.burst});
                if (b.command == kWrite) return c_.trtw;
                return b_closes && same_bank ? c_.trtp : 0;
            case kWrite:
                if (b.command == kWrite) return std::max({same_group ? c_.tccd_l : c_.tccd_s, c_.burst});
                if (b.command == kRead) return c_.cwl + c_.burst + (same_group ? c_.twtr_l : c_.twtr_s);
                return b_closes && same_bank ? c_.cwl + c_.burst + c_.twr : 0;
            case kActivate:
                if (b.command == kActivate) return same_bank ? c_.trc : same_group ? c_.trrd_l : c_.trrd_s;
                if (b.command == kRead && same_bank) return c_.trcd_rd;
                if (b.command == kWrite && same_bank) return c_.trcd_wr;
                return b_closes && same_bank ? c_.tras : b.command == kRefresh ? c_.trc : 0;
            case kPrecharge:
            case kPrechargeAll:
                return b_opens && same_bank ? c_.trp : 0;
            case kRefresh:
                return c_.trfc;
        }
        return 0;
    }

    std::string check_windows(const IssuedCommand& now) {
        if (now.command != DramCommand::kActivate) return "";
        const auto too_many = [&](std::size_t count, std::uint32_t window) {
            return window != 0 && activations_.size() >= count &&
                   now.cycle < activations_[activations_.size() - count] + window;
        };
        if (too_many(4, c_.tfaw)) return fmt::format("tFAW at {}", now.cycle);
        if (too_many(32, c_.t32aw)) return fmt::format("t32AW at {}", now.cycle);
        activations_.push_back(now.cycle);
        return "";
    }

    std::string check_state(const IssuedCommand& now) {
        using enum DramCommand;
        std::int64_t& row = open_[now.bank];
        const bool any_open = std::any_of(open_.begin(), open_.end(), [](std::int64_t r) { return r >= 0; });
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
                std::fill(open_.begin(), open_.end(), -1);
                break;
            case kRefresh:
                if (any_open) return fmt::format("REF with an open bank at {}", now.cycle);
                ++refreshes;
                if (now.cycle > refreshes * c_.trefi + kHorizon)
                    return fmt::format("refresh {} is late: cycle {}", refreshes, now.cycle);
                break;
        }
        return "";
    }

    DramConfig c_;
    std::vector<std::int64_t> open_;
    std::deque<IssuedCommand> past_;
    std::vector<DramCycle> activations_;
};

}  // namespace ropsim
