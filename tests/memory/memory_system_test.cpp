// The memory without SystemC: the same cycles as over TLM, channels that stall the stream, needs, wrapping.
#include "memory/memory_system.h"

#include "dram_driver.h"
#include "memory_client.h"

#include "base/error.h"
#include "base/random.h"
#include "memory/access_pattern.h"
#include "memory/dram_channel.h"
#include "memory/memory_run.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using Keys = std::vector<std::pair<std::string, std::string>>;

MemoryConfig memory_of(const std::string& device, const Keys& keys = {}) {
    Parameters parameters("test");
    parameters.set("dram.device", device, "test");
    for (const auto& [key, value] : keys) parameters.set(key, value, "test");
    MemoryConfig config = memory_config(parameters);
    parameters.close();
    return config;
}

class Listed : public RequestSource {
 public:
    explicit Listed(std::vector<AddressRequest> requests) : requests_(std::move(requests)) {}
    bool next(std::vector<AddressRequest>& block) override {
        block = std::exchange(requests_, {});
        return !block.empty();
    }

 private:
    std::vector<AddressRequest> requests_;
};

AddressRequest request(std::uint64_t address, bool write = false, std::uint64_t cycle = 0) {
    AddressRequest r;
    r.address = address;
    r.write = write;
    r.cycle = cycle;
    return r;
}

// Bursts of requests and pauses, hot addresses for hazards, reads and writes.
std::vector<AddressRequest> traffic(std::uint64_t count, std::uint64_t capacity) {
    std::vector<AddressRequest> all;
    std::uint64_t cycle = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
        const std::uint64_t r = mix64(i + 77);
        if (r % 50 == 0) cycle += r >> 8 & 1023;
        if (r % 5000 == 1) cycle += 20000;
        const std::uint64_t block = (r >> 20 & 3) == 0 ? r >> 24 & 63 : r >> 24;
        all.push_back(request(block * 64 & (capacity - 1), (r & 0x60) == 0, cycle));
    }
    return all;
}

// One TEST a device: SystemC elaborates once a process.
void expect_the_same_over_tlm(const std::string& device) {
    const MemoryConfig config = memory_of(device);
    const DramConfig& c = config.dram;
    const auto requests = traffic(20000, c.capacity_bytes());
    CommandRecorder direct;
    MemorySystem system(config);
    system.set_trace(0, &direct);
    for (const AddressRequest& r : requests) system.offer(r);
    const DramCycle end = system.finish();

    use_picosecond_resolution();
    EventWheel wheel("wheel");
    MemoryClient client(wheel, 1024);
    DramChannel channel("channel", wheel, c);
    client.port.socket.bind(channel.socket);
    CommandRecorder over_tlm;
    channel.set_trace(&over_tlm);
    std::vector<MemoryClient::Item> items;
    for (const AddressRequest& r : requests) {
        MemoryRequest m;
        m.address = r.address;
        m.bytes = 64;
        m.write = r.write;
        m.cause = r.write ? MemoryCause::kWriteBack : MemoryCause::kFill;
        items.push_back({r.cycle * c.tck_ps, m});
    }
    client.start(items);
    sc_core::sc_start();
    channel.finish(sc_core::sc_time_stamp().value());

    ASSERT_EQ(direct.commands.size(), over_tlm.commands.size());
    for (std::size_t i = 0; i < direct.commands.size(); ++i) {
        const IssuedCommand& a = direct.commands[i];
        const IssuedCommand& b = over_tlm.commands[i];
        ASSERT_EQ(std::tie(a.cycle, a.command, a.bank, a.row, a.column),
                  std::tie(b.cycle, b.command, b.bank, b.row, b.column))
            << i;
    }
    const DramStatistics& s = system.statistics(0);
    const DramStatistics& t = channel.statistics();
    EXPECT_EQ(end, t.cycles);
    EXPECT_EQ(s.label_cycles, t.label_cycles);
    EXPECT_EQ(s.read_latency.mean(), t.read_latency.mean());
    EXPECT_EQ(s.read_latency.maximum(), t.read_latency.maximum());
    EXPECT_EQ(s.blocked_cycles, t.blocked_cycles);
    EXPECT_GT(s.forwarded_reads, 0u);
    EXPECT_GT(s.blocked_cycles, 0u);
}

