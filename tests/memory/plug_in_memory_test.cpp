// Other memories behind the port: the examples of docs/plug-in-memory.md, and the channel's own blocking
// transport.
#include "base_protocol_checker.h"
#include "dram_driver.h"
#include "fixed_memory.h"
#include "memory_client.h"
#include "ticked_memory.h"

#include "memory/address_map.h"
#include "memory/dram_channel.h"

#include <algorithm>
#include <functional>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

MemoryClient::Item item(Picoseconds time, std::uint64_t address, std::uint32_t bytes, bool write = false) {
    MemoryRequest request;
    request.address = address;
    request.bytes = bytes;
    request.write = write;
    return {time, request};
}

struct Plugged {
    Plugged()
        : resolution((use_picosecond_resolution(), 0)),
          wheel("wheel"),
          client(wheel, 32),
          checker("checker") {
        client.port.socket.bind(checker.target);
    }
    void run(std::vector<MemoryClient::Item> items) {
        client.start(std::move(items));
        sc_core::sc_start();
        checker.finish();
        EXPECT_THAT(checker.violations(), testing::IsEmpty());
        for (const Picoseconds done : client.done) EXPECT_NE(done, kNever);
    }
    int resolution;
    EventWheel wheel;
    MemoryClient client;
    BaseProtocolChecker checker;
};

