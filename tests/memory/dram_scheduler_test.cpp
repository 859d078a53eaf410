// The scheduler under random traffic: legality by an independent checker, conservation, hazards, starvation.
#include "dram_driver.h"
#include "dram_rules.h"

#include "base/random.h"

#include <array>
#include <map>
#include <ostream>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using Keys = std::vector<std::pair<std::string, std::string>>;

struct Mix {
    std::string name;
    std::string device;  // preset, or a file of tests/memory/simulators
    Keys keys;
};

void PrintTo(const Mix& mix, std::ostream* out) {
    *out << mix.device;
}

const Keys kWide = {
    {"dram.ranks", "2"}, {"dram.trtrs", "2"}, {"dram.mapping", "row rank bank bankgroup column"}};

Keys with(Keys keys, const Keys& more) {
    keys.insert(keys.end(), more.begin(), more.end());
    return keys;
}

class RandomMix : public testing::TestWithParam<Mix> {};
INSTANTIATE_TEST_SUITE_P(
    Devices, RandomMix,
    testing::Values(
        Mix{"gddr3", "gddr3", {{"dram.mapping", "row bank column"}}},
        Mix{"gddr5", "gddr5", {{"dram.mapping", "row column bank bankgroup"}, {"dram.bank_xor", "true"}}},
        Mix{"gddr5x", "gddr5x", {}},
        Mix{"gddr6",
            "gddr6",
            {{"dram.mapping", "row bank column:4 bankgroup column:2"}, {"dram.bank_xor", "true"}}},
        Mix{"hbm2", "hbm2", {}},
        Mix{"hbm2_plain", "hbm2", {{"dram.mapping", "row pseudochannel bank bankgroup column"}}},
        Mix{"lpddr4", "lpddr4", {{"dram.bank_xor", "true"}}},
        Mix{"dramsim3_gddr5", "dramsim3_gddr5.toml", {}}, Mix{"dramsim3_gddr6", "dramsim3_gddr6.toml", {}},
        Mix{"dramsim3_hbm2", "dramsim3_hbm2.toml", {}}, Mix{"dramsys_hbm2", "dramsys_hbm2.toml", {}},
        Mix{"ramulator_gddr6", "ramulator_gddr6.toml", {}},
        Mix{"ramulator_mop4", "ramulator_gddr6_mop4.toml", {}},
        Mix{"ramulator_hbm2", "ramulator_hbm2.toml", {}}, Mix{"two_ranks", "gddr6", kWide},
        Mix{"two_ranks_oldest", "gddr6",
            with(kWide, {{"dram.arbitration", "oldest"},
                         {"dram.activated_leave_queue", "true"},
                         {"dram.refresh_closes_singly", "true"},
                         {"dram.hit_cap", "2"}})},
        Mix{"per_bank_refresh", "hbm2", {{"dram.refresh", "per_bank"}}},
        Mix{"per_bank_lpddr4",
            "lpddr4",
            {{"dram.refresh", "per_bank"},
             {"dram.trrefd", "20"},
             {"dram.ranks", "2"},
             {"dram.mapping", "row rank column:4 bank column:2"},
             {"dram.activated_leave_queue", "true"}}},
        Mix{"no_refresh", "gddr6", {{"dram.refresh", "none"}}},
        Mix{"closed_page", "hbm2", {{"dram.page_policy", "closed"}}},
        Mix{"timeout_page", "gddr6", {{"dram.page_policy", "timeout"}, {"dram.page_timeout", "50"}}},
        Mix{"fcfs", "gddr6", {{"dram.scheduler", "fcfs"}}},
        Mix{"no_drain", "gddr6", {{"dram.write_drain", "none"}, {"dram.front_cycles", "7"}}},
        Mix{"fcfs_no_drain", "hbm2", {{"dram.scheduler", "fcfs"}, {"dram.write_drain", "none"}}},
        Mix{"snapshot", "hbm2", {{"dram.write_drain", "snapshot"}, {"dram.back_cycles", "9"}}},
        Mix{"long_commands",
            "hbm2",
            {{"dram.row_bus_act", "3"},
             {"dram.row_bus_pre", "2"},
             {"dram.column_bus", "2"},
             {"dram.separate_buses", "false"}}}),
    [](const auto& mix) { return mix.param.name; });