TEST(MemorySystem, SameCyclesAsOverTlmGddr5) {
    expect_the_same_over_tlm("gddr5");
}
TEST(MemorySystem, SameCyclesAsOverTlmGddr6) {
    expect_the_same_over_tlm("gddr6");
}
TEST(MemorySystem, SameCyclesAsOverTlmHbm2) {
    expect_the_same_over_tlm("hbm2");
}

// The head of the line waits for its channel, and everything behind it for the head.
TEST(MemorySystem, AFullChannelStallsTheStream) {
    const MemoryConfig config = memory_of(
        "gddr6",
        {{"memory.channels", "2"}, {"dram.refresh", "none"}, {"dram.mapping", "row bank bankgroup column"}});
    CommandRecorder other;
    MemorySystem system(config);
    system.set_trace(1, &other);
    // Row conflicts in one bank of channel 0, three times as many as its queue holds, then one for channel 1.
    const std::uint64_t row = 2 * config.dram.capacity_bytes() / config.dram.rows;
    const std::uint64_t count = 3 * config.dram.read_queue;
    for (std::uint64_t i = 0; i < count; ++i) system.offer(request(i * row));
    const DramCycle offered = system.offer(request(256));
    system.finish();
    const DramStatistics& s = system.statistics(0);
    EXPECT_EQ(s.activations, count);
    // Accepted are those that have left and a queue's worth.
    EXPECT_GE(offered, (count - config.dram.read_queue - 2) * config.dram.trc);
    EXPECT_LE(offered, count * config.dram.trc);
    ASSERT_FALSE(other.commands.empty());
    EXPECT_EQ(other.commands.front().cycle, offered + config.dram.front_cycles);
    EXPECT_EQ(s.blocked_cycles, offered);
}

// Channels work at the same time: n of them take 1/n of the time, and are equally busy.
TEST(MemorySystem, ChannelsAddUp) {
    DramCycle one = 0;
    for (const char* channels : {"1", "2", "8"}) {
        const MemoryConfig config =
            memory_of("gddr5", {{"memory.channels", channels}, {"dram.refresh", "none"}});
        PatternOptions options;
        options.name = "seq_read";
        options.requests = 64000;
        options.span = std::uint64_t{1} << 30;
        AccessPattern source(options);
        const MemoryRun run = run_memory(config, source);
        if (config.channels == 1) one = run.cycles;
        EXPECT_NEAR(static_cast<double>(run.cycles * config.channels) / static_cast<double>(one), 1.0, 0.03);
        EXPECT_EQ(run.useful_bytes(), 64000u * 64);
        for (const DramStatistics& s : run.channels) EXPECT_EQ(s.reads, 64000 / config.channels);
        EXPECT_LT(run.bytes_per_second(), config.peak_bytes_per_second());
    }
}

// Each read of a chase takes the unloaded latency of its bank's state: no two overlap.
TEST(MemorySystem, AChaseIsAsLongAsItsLatencies) {
    const MemoryConfig config = memory_of("gddr5", {{"memory.channels", "4"}, {"dram.refresh", "none"}});
    PatternOptions options;
    options.name = "chase";
    options.requests = 3000;
    options.span = std::uint64_t{1} << 30;
    AccessPattern chase(options);
    MemoryRunOptions needs;
    needs.needs = AccessPattern::kNeeds;
    const MemoryRun run = run_memory(config, chase, needs);
    EXPECT_NEAR(run.total.read_latency.mean() * 3000, static_cast<double>(run.cycles), 1e-6 * 3000);

    options.name = "rand_read";
    AccessPattern limited(options);
    MemoryRunOptions one;
    one.outstanding = 1;
    EXPECT_EQ(run_memory(config, limited, one).cycles, run.cycles);
    AccessPattern free(options);
    EXPECT_LT(run_memory(config, free).cycles, run.cycles / 4);
}