TEST(PlugInMemory, FixedLatencyAndBandwidth) {
    Plugged p;
    // 100 ns, 1 byte in 10 ps, at most 8 in flight
    FixedMemory memory("memory", sc_core::sc_time(100, sc_core::SC_NS), sc_core::sc_time(10, sc_core::SC_PS),
                       8);
    p.checker.initiator.bind(memory.socket);
    std::vector<MemoryClient::Item> items = {item(7, 0, 64), item(8, 64, 128), item(400'000, 0, 32, true)};
    for (std::uint64_t i = 0; i < 800; ++i) items.push_back(item(1'000'000, i * 64, 64, i % 4 == 0));
    p.run(items);
    EXPECT_EQ(p.client.done[0], 7u + 640 + 100'000);
    EXPECT_EQ(p.client.done[1], 7u + 640 + 1280 + 100'000);
    EXPECT_EQ(p.client.done[2], 400'000u + 320 + 100'000);
    // Little's law: eight in flight for their 100 ns and their own 640 ps each.
    const Picoseconds last = *std::max_element(p.client.done.begin(), p.client.done.end());
    EXPECT_NEAR(static_cast<double>(last - 1'000'000), 800 / 8 * (100'000 + 8 * 640.0), 0.06 * 100 * 100'000);
    EXPECT_GT(p.checker.refusals, 700u);
}

// What a simulator's library looks like from outside: eight blocks at most, one a cycle, a fixed number of
// cycles.
struct TickingSimulator {
    static constexpr std::uint64_t kLatency = 20;
    bool will_accept(std::uint64_t, bool) const { return queue.size() < 8 && added_at != cycle + 1; }
    void add(std::uint64_t address, bool write) {
        added_at = cycle + 1;
        if (!write) queue.push_back({address, cycle + kLatency});
    }
    void tick() {
        ++cycle;
        while (!queue.empty() && queue.front().second <= cycle) {
            const std::uint64_t address = queue.front().first;
            queue.pop_front();
            on_read(address);
        }
    }
    std::function<void(std::uint64_t)> on_read;
    std::deque<std::pair<std::uint64_t, std::uint64_t>> queue;
    std::uint64_t cycle = 0, added_at = 0;
};

TEST(PlugInMemory, TickedSimulator) {
    Plugged p;
    TickingSimulator simulator;
    TickedMemory<TickingSimulator> memory("memory", simulator, sc_core::sc_time(1, sc_core::SC_NS), 64);
    p.checker.initiator.bind(memory.socket);
    std::vector<MemoryClient::Item> items = {item(1500, 0, 32), item(100'000, 128, 256),
                                             item(200'000, 32, 64, true)};
    // the same blocks again and again: answers go to their requests in order
    for (std::uint64_t i = 0; i < 500; ++i) items.push_back(item(300'000, i % 3 * 64, 64, i % 5 == 0));
    p.run(items);
    EXPECT_EQ(p.client.done[0], 22'000u);             // taken at the edge at 2 ns
    EXPECT_EQ(p.client.done[1], 100'000u + 23'000u);  // four blocks, one a cycle
    EXPECT_EQ(p.client.done[2], 201'000u);            // the second of two blocks is taken a cycle later
    EXPECT_TRUE(simulator.queue.empty());
    EXPECT_GT(p.checker.refusals, 0u);
    EXPECT_EQ(p.client.port.in_flight(), 0);
}

// A plain SystemC process that reads the same bytes both ways.
struct Reader : sc_core::sc_module {
    SC_HAS_PROCESS(Reader);
    struct Pair {
        std::uint64_t address;
        unsigned bytes;
        Picoseconds blocking = 0, nonblocking = 0;
    };
    struct Manager : tlm::tlm_mm_interface {
        void free(tlm::tlm_generic_payload*) override {}
    };
    Reader(const sc_core::sc_module_name& name, std::vector<Pair> list)
        : sc_module(name), socket("socket"), pairs(std::move(list)) {
        socket.register_nb_transport_bw(this, &Reader::backward);
        SC_THREAD(run);
    }
    tlm::tlm_sync_enum backward(tlm::tlm_generic_payload&, tlm::tlm_phase& phase, sc_core::sc_time& delay) {
        if (phase != tlm::BEGIN_RESP) return tlm::TLM_ACCEPTED;
        arrival = EventWheel::moment(delay);
        arrived.notify(delay);
        return tlm::TLM_COMPLETED;
    }
    void run() {
        for (Pair& pair : pairs) {
            tlm::tlm_generic_payload payload(&manager);
            payload.acquire();
            payload.set_command(tlm::TLM_READ_COMMAND);
            payload.set_address(pair.address);
            payload.set_data_length(pair.bytes);
            payload.set_streaming_width(pair.bytes);
            sc_core::sc_time delay;
            socket->b_transport(payload, delay);
            pair.blocking = delay.value();
            payload.set_response_status(tlm::TLM_INCOMPLETE_RESPONSE);
            tlm::tlm_phase phase = tlm::BEGIN_REQ;
            delay = sc_core::SC_ZERO_TIME;
            const Picoseconds start = sc_core::sc_time_stamp().value();
            socket->nb_transport_fw(payload, phase, delay);
            wait(arrived);
            pair.nonblocking = arrival - start;
            wait(sc_core::sc_time(1, sc_core::SC_US));
        }
    }
    tlm_utils::simple_initiator_socket<Reader> socket;
    std::vector<Pair> pairs;
    Manager manager;
    Picoseconds arrival = 0;
    sc_core::sc_event arrived;
};

// The lowest address of a bank.
std::uint64_t address_of_bank(const AddressMap& map, std::uint32_t bank) {
    std::uint64_t address = 0;
    while (map.place(address).bank != bank) address += map.contiguous_bytes();
    return address;
}

// Isolated reads of closed rows: one burst takes the same time both ways; several of one row, too, up to the
// gaps that a bank group needs between them, which b_transport leaves out.
TEST(BlockingTransport, AgreesWithNonBlockingWhenAlone) {
    use_picosecond_resolution();
    EventWheel wheel("wheel");
    std::vector<std::unique_ptr<Reader>> readers;
    std::vector<std::unique_ptr<DramChannel>> channels;
    for (const std::string& device : dram_device_names()) {
        const DramConfig config = test_config(device, {{"dram.refresh", "none"}});
        const AddressMap map(config, "test");
        const auto burst = config.burst_bytes();
        const auto most =
            static_cast<unsigned>(std::min<std::uint64_t>(kMaxRequestBytes, map.contiguous_bytes()));
        std::vector<Reader::Pair> pairs = {{address_of_bank(map, 0), burst},
                                           {address_of_bank(map, 1) + burst / 2, burst / 2},
                                           {address_of_bank(map, 2), most}};
        readers.push_back(std::make_unique<Reader>((device + "_reader").c_str(), pairs));
        channels.push_back(std::make_unique<DramChannel>((device + "_channel").c_str(), wheel, config));
        readers.back()->socket.bind(channels.back()->socket);
    }
    sc_core::sc_start();
    for (std::size_t i = 0; i < readers.size(); ++i) {
        const DramConfig& config = channels[i]->config();
        const Picoseconds tck = config.tck_ps;
        for (const Reader::Pair& pair : readers[i]->pairs) {
            const Picoseconds gaps =
                pair.bytes <= config.burst_bytes() ? 0 : pair.bytes / config.burst_bytes() - 1;
            const Picoseconds per_gap =
                (std::max(config.tccd_l, config.burst) - config.column_interval()) * tck;
            // a blocking request starts when it comes, a queued one at the next clock edge
            const Picoseconds least = pair.blocking + gaps * per_gap;
            EXPECT_GE(pair.nonblocking, least) << config.device << " " << pair.bytes;
            EXPECT_LT(pair.nonblocking, least + tck) << config.device << " " << pair.bytes;
        }
    }
}

}  // namespace
}  // namespace ropsim
