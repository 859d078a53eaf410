// Closed forms of DRAM timing: latencies, streaming, random limits, turnaround, refresh.
#include "dram_driver.h"

#include "base/random.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using testing::ElementsAre;

constexpr const char* kPlain = "row rank pseudochannel bank bankgroup column";

// Without refresh, and with rows whole in one bank: an address is row | bank | column.
DramConfig plain(const std::string& device, std::vector<std::pair<std::string, std::string>> more = {}) {
    more.insert(more.begin(), {{"dram.trefi", "0"}, {"dram.mapping", kPlain}});
    return test_config(device, more);
}

class EachDevice : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Presets, EachDevice,
                         testing::Values("gddr3", "gddr5", "gddr5x", "gddr6", "hbm2", "lpddr4"),
                         [](const auto& device) { return std::string(device.param); });

TEST_P(EachDevice, UnloadedReadTakesActivateColumnBurst) {
    const DramConfig c = plain(GetParam());
    DramDriver d(c);
    d.offer(0, 32, false, 1000);
    d.drain();
    ASSERT_EQ(d.finished.size(), 1u);
    EXPECT_EQ(d.finished[0].cycle - 1000, c.activate_to_read() + c.read_cycles());
    // The row is open now.
    d.offer(c.burst_bytes(), 32, false, 2000);
    d.drain();
    EXPECT_EQ(d.finished[1].cycle - 2000, c.read_cycles());
    // Another row of the bank: precharge first.
    d.offer(std::uint64_t{c.row_bytes} * c.banks(), 32, false, 3000);
    d.drain();
    EXPECT_EQ(d.finished[2].cycle - 3000, c.row_bus_pre - 1 + c.trp + c.trcd_rd + c.cl + c.burst);
    EXPECT_EQ(d.scheduler.statistics().row_hits, 1u);
    EXPECT_EQ(d.scheduler.statistics().row_misses, 1u);
    EXPECT_EQ(d.scheduler.statistics().row_conflicts, 1u);
}

TEST_P(EachDevice, TurnaroundGaps) {
    const DramConfig c = plain(GetParam(), {{"dram.write_idle", "0"}});
    const std::uint64_t b = c.burst_bytes();
    DramDriver d(c);
    d.offer(0, 1, false, 0);
    d.drain();  // opens the row
    d.offer(b, 1, false, 1000);
    d.offer(2 * b, 1, true, 1000);
    d.drain();
    EXPECT_THAT(d.recorder.cycles(DramCommand::kWrite), ElementsAre(1000 + c.trtw));
    const DramCycle write = 1000 + c.trtw;
    d.offer(3 * b, 1, false, write + 1);
    d.drain();
    EXPECT_EQ(d.recorder.cycles(DramCommand::kRead).back(), write + c.cwl + c.burst + c.twtr_l);
    EXPECT_EQ(d.scheduler.statistics().turnarounds, 2u);
    d.scheduler.finish(d.now);
    const DramStatistics& s = d.scheduler.statistics();
    EXPECT_EQ(s.label(DramLabel::kTurnaround), c.trtw - c.burst + c.cwl + c.twtr_l);
}

// Row hits stream at one burst a column interval; each refresh costs what it takes to close, refresh and
// reopen.
TEST_P(EachDevice, RowHitsStreamAtTheirInterval) {
    for (const char* refresh_interval : {"0", "20000"}) {
        // The queue sees far enough ahead to open the next row behind the data of this one, and successive
        // bursts alternate between bank groups.
        const DramConfig c =
            test_config(GetParam(), {{"dram.mapping", "row rank bank column bankgroup pseudochannel"},
                                     {"dram.trefi", refresh_interval},
                                     {"dram.read_queue", "54"},
                                     {"dram.write_queue", "10"},
                                     {"dram.write_high", "8"},
                                     {"dram.write_low", "2"}});
        DramDriver d(c);
        const std::uint64_t count = 200000;
        for (std::uint64_t i = 0; i < count; ++i) d.offer(i * c.burst_bytes(), c.burst_bytes(), false);
        d.drain();
        d.scheduler.finish(d.now);
        const DramStatistics& s = d.scheduler.statistics();
        // From the last read before a refresh to the first after it.
        const double lost = c.trtp + c.trp + c.trfc + c.activate_to_read();
        const double refreshing = c.trefi == 0 ? 0 : lost / c.trefi;
        const double expected =
            static_cast<double>(count / c.pseudochannels * c.column_interval()) / (1 - refreshing);
        EXPECT_NEAR(static_cast<double>(s.cycles) / expected, 1.0, 0.01) << c.trefi;
        const std::uint64_t units = c.ranks * c.pseudochannels;
        EXPECT_EQ(s.refreshes, c.trefi == 0 ? 0 : s.cycles * units / c.trefi);
    }
}