// A trace that was recorded gives the same run.
TEST(MemorySystem, RecordedNeedsReplay) {
    for (const char* name : {"stride_rmw", "chase", "rand_mix50"}) {
        const MemoryConfig config = memory_of("hbm2", {{"memory.channels", "2"}});
        PatternOptions options;
        options.name = name;
        options.requests = 5000;
        options.span = std::uint64_t{1} << 28;
        AccessPattern source(options);
        std::vector<AddressRequest> recorded;
        MemoryRunOptions record;
        record.needs = AccessPattern::kNeeds;
        record.record = [&](const auto& block) {
            recorded.insert(recorded.end(), block.begin(), block.end());
        };
        const MemoryRun run = run_memory(config, source, record);
        for (AddressRequest& r : recorded) r.needs = 0;
        Listed list(recorded);
        const MemoryRun replay = run_memory(config, list);
        EXPECT_EQ(replay.cycles, run.cycles) << name;
        EXPECT_EQ(replay.total.label_cycles, run.total.label_cycles) << name;
        EXPECT_EQ(replay.total.read_latency.mean(), run.total.read_latency.mean()) << name;
    }
}

TEST(MemorySystem, RequestsAreSplitAtChannels) {
    const MemoryConfig config = memory_of(
        "gddr6", {{"memory.channel_bits", "6"}, {"memory.request_bytes", "100"}, {"dram.trefi", "0"}});
    MemorySystem system(config);
    system.offer(request(0x1020));  // 32 bytes of channel 0, 64 of channel 1, 4 of channel 0
    system.finish();
    EXPECT_EQ(system.statistics(0).reads, 2u);
    EXPECT_EQ(system.statistics(1).reads, 1u);
    EXPECT_EQ(system.statistics(0).total_read().useful, 36u);
    EXPECT_EQ(system.statistics(0).total_read().bus, 64u);
    EXPECT_EQ(system.statistics(1).total_read().useful, 64u);
    EXPECT_EQ(system.statistics(1).total_read().bus, 64u);
}

TEST(MemorySystem, AddressesWrapAtTheCapacity) {
    const MemoryConfig config =
        memory_of("gddr6", {{"memory.channels", "2"}, {"memory.request_bytes", "128"}});
    const std::uint64_t capacity = 2 * config.dram.capacity_bytes();
    CommandRecorder commands[2];
    for (int wrapped = 0; wrapped < 2; ++wrapped) {
        MemorySystem system(config);
        ASSERT_EQ(system.capacity(), capacity);
        system.set_trace(0, &commands[wrapped]);
        system.offer(request(wrapped == 0 ? 0x40 : 7 * capacity + 0x40));
        system.finish();
        EXPECT_EQ(system.wrapped_requests(), wrapped == 0 ? 0u : 1u);
    }
    ASSERT_EQ(commands[0].commands.size(), commands[1].commands.size());
    MemorySystem last(config);
    last.offer(request(capacity - 64));  // half of it is the memory's first bytes
    last.finish();
    EXPECT_EQ(last.statistics(0).total_read().useful, 64u);
    EXPECT_EQ(last.statistics(1).total_read().useful, 64u);
}

// Cycles need not rise: a request is offered at its own or when those before it were taken.
TEST(MemorySystem, EarlierCyclesBehindLaterOnes) {
    const MemoryConfig config = memory_of("gddr6");
    MemorySystem system(config);
    EXPECT_EQ(system.offer(request(0, false, 1000)), 1000u);
    EXPECT_EQ(system.offer(request(64, false, 10)), 1000u);
    EXPECT_EQ(system.offer(request(128, false, 1001)), 1001u);
    EXPECT_GT(system.finish(), 1001u);
}

}  // namespace
}  // namespace ropsim