// Bursts of locality, lulls longer than a refresh interval, reads and writes, sizes of 1 to 128 bytes.
TEST_P(RandomMix, EveryCommandKeepsEveryRule) {
    const Mix mix = GetParam();
    const bool file = mix.device.ends_with(".toml");
    const DramConfig c =
        test_config(file ? ROPSIM_SOURCE_DIR "/tests/memory/simulators/" + mix.device : mix.device, mix.keys);
    DramDriver d(c);
    std::uint64_t base = 0, read_bytes = 0, write_bytes = 0, bursts = 0;
    DramCycle cycle = 0;
    for (std::uint32_t i = 0; i < 100000; ++i) {
        const std::uint64_t r = mix64(i);
        if ((r & 31) == 0) base = mix64(r) & (c.capacity_bytes() - 1) & ~std::uint64_t{4095};
        if ((r >> 8 & 1023) == 0) cycle = d.now + (r >> 20 & 16383);
        const std::uint32_t bytes = 1u << (r >> 36 & 7);
        const std::uint64_t address = base + (r >> 40 & 4095) / bytes * bytes;
        const bool write = (r >> 60 & 3) == 0;
        ASSERT_NE(d.offer(address, bytes, write, cycle, (r >> 62 & 1) != 0), kNoCycle)
            << "stuck at request " << i;
        (write ? write_bytes : read_bytes) += bytes;
        bursts += (bytes + c.burst_bytes() - 1) / c.burst_bytes();
    }
    d.drain();
    d.scheduler.finish(d.now + 12345);
    DramRules rules(c);
    EXPECT_EQ(rules.check(d.recorder.commands), "");
    const DramStatistics& s = d.scheduler.statistics();
    EXPECT_EQ(rules.refreshes, s.refreshes);
    EXPECT_EQ(rules.bank_refreshes, s.bank_refreshes);
    const std::uint64_t ranks = c.pseudochannels * c.ranks;
    const auto due = [&](std::uint32_t interval) {
        std::uint64_t sum = 0;
        for (std::uint64_t r = 1; r <= ranks; ++r)
            sum += (s.cycles + interval - interval * r / ranks) / interval;
        return static_cast<double>(sum);
    };
    // All that came due, but for those that may still be waiting for their rank at the end.
    const double allowed = static_cast<double>(ranks);
    EXPECT_NEAR(static_cast<double>(s.refreshes), c.refresh == DramRefresh::kAllBank ? due(c.trefi) : 0,
                allowed);
    EXPECT_NEAR(static_cast<double>(s.bank_refreshes),
                c.refresh == DramRefresh::kPerBank ? due(c.trefipb) : 0, allowed);
    EXPECT_EQ(s.total_read().useful, read_bytes);
    EXPECT_EQ(s.total_write().useful, write_bytes);
    EXPECT_EQ(s.total_read().bus, d.recorder.cycles(DramCommand::kRead).size() * c.burst_bytes());
    EXPECT_EQ(s.total_write().bus, d.recorder.cycles(DramCommand::kWrite).size() * c.burst_bytes());
    EXPECT_LE(s.read_bursts + s.write_bursts, bursts);
    EXPECT_GE(s.read_bursts + s.write_bursts + s.total_read().forwarded + s.total_write().forwarded, bursts);
    EXPECT_EQ(d.finished.size(), s.reads);
    EXPECT_LE(s.row_misses + s.row_conflicts, s.activations);
}

