// Cycles of a clock without division: against the division.
#include "memory/clock_period.h"

#include <cstdint>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

TEST(ClockPeriod, CyclesAreThoseOfADivisionWhateverThePeriod) {
    std::mt19937_64 random(7);
    for (const std::uint64_t period : {1ull, 2ull, 3ull, 7ull, 570ull, 571ull, 667ull, 1000ull, 4096ull,
                                       999'983ull, 1'000'000'000ull, 1ull << 40}) {
        const ClockPeriod clock(period);
        const auto check = [&](std::uint64_t time) {
            ASSERT_EQ(clock.cycle_of(time), time / period) << time << " of " << period;
            ASSERT_EQ(clock.cycle_from(time), (time + period - 1) / period) << time << " of " << period;
        };
        // Where the product is least exact: around whole cycles, up to the time from which it is not used.
        const std::uint64_t limit = std::numeric_limits<std::uint64_t>::max() / period;
        for (int i = 0; i < 20'000; ++i) {
            const std::uint64_t time = random() >> (1 + random() % 62);
            const std::uint64_t whole = time / period * period;
            for (const std::uint64_t near : {time, whole, whole + period - 1, whole + 1}) check(near);
        }
        for (const std::uint64_t near :
             {limit - 1, limit, limit + 1, limit / period * period - 1, limit / period * period})
            if (near < std::uint64_t{1} << 62) check(near);
    }
}

}  // namespace
}  // namespace ropsim