// Random reads of one burst: bound by the activation windows or the row bus, and refresh.
TEST(DramRandom, ReadsReachTheActivationBound) {
    for (const char* device : {"gddr5", "gddr5x", "gddr6", "hbm2"}) {
        const DramConfig c = test_config(device, {{"dram.mapping", kPlain}});
        DramDriver d(c);
        const std::uint64_t count = 60000;
        for (std::uint64_t i = 0; i < count; ++i) {
            const std::uint64_t block = mix64(20240607 + i) & ((c.capacity_bytes() / 64) - 1);
            d.offer(block * 64, 64, false);
        }
        d.drain();
        const double rate = static_cast<double>(count) / static_cast<double>(d.now);
        double bound = 1.0 / c.trrd_s;
        if (c.tfaw != 0) bound = std::min(bound, 4.0 / c.tfaw);
        if (c.t32aw != 0) bound = std::min(bound, 32.0 / c.t32aw);
        bound *= c.pseudochannels;
        if (c.separate_buses) bound = std::min(bound, 1.0 / (c.row_bus_act + c.row_bus_pre));
        bound *= 1 - static_cast<double>(c.trtp + c.trp + c.trfc) / c.trefi;  // close, refresh
        EXPECT_LE(rate, bound * 1.01) << device;
        EXPECT_GE(rate, bound * 0.95) << device << " " << rate / bound;
    }
}

// Closed forms within 1 %: reads that all go to a new row, spread so that one rule binds.
struct RowRate {
    const char* limit;
    std::vector<std::pair<std::string, std::string>> keys;
    std::uint32_t banks;  // taken in turn
    double cycles;        // an access
};

TEST(DramRows, RateIsThatOfTheBindingRule) {
    const std::vector<RowRate> rates = {{"tRC of one bank", {}, 1, 90.0},
                                        {"tRRD", {{"dram.tfaw", "0"}}, 16, 11.0},
                                        {"tFAW", {{"dram.tfaw", "60"}}, 16, 60 / 4.0},
                                        {"t32AW", {{"dram.t32aw", "600"}}, 16, 600 / 32.0},
                                        {"row bus",
                                         {{"dram.tfaw", "0"},
                                          {"dram.trrd_s", "1"},
                                          {"dram.trrd_l", "1"},
                                          {"dram.separate_buses", "true"},
                                          {"dram.row_bus_act", "8"},
                                          {"dram.trp", "2"},
                                          {"dram.tras", "10"},
                                          {"dram.trc", "12"},
                                          {"dram.trcd_rd", "2"}},
                                         16,
                                         9.0}};
    for (const RowRate& rate : rates) {
        std::vector<std::pair<std::string, std::string>> keys = rate.keys;
        for (const auto& key : {"dram.read_queue", "dram.write_queue"}) keys.emplace_back(key, "64");
        const DramConfig c = plain("gddr6", keys);
        DramDriver d(c);
        const std::uint64_t count = 4000;
        for (std::uint64_t i = 0; i < count; ++i)  // a new row of bank i mod banks
            d.offer((i / rate.banks % c.rows * c.banks() + i % rate.banks) * c.row_bytes, 32, false);
        d.drain();
        EXPECT_NEAR(static_cast<double>(d.now) / static_cast<double>(count) / rate.cycles, 1.0, 0.01)
            << rate.limit;
        EXPECT_EQ(d.scheduler.statistics().activations, count) << rate.limit;
    }
}

// Alternating reads and writes of one row, each offered when the last has gone: read to write and back.
TEST(DramTurnaround, CostsTheSumOfBothGaps) {
    const DramConfig c = plain("gddr6", {{"dram.write_idle", "0"}});
    DramDriver d(c);
    const std::uint64_t count = 2000;
    for (std::uint64_t i = 0; i < count; ++i) {
        d.offer(i % 32 * 64, 32, i % 2 != 0, d.now);
        d.drain();
    }
    const double pair = c.trtw + c.cwl + c.burst + c.twtr_l;
    EXPECT_NEAR(static_cast<double>(d.now) / (pair * count / 2), 1.0, 0.01);
}

}  // namespace
}  // namespace ropsim
