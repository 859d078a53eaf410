// A port that is linked to its channel sees what one that speaks in phases sees, at the same times.
#include "dram_driver.h"
#include "memory_client.h"

#include "base/random.h"
#include "memory/dram_channel.h"
#include "memory/simulate.h"

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

// Two clients of one channel, each linked or not.
struct Pair {
    Pair(EventWheel& wheel, const DramConfig& config, const std::string& name, bool first_linked,
         bool second_linked)
        : first(wheel, 24, (name + "_first").c_str()),
          second(wheel, 24, (name + "_second").c_str()),
          channel((name + "_channel").c_str(), wheel, config) {
        connect(first.port, first_linked);
        connect(second.port, second_linked);
    }
    void connect(TlmMemoryPort& port, bool linked) {
        if (linked)
            port.bind(channel);
        else
            port.socket.bind(channel.socket);
    }
    MemoryClient first, second;
    DramChannel channel;
};

// More than the queues hold, so that requests of both are held back, with pauses in which they drain.
std::vector<MemoryClient::Item> requests(std::uint64_t stream) {
    std::vector<MemoryClient::Item> items;
    Picoseconds time = 0;
    for (std::uint64_t i = 0; i < 4000; ++i) {
        const auto draw = [&](std::uint32_t which) { return random_bits(stream << 32 | i, which); };
        time += draw(0) % 40 == 0 ? 400'000 : draw(1) % 3 * 700;
        MemoryRequest request;
        request.address = std::uint64_t{32} * (draw(2) % 4096);
        request.bytes = 32 * (1 + draw(3) % 4);
        request.write = draw(4) % 5 < 2;
        request.masked = request.write && draw(5) % 2 == 0;
        request.surface = static_cast<std::uint8_t>(draw(6) % 3);
        items.push_back({time, request});
    }
    return items;
}

TEST(MemoryLink, SaysWhatThePhasesSayAtTheSameTimes) {
    use_picosecond_resolution();
    EventWheel wheel("wheel");
    const DramConfig config = test_config("gddr6");
    std::vector<std::unique_ptr<Pair>> pairs;
    pairs.push_back(std::make_unique<Pair>(wheel, config, "phases", false, false));
    pairs.push_back(std::make_unique<Pair>(wheel, config, "linked", true, true));
    pairs.push_back(std::make_unique<Pair>(wheel, config, "mixed", false, true));
    for (const auto& pair : pairs) {
        pair->first.start(requests(1));
        pair->second.start(requests(2));
    }
    simulate();
    const Pair& phases = *pairs.front();
    EXPECT_GT(phases.first.refusals, 100);
    for (const auto& pair : pairs) {
        pair->channel.finish(wheel.now());
        EXPECT_EQ(pair->first.done, phases.first.done);
        EXPECT_EQ(pair->second.done, phases.second.done);
        EXPECT_EQ(pair->first.refusals, phases.first.refusals);
        EXPECT_EQ(pair->first.freed, phases.first.freed);
        EXPECT_EQ(pair->first.port.in_flight(), 0);
        const DramStatistics& s = pair->channel.statistics();
        const DramStatistics& expected = phases.channel.statistics();
        EXPECT_EQ(s.label_cycles, expected.label_cycles);
        EXPECT_EQ(s.blocked_cycles, expected.blocked_cycles);
        EXPECT_EQ(s.forwarded_reads, expected.forwarded_reads);
        EXPECT_EQ(s.total_write().useful, expected.total_write().useful);
    }
    EXPECT_GT(phases.channel.statistics().blocked_cycles, 1000u);
    EXPECT_GT(phases.channel.statistics().forwarded_reads, 0u);
}

}  // namespace
}  // namespace ropsim
