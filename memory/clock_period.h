// Cycles of a clock from picoseconds, without a division: every step of a unit and every memory request asks.
#pragma once

#include <cstdint>

namespace ropsim {

// Rounding up to a multiple and down to one are exact for every time (< 2^63).
class ClockPeriod {
 public:
    // `picoseconds` > 0.
    explicit constexpr ClockPeriod(std::uint64_t picoseconds)
        : period_(picoseconds),
          inverse_(~std::uint64_t{0} / picoseconds + 1),
          exact_below_(picoseconds == 1 ? 0 : inverse_ - 1) {}
    constexpr std::uint64_t picoseconds() const { return period_; }
    // Whole cycles before `time`: the cycle that it lies in.
    constexpr std::uint64_t cycle_of(std::uint64_t time) const {
        // inverse_ * period_ exceeds 2^64 by e <= period_. The product below is then too large by
        // time * e / (2^64 period_) cycles, which is less than 1 / period_ and does not reach the next cycle
        // while time < 2^64 / period_.
        if (time < exact_below_) [[likely]]
            return static_cast<std::uint64_t>(Wide{time} * inverse_ >> 64);
        return time / period_;
    }
    // The first cycle that starts at `time` or later.
    constexpr std::uint64_t cycle_from(std::uint64_t time) const { return cycle_of(time + period_ - 1); }

 private:
    __extension__ using Wide = unsigned __int128;
    std::uint64_t period_;
    std::uint64_t inverse_;
    std::uint64_t exact_below_;
};

}  // namespace ropsim