// Each burst of each request is moved exactly once, reads and writes to where they were sent.
TEST(DramScheduler, MovesEveryBurstOnce) {
    const DramConfig c = test_config("gddr6", {{"dram.bank_xor", "true"}});
    DramDriver d(c);
    std::map<std::tuple<bool, std::uint32_t, std::uint32_t, std::uint32_t>, int> wanted;
    const AddressMap map(c, "test");
    const std::uint64_t forwarded_before = d.scheduler.statistics().forwarded_reads;
    for (std::uint32_t i = 0; i < 20000; ++i) {
        const std::uint64_t r = mix64(i + 77);
        const std::uint64_t address = (r & 0xffff) * 128;
        const bool write = (r >> 40 & 1) != 0;
        const std::uint64_t forwarded = d.scheduler.statistics().forwarded_reads;
        d.offer(address, 128, write);
        if (d.scheduler.statistics().forwarded_reads != forwarded) continue;
        for (std::uint64_t a = address; a < address + 128; a += c.burst_bytes()) {
            const DramPlace place = map.place(a);
            ++wanted[{write, place.bank, place.row, place.column}];
        }
    }
    d.drain();
    for (const IssuedCommand& issued : d.recorder.commands)
        if (issued.command == DramCommand::kRead || issued.command == DramCommand::kWrite)
            --wanted[{issued.command == DramCommand::kWrite, issued.bank, issued.row, issued.column}];
    for (const auto& [key, count] : wanted) ASSERT_EQ(count, 0);
    EXPECT_EQ(forwarded_before, 0u);
}

TEST(DramScheduler, MillionRequestsConserveBytes) {
    const DramConfig c = test_config("gddr6");
    DramScheduler s(c);
    std::vector<std::uint32_t> numbers;
    for (std::uint32_t i = 0; i < c.max_reads(); ++i) numbers.push_back(i);
    std::array<std::array<std::uint64_t, kMemoryCauses>, 8> useful[2] = {};
    DramCycle now = 0;
    const auto step = [&] {
        now = std::max(now, s.next());
        s.step(now);
        for (const auto& done : s.finished()) numbers.push_back(done.number);
        s.finished().clear();
    };
    for (std::uint32_t i = 0; i < 1000000; ++i) {
        const std::uint64_t r = mix64(i ^ 0x5eed);
        DramRequest request;
        request.bytes = static_cast<std::uint32_t>(1 + (r >> 20) % 128);
        request.address = (r & 0xfffff) * 128 + (r >> 28) % (129 - request.bytes);
        request.write = (r >> 40 & 1) != 0;
        request.surface = static_cast<std::uint8_t>(r >> 41 & 7);
        request.cause = static_cast<MemoryCause>((r >> 44) % kMemoryCauses);
        while (true) {
            if (!request.write && !numbers.empty()) request.number = numbers.back();
            if ((request.write || !numbers.empty()) && s.push(request, now, now)) break;
            ASSERT_NE(s.next(), kNoCycle);
            step();
        }
        if (!request.write) numbers.pop_back();
        for (const auto& done : s.finished()) numbers.push_back(done.number);
        s.finished().clear();
        useful[request.write][request.surface][static_cast<std::size_t>(request.cause)] += request.bytes;
    }
    while (s.next() != kNoCycle) step();
    s.finish(now);  // checks bus bytes against column commands, labels against cycles
    EXPECT_EQ(numbers.size(), c.max_reads());
    for (std::size_t surface = 0; surface < 8; ++surface)
        for (std::size_t cause = 0; cause < kMemoryCauses; ++cause) {
            EXPECT_EQ(s.statistics().read[surface][cause].useful, useful[0][surface][cause]);
            EXPECT_EQ(s.statistics().write[surface][cause].useful, useful[1][surface][cause]);
            EXPECT_GE(s.statistics().write[surface][cause].bus, useful[1][surface][cause]);
        }
}

