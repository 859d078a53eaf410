// Closed forms of DRAM timing: latencies, streaming, random limits, turnaround, refresh.
#include "dram_driver.h"

#include "base/random.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using testing::ElementsAre;

// Without refresh, and with rows whole in one bank: an address is row | bank | column.
DramConfig plain(const std::string& device, std::vector<std::pair<std::string, std::string>> more = {}) {
    more.insert(more.begin(), {{"dram.trefi", "0"}, {"dram.mapping", "row bank bankgroup column"}});
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
    EXPECT_EQ(d.finished[0].cycle - 1000, c.trcd_rd + c.cl + c.burst);
    // The row is open now.
    d.offer(c.burst_bytes(), 32, false, 2000);
    d.drain();
    EXPECT_EQ(d.finished[1].cycle - 2000, c.cl + c.burst);
    // Another row of the bank: precharge first.
    d.offer(std::uint64_t{c.row_bytes} * c.banks(), 32, false, 3000);
    d.drain();
    EXPECT_EQ(d.finished[2].cycle - 3000, c.trp + c.trcd_rd + c.cl + c.burst);
    EXPECT_EQ(d.scheduler.statistics().row_hits, 1u);
    EXPECT_EQ(d.scheduler.statistics().row_misses, 1u);
    EXPECT_EQ(d.scheduler.statistics().row_conflicts, 1u);
}

// The next command of each pair is issued in the very cycle in which the rule releases it.
TEST_P(EachDevice, RowRulesReleaseInTheirCycle) {
    const DramConfig c = plain(GetParam());
    const std::uint64_t next_row = std::uint64_t{c.row_bytes} * c.banks();
    DramDriver d(c);
    d.offer(0, 1, false, 0);
    d.offer(next_row, 1, false, 0);
    d.drain();
    const DramCycle precharge = std::max(c.tras, c.trcd_rd + c.trtp);
    EXPECT_THAT(d.recorder.cycles(DramCommand::kPrecharge), ElementsAre(precharge));
    EXPECT_THAT(d.recorder.cycles(DramCommand::kActivate),
                ElementsAre(0, std::max<DramCycle>(c.trc, precharge + c.trp)));

    DramDriver w(c);
    w.offer(0, 1, true, 100);
    w.offer(next_row, 1, true, 100);
    w.drain();
    const DramCycle recovered = std::max<DramCycle>(c.tras, c.trcd_wr + c.cwl + c.burst + c.twr);
    EXPECT_THAT(w.recorder.cycles(DramCommand::kPrecharge), ElementsAre(100 + recovered));
}

TEST_P(EachDevice, ColumnAndActivateGaps) {
    const DramConfig c = plain(GetParam());
    const std::uint64_t other_bank = std::uint64_t{c.row_bytes} * c.bank_groups;  // same group, next bank
    DramDriver d(c);
    d.offer(0, 1, false, 0);
    d.offer(other_bank, 1, false, 0);
    d.drain();
    EXPECT_THAT(d.recorder.cycles(DramCommand::kActivate), ElementsAre(0, c.trrd_l));
    // Rows are open in both banks: two reads of one group, and if there are groups, of two.
    const DramCycle start = d.now + 1000;
    d.offer(c.burst_bytes(), 1, false, start);
    d.offer(other_bank + c.burst_bytes(), 1, false, start);
    d.drain();
    std::vector<DramCycle> reads = d.recorder.cycles(DramCommand::kRead);
    EXPECT_EQ(reads[3] - reads[2], std::max(c.tccd_l, c.burst));
    if (c.bank_groups == 1) return;
    d.offer(c.row_bytes, 1, false, start + 1000);
    d.drain();
    d.offer(0, 1, false, start + 2000);
    d.offer(c.row_bytes, 1, false, start + 2000);
    d.drain();
    reads = d.recorder.cycles(DramCommand::kRead);
    EXPECT_EQ(reads[6] - reads[5], std::max(c.tccd_s, c.burst));
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

// Activations of different banks: four a tFAW, 32 a t32AW, and tRRD apart.
TEST_P(EachDevice, ActivationWindows) {
    const DramConfig c = plain(GetParam());
    DramDriver d(c);
    for (std::uint64_t i = 0; i < c.banks(); ++i) d.offer(i * c.row_bytes, 1, false, 0);
    d.drain();
    const std::vector<DramCycle> acts = d.recorder.cycles(DramCommand::kActivate);
    ASSERT_EQ(acts.size(), c.banks());
    EXPECT_EQ(acts[1], c.bank_groups == 1 ? c.trrd_l : c.trrd_s);
    // Commands share one bus with the reads, so each may slip by a cycle.
    EXPECT_GE(acts[4], std::max(c.tfaw, 4 * c.trrd_s));
    EXPECT_LE(acts[4], std::max(c.tfaw, 4 * c.trrd_l) + 2);
}

// Row hits stream at one burst a column interval; each refresh costs what it takes to close, refresh and
// reopen.
TEST_P(EachDevice, RowHitsStreamAtTheirInterval) {
    for (const char* refresh_interval : {"0", "20000"}) {
        // The queue sees far enough ahead to open the next row behind the data of this one, and successive
        // bursts alternate between bank groups.
        const DramConfig c = test_config(GetParam(), {{"dram.mapping", "row bank column bankgroup"},
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
        const double lost = c.trtp + c.trp + c.trfc + c.trcd_rd;
        const double refreshing = c.trefi == 0 ? 0 : lost / c.trefi;
        const double expected = static_cast<double>(count * c.column_interval()) / (1 - refreshing);
        EXPECT_NEAR(static_cast<double>(s.cycles) / expected, 1.0, 0.01) << c.trefi;
        EXPECT_EQ(s.refreshes, c.trefi == 0 ? 0 : s.cycles / c.trefi);
    }
}

// Random reads: bound by the activation windows and refresh.
TEST(DramRandom, ReadsReachTheActivationBound) {
    for (const char* device : {"gddr5", "gddr5x", "gddr6", "hbm2"}) {
        const DramConfig c = test_config(device, {{"dram.mapping", "row bank bankgroup column"}});
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
        bound *= 1 - static_cast<double>(c.trtp + c.trp + c.trfc) / c.trefi;  // close, refresh
        EXPECT_LE(rate, bound * 1.01) << device;
        EXPECT_GE(rate, bound * 0.96) << device << " " << rate / bound;
    }
}

}  // namespace
}  // namespace ropsim
