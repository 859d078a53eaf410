// The cycles that a quad's pixels take in the lanes of a partition, and when the last of them is done.
#pragma once

#include "rop/cost.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

namespace ropsim {

// Pixels start side by side, `lanes` at a time; the next ones when the slowest of those has left its lane.
class LaneGroups {
 public:
    explicit LaneGroups(std::uint32_t lanes) : lanes_(lanes) {}

    // An operation that took this path with so many list steps and `turns` cycles for formats and samples.
    void add(const PathCost& path, const std::array<std::uint32_t, 2>& steps, std::uint32_t turns) {
        auto interval = static_cast<std::uint32_t>(path.interval);
        auto latency = static_cast<std::uint32_t>(path.latency());
        if (std::bit_cast<std::uint64_t>(steps) != 0) {
            interval = static_cast<std::uint32_t>(path.interval_cycles(steps));
            latency = static_cast<std::uint32_t>(path.latency_cycles(steps));
        }
        latency_ = std::max(latency_, before_ + latency + turns - 1);
        slowest_ = std::max({slowest_, interval, turns});
        if (++in_group_ < lanes_) return;
        before_ += slowest_;
        slowest_ = 0;
        in_group_ = 0;
    }
    std::uint32_t interval() const { return before_ + slowest_; }
    std::uint32_t latency() const { return latency_; }

 private:
    std::uint32_t lanes_;
    std::uint32_t in_group_ = 0;
    std::uint32_t before_ = 0;   // cycles of the groups that have left
    std::uint32_t slowest_ = 0;  // of the pixels in the lanes
    std::uint32_t latency_ = 0;
};

}  // namespace ropsim