TEST(DramScheduler, SmallRequestsMoveWholeBursts) {
    const DramConfig c = test_config("gddr5");  // 64-byte bursts
    DramDriver d(c);
    d.offer(32, 32, false);
    d.offer(4096 + 60, 8, true);  // straddles two bursts
    d.drain();
    EXPECT_EQ(d.scheduler.statistics().total_read().useful, 32u);
    EXPECT_EQ(d.scheduler.statistics().total_read().bus, 64u);
    EXPECT_EQ(d.scheduler.statistics().total_write().useful, 8u);
    EXPECT_EQ(d.scheduler.statistics().total_write().bus, 128u);
}

TEST(DramScheduler, ReadOfAQueuedWriteIsForwarded) {
    const DramConfig c = test_config("gddr6");
    DramDriver d(c);
    d.offer(1 << 20, 64, false, 100);  // keeps the bus with reads
    d.offer(256, 64, true, 100);
    EXPECT_EQ(d.offer(256, 32, false, 100), 100u);
    ASSERT_EQ(d.finished.size(), 1u);
    EXPECT_EQ(d.finished[0].cycle, 100u + c.forward_cycles);
    d.drain();
    EXPECT_EQ(d.scheduler.statistics().forwarded_reads, 1u);
    EXPECT_EQ(d.scheduler.statistics().total_read().forwarded, 32u);
    EXPECT_EQ(d.scheduler.statistics().total_read().bus, 64u);
}

// A masked write cannot serve the read: it must reach the DRAM first.
TEST(DramScheduler, ReadWaitsForAMaskedWrite) {
    const DramConfig c = test_config("gddr6");
    DramDriver d(c);
    d.offer(1 << 20, 64, false, 100);
    d.offer(256, 64, true, 100, true);
    EXPECT_NE(d.offer(256, 32, false, 100), kNoCycle);
    d.drain();
    const AddressMap map(c, "test");
    const DramPlace place = map.place(256);
    DramCycle written = 0, read = 0;
    for (const IssuedCommand& issued : d.recorder.commands) {
        if (issued.bank != place.bank || issued.row != place.row || issued.column != place.column) continue;
        if (issued.command == DramCommand::kWrite) written = issued.cycle;
        if (issued.command == DramCommand::kRead) read = issued.cycle;
    }
    EXPECT_GT(written, 0u);
    EXPECT_GT(read, written);
}

// ... and ahead of the reads that are queued already.
TEST(DramScheduler, AWriteThatAReadWaitsForIsHurried) {
    const DramConfig c = test_config("gddr6");
    DramDriver d(c);
    for (std::uint64_t i = 1; i < 12; ++i) d.offer(i << 20, 64, false, 100);
    d.offer(256, 64, true, 100, true);
    const DramCycle admitted = d.offer(256, 32, false, 100);
    EXPECT_LE(admitted, 100u + c.trtw + c.trcd_wr + c.trrd_l);
    EXPECT_LT(d.finished.size(), 11u);
}

// And a write waits for the older read.
TEST(DramScheduler, SameAddressBackToBackNeverSticks) {
    const DramConfig c = test_config("gddr5");
    DramDriver d(c);
    for (std::uint32_t i = 0; i < 3000; ++i) {
        const std::uint64_t r = mix64(i);
        ASSERT_NE(d.offer((r & 3) * 64, 64, (r >> 20 & 1) != 0, 0, (r >> 21 & 1) != 0), kNoCycle) << i;
    }
    d.drain();
    std::vector<bool> order;
    d.scheduler.finish(d.now);
    EXPECT_EQ(d.scheduler.statistics().reads + d.scheduler.statistics().writes, 3000u);
}

