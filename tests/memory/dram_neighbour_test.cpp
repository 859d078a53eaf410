// A channel takes the same commands alone as beside a pseudo-channel that nobody uses: alone, most are the
// usual kind, which has its own instances of the scheduler's functions.
#include "dram_driver.h"

#include "base/random.h"

#include <algorithm>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using Keys = std::vector<std::pair<std::string, std::string>>;

struct Channel {
    std::string device;
    std::string mapping;
    Keys keys;
};

void PrintTo(const Channel& channel, std::ostream* out) {
    *out << channel.device;
    for (const auto& [key, value] : channel.keys) *out << ' ' << key << '=' << value;
}

class Neighbour : public testing::TestWithParam<Channel> {};
INSTANTIATE_TEST_SUITE_P(
    Channels, Neighbour,
    testing::Values(Channel{"gddr3", "row column:4 bank column:2", {}},
                    Channel{"gddr5", "row column bank bankgroup", {{"dram.age_cap", "100"}}},
                    Channel{"gddr6", "row bank bankgroup column", {}},
                    Channel{"gddr6", "row bank bankgroup column", {{"dram.page_policy", "closed"}}},
                    Channel{"gddr6", "row bank bankgroup column", {{"dram.merge_writes", "true"}}},
                    Channel{"gddr6",
                            "row bank column:4 bankgroup column:2",
                            {{"dram.hit_cap", "2"}, {"dram.write_batch", "3"}}},
                    Channel{"gddr6", "row bank bankgroup column", {{"dram.write_drain", "snapshot"}}},
                    Channel{"lpddr4", "row column:4 bank column:2", {{"dram.arbitration", "oldest"}}}));

// Requests to addresses below `half`, some to one another's bytes, in bursts with pauses. No more reads at a
// time than a channel alone has numbers for.
void offer_some(DramDriver& driver, std::uint64_t half, std::size_t numbers) {
    DramCycle from = 0;
    std::size_t reads = 0;
    for (std::uint64_t i = 0; i < 20000; ++i) {
        const std::uint64_t r = mix64(i);
        const std::uint64_t span = (r & 1) != 0 ? std::uint64_t{1} << 16 : half;
        const std::uint32_t bytes = 32u << (r >> 1 & 3);
        if ((r >> 3 & 63) == 0) from = driver.now + (r >> 9 & 1023);
        if ((r >> 24 & 3) == 0) from = driver.now + (r >> 26 & 15);  // between two commands, too
        const std::uint64_t address = mix64(r) % span & ~std::uint64_t{31};
        const bool write = (r >> 19 & 3) == 0;
        while (!write && reads - driver.finished.size() == numbers) driver.advance();
        reads += write ? 0 : 1;
        driver.offer(std::min(address, half - bytes), bytes, write, from, (r >> 21 & 7) == 0);
    }
    driver.drain();
    driver.scheduler.finish(driver.now);
}

TEST_P(Neighbour, ChangesNothing) {
    const Channel& channel = GetParam();
    Keys keys = channel.keys;
    keys.emplace_back("dram.refresh", "none");  // two would take turns
    Keys keys_of_two = keys;
    keys.emplace_back("dram.mapping", channel.mapping);
    keys_of_two.emplace_back("dram.pseudochannels", "2");
    keys_of_two.emplace_back("dram.mapping", "pseudochannel " + channel.mapping);
    const DramConfig one = test_config(channel.device, keys);
    const DramConfig two = test_config(channel.device, keys_of_two);
    ASSERT_EQ(2 * one.capacity_bytes(), two.capacity_bytes());

    DramDriver alone(one), beside(two);
    offer_some(alone, one.capacity_bytes(), one.max_reads());
    offer_some(beside, one.capacity_bytes(), one.max_reads());
    const auto same = [](const IssuedCommand& a, const IssuedCommand& b) {
        return a.cycle == b.cycle && a.command == b.command && a.bank == b.bank && a.row == b.row &&
               a.column == b.column;
    };
    ASSERT_EQ(alone.recorder.commands.size(), beside.recorder.commands.size());
    const auto [first, other] =
        std::ranges::mismatch(alone.recorder.commands, beside.recorder.commands, same);
    ASSERT_EQ(first, alone.recorder.commands.end())
        << "at cycle " << first->cycle << ", not " << other->cycle;
    ASSERT_EQ(alone.finished.size(), beside.finished.size());
    for (std::size_t i = 0; i < alone.finished.size(); ++i)
        ASSERT_EQ(alone.finished[i].cycle, beside.finished[i].cycle) << i;
    const DramStatistics& a = alone.scheduler.statistics();
    const DramStatistics& b = beside.scheduler.statistics();
    ASSERT_EQ(a.cycles, b.cycles);
    EXPECT_EQ(a.read_queue_sum, b.read_queue_sum);
    EXPECT_EQ(a.write_queue_sum, b.write_queue_sum);
    EXPECT_GT(a.turnarounds, 10u);
    EXPECT_GT(a.row_conflicts, 1000u);
    for (int label = 0; label < kDramLabels; ++label) {
        const auto which = static_cast<DramLabel>(label);
        const std::uint64_t idle = which == DramLabel::kIdle ? b.cycles : 0;
        EXPECT_EQ(a.label(which) + idle, b.label(which)) << to_string(which);
    }
}

}  // namespace
}  // namespace ropsim