// A stream of hits to one row must not starve a request to another row of the same bank.
TEST(DramScheduler, AgeCapEndsStarvation) {
    const auto latency = [](const char* cap) {
        const DramConfig c = test_config(
            "gddr5", {{"dram.mapping", "row bank column"}, {"dram.trefi", "0"}, {"dram.age_cap", cap}});
        DramDriver d(c);
        for (std::uint64_t i = 0; i < 16; ++i) d.offer(i * 64, 64, false);
        const std::uint64_t victim = std::uint64_t{c.row_bytes} * c.banks();
        d.offer(victim, 64, false);
        for (std::uint64_t i = 0; i < 20000; ++i) d.offer(i % 128 * 64, 64, false);
        d.drain();
        for (const IssuedCommand& issued : d.recorder.commands)
            if (issued.command == DramCommand::kRead && issued.row == 1) return issued.cycle;
        return kNoCycle;
    };
    EXPECT_GT(latency("1000000"), 30000u);
    EXPECT_LT(latency("500"), 500u + 200u);
}

// A flood of writes must not shut reads out, nor the reverse.
TEST(DramScheduler, ReadsPassAWriteFlood) {
    const DramConfig c = test_config("gddr6");
    DramDriver d(c);
    std::uint64_t writes = 0;
    for (std::uint64_t i = 0; i < 200; ++i) d.offer((i * 4096 + (writes++ % 16) * 128) & 0xffffff, 64, true);
    d.offer(1 << 26, 64, false);
    const DramCycle start = d.now;
    while (d.finished.empty() && d.now < start + 100000) d.offer((writes++ * 4096) & 0xffffff, 64, true);
    ASSERT_FALSE(d.finished.empty());
    EXPECT_LT(d.finished[0].cycle - start, 3000u);
}

TEST(DramScheduler, LongIdleRefreshesInArrears) {
    const DramConfig c = test_config("gddr5x");
    DramDriver d(c);
    d.offer(0, 64, false, 10);
    d.offer(0, 64, false, 10 * c.trefi + c.trfc + 100);  // all rows were closed by the refreshes
    d.drain();
    d.scheduler.finish(20 * c.trefi + c.trfc + 50);
    const DramStatistics& s = d.scheduler.statistics();
    EXPECT_EQ(s.refreshes, 20u);
    EXPECT_EQ(s.row_misses, 2u);
    EXPECT_EQ(s.cycles, 20 * c.trefi + c.trfc + 50);
    EXPECT_EQ(s.label(DramLabel::kRefresh), 0u);  // nobody waited for one
    // A request into a refresh waits for its end.
    DramDriver e(c);
    e.offer(0, 64, false, c.trefi + 1);
    e.drain();
    EXPECT_EQ(e.finished[0].cycle, c.trefi + c.trfc + c.trcd_rd + c.cl + c.burst);
    e.scheduler.finish(e.now);
    EXPECT_EQ(e.scheduler.statistics().label(DramLabel::kRefresh), c.trfc - 1);
}

// What an observer sees while reads and then writes are served.
TEST(DramScheduler, ShowsWhatIsQueuedOpenAndDrained) {
    const DramConfig c = test_config("gddr6");
    DramDriver driver(c);
    const DramScheduler& s = driver.scheduler;
    for (std::uint64_t i = 0; i < 3; ++i) driver.offer(i * c.row_bytes * 4, 32, false);
    EXPECT_EQ(s.queued_reads(), 3u);
    EXPECT_EQ(s.queued_writes() + s.open_banks() + s.draining(), 0u);
    driver.drain();
    EXPECT_EQ(s.queued_reads(), 0u);
    const std::size_t opened = driver.recorder.cycles(DramCommand::kActivate).size();
    EXPECT_EQ(s.open_banks(), opened - driver.recorder.cycles(DramCommand::kPrecharge).size());
    for (std::uint64_t i = 0; i < c.write_high; ++i) driver.offer(i * c.row_bytes, 32, true, driver.now);
    EXPECT_EQ(s.queued_writes(), c.write_high);
    EXPECT_EQ(s.draining(), 1u);
    driver.drain();
    EXPECT_EQ(s.queued_writes(), 0u);
}

}  // namespace
}  // namespace ropsim
