// Several initiators on one socket of a channel and of a slice: base protocol, order, whose response it is.
#include "base_protocol_checker.h"
#include "dram_driver.h"
#include "memory_client.h"

#include "base/random.h"
#include "memory/dram_channel.h"
#include "memory/l2_slice.h"

#include <functional>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr std::size_t kInitiators = 3;
constexpr Picoseconds kPeriod = 1000;

// Each initiator asks for its own surface; a third of all are writes.
std::vector<MemoryClient::Item> requests_of(std::size_t initiator, std::uint64_t count) {
    std::vector<MemoryClient::Item> items;
    Picoseconds time = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
        const std::uint64_t r = mix64(i * kInitiators + initiator);
        if (r % 50 == 0) time += r >> 8 & 0x3ffff;
        MemoryRequest request;
        request.address = ((r >> 20 & 1) != 0 ? r >> 24 & 4095 : r >> 24 & 0x3ffffff) & ~31ull;
        request.bytes = 32u << (r >> 16 & 1);
        request.write = r % 3 == 0;
        request.surface = static_cast<std::uint8_t>(initiator);
        request.cause = request.write ? MemoryCause::kWriteBack : MemoryCause::kFill;
        items.push_back({time, request});
    }
    return items;
}

// Clients, each behind a checker of its own.
struct Clients {
    explicit Clients(EventWheel& wheel) {
        for (std::size_t i = 0; i < kInitiators; ++i) {
            clients.push_back(std::make_unique<MemoryClient>(wheel, 48, fmt::format("port_{}", i).c_str()));
            checkers.push_back(std::make_unique<BaseProtocolChecker>(fmt::format("checker_{}", i).c_str()));
            clients[i]->port.socket.bind(checkers[i]->target);
        }
    }
    // Returns the bytes asked for, by initiator: reads, writes.
    std::vector<std::array<std::uint64_t, 2>> start(std::uint64_t count) {
        std::vector<std::array<std::uint64_t, 2>> bytes(kInitiators);
        for (std::size_t i = 0; i < kInitiators; ++i) {
            const std::vector<MemoryClient::Item> items = requests_of(i, count);
            for (const MemoryClient::Item& item : items)
                bytes[i][item.request.write ? 1 : 0] += item.request.bytes;
            clients[i]->start(items);
        }
        return bytes;
    }
    void expect_all_done(std::uint64_t count) {
        for (std::size_t i = 0; i < kInitiators; ++i) {
            checkers[i]->finish();
            EXPECT_THAT(checkers[i]->violations(), testing::IsEmpty()) << i;
            EXPECT_EQ(checkers[i]->transactions(), count) << i;
            EXPECT_GT(checkers[i]->refusals, 100u) << i;
            for (const Picoseconds done : clients[i]->done) ASSERT_NE(done, kNever);
        }
    }
    std::vector<std::unique_ptr<MemoryClient>> clients;
    std::vector<std::unique_ptr<BaseProtocolChecker>> checkers;
};

TEST(Initiators, ThreeShareAChannel) {
    const DramConfig config = test_config("gddr6");
    use_picosecond_resolution();
    EventWheel wheel("wheel");
    Clients clients(wheel);
    DramChannel channel("channel", wheel, config);
    for (auto& checker : clients.checkers) checker->initiator.bind(channel.socket);
    const auto bytes = clients.start(10000);
    sc_core::sc_start();
    clients.expect_all_done(10000);
    EXPECT_TRUE(channel.empty());
    channel.finish(sc_core::sc_time_stamp().value());
    const DramStatistics& s = channel.statistics();
    EXPECT_LE(s.blocked_cycles, s.cycles);
    for (std::size_t i = 0; i < kInitiators; ++i) {
        EXPECT_EQ(s.read[i][static_cast<std::size_t>(MemoryCause::kFill)].useful, bytes[i][0]);
        EXPECT_EQ(s.write[i][static_cast<std::size_t>(MemoryCause::kWriteBack)].useful, bytes[i][1]);
    }
}

TEST(Initiators, ThreeShareASlice) {
    use_picosecond_resolution();
    L2Config config;
    config.cache = {8192, 4, 128, 32, {}};
    config.latency = 20;
    config.input_queue = 4;
    EventWheel wheel("wheel");
    Clients clients(wheel);
    L2Slice slice("slice", wheel, config, kPeriod);
    DramChannel channel("channel", wheel, test_config("gddr6"));
    for (auto& checker : clients.checkers) checker->initiator.bind(slice.socket);
    slice.port.socket.bind(channel.socket);
    const auto bytes = clients.start(10000);
    sc_core::sc_start();
    slice.end_of_frame();
    sc_core::sc_start();
    clients.expect_all_done(10000);
    EXPECT_TRUE(slice.drained());
    slice.finish(slice.last_cycle());
    channel.finish(sc_core::sc_time_stamp().value());
    for (std::size_t i = 0; i < kInitiators; ++i) {
        const auto& asked = slice.statistics().looked_up[i];
        EXPECT_EQ(asked[static_cast<std::size_t>(MemoryCause::kFill)].read, bytes[i][0]);
        EXPECT_EQ(asked[static_cast<std::size_t>(MemoryCause::kWriteBack)].write, bytes[i][1]);
    }
}

// An initiator that sends what a test tells it and writes down what comes back.
struct Scripted : sc_core::sc_module {
    struct Manager : tlm::tlm_mm_interface {
        void free(tlm::tlm_generic_payload*) override {}
    };
    struct Seen {
        int payload;
        Picoseconds time;
        bool operator==(const Seen&) const = default;
    };

    explicit Scripted(const sc_core::sc_module_name& name) : sc_module(name), socket("socket") {
        socket.register_nb_transport_bw(this, &Scripted::backward);
        for (tlm::tlm_generic_payload& p : payloads) p.set_mm(&manager);
    }
    tlm::tlm_sync_enum send(int which, std::uint64_t address, bool write, Picoseconds ahead = 0) {
        tlm::tlm_generic_payload& p = payloads[which];
        p.acquire();
        p.set_command(write ? tlm::TLM_WRITE_COMMAND : tlm::TLM_READ_COMMAND);
        p.set_address(address);
        p.set_data_length(32);
        p.set_streaming_width(32);
        p.set_response_status(tlm::TLM_INCOMPLETE_RESPONSE);
        tlm::tlm_phase phase = tlm::BEGIN_REQ;
        sc_core::sc_time delay = sc_core::sc_time::from_value(ahead);
        return socket->nb_transport_fw(p, phase, delay);
    }
    void end_response(int which) {
        tlm::tlm_phase phase = tlm::END_RESP;
        sc_core::sc_time delay;
        socket->nb_transport_fw(payloads[which], phase, delay);
    }
    tlm::tlm_sync_enum backward(tlm::tlm_generic_payload& payload, tlm::tlm_phase& phase,
                                sc_core::sc_time& delay) {
        const auto which = static_cast<int>(&payload - payloads);
        (phase == tlm::BEGIN_RESP ? responses : accepted).push_back({which, EventWheel::moment(delay)});
        if (phase == tlm::END_REQ && answer) answer(delay.value());
        if (phase != tlm::BEGIN_RESP || !late_end) return tlm::TLM_COMPLETED;
        return tlm::TLM_ACCEPTED;
    }
    tlm_utils::simple_initiator_socket<Scripted> socket;
    Manager manager;
    tlm::tlm_generic_payload payloads[8];
    bool late_end = false;
    std::function<void(Picoseconds)>
        answer;  // what it does from inside END_REQ, so long after the kernel's time
    std::vector<Seen> accepted, responses;
};

struct ScriptedPair : sc_core::sc_module {
    SC_HAS_PROCESS(ScriptedPair);
    ScriptedPair(const DramConfig& config, std::function<void(Scripted&, Scripted&)> act)
        : sc_module(sc_core::sc_module_name((use_picosecond_resolution(), "pair"))),
          wheel("wheel"),
          a("a"),
          b("b"),
          channel("channel", wheel, config),
          script(std::move(act)) {
        a.socket.bind(channel.socket);
        b.socket.bind(channel.socket);
        SC_THREAD(run);
    }
    void run() { script(a, b); }
    EventWheel wheel;
    Scripted a, b;
    DramChannel channel;
    std::function<void(Scripted&, Scripted&)> script;
};

// One that sends its next request from inside END_REQ, with two places in the queue: each is let in when the
// one before the last leaves, with its column command.
TEST(Initiators, RequestsFromInsideEndReqWaitTheirTurn) {
    const DramConfig c = test_config("gddr6", {{"dram.read_queue", "2"}});
    ScriptedPair pair(c, [](Scripted& a, Scripted&) {
        EXPECT_EQ(a.send(0, 0, false), tlm::TLM_UPDATED);
        EXPECT_EQ(a.send(1, 1 << 20, false), tlm::TLM_UPDATED);
        EXPECT_EQ(a.send(2, 2 << 20, false), tlm::TLM_ACCEPTED);
    });
    int next = 3;
    pair.a.answer = [&](Picoseconds ahead) {
        if (next == 8) return;
        EXPECT_EQ(pair.a.send(next, std::uint64_t(next) << 20, false, ahead), tlm::TLM_ACCEPTED);
        ++next;
    };
    sc_core::sc_start();
    ASSERT_EQ(pair.a.responses.size(), 8u);
    ASSERT_EQ(pair.a.accepted.size(), 6u);
    for (std::size_t i = 0; i < 6; ++i)
        EXPECT_EQ(pair.a.accepted[i].time + (c.cl + c.burst + c.back_cycles) * c.tck_ps,
                  pair.a.responses[i].time)
            << i;
}

// The reads of a full queue: whoever came first goes first, and a request for later lets earlier ones by.
TEST(Initiators, HeldRequestsGoInOrderOfTime) {
    const DramConfig c = test_config("gddr6", {{"dram.read_queue", "2"}});
    ScriptedPair pair(c, [](Scripted& a, Scripted& b) {
        EXPECT_EQ(a.send(0, 0, false), tlm::TLM_UPDATED);
        EXPECT_EQ(a.send(1, 1 << 20, false), tlm::TLM_UPDATED);
        EXPECT_EQ(b.send(0, 2 << 20, false, 3000), tlm::TLM_ACCEPTED);
        wait(sc_core::sc_time(1.0, sc_core::SC_NS));
        EXPECT_EQ(a.send(2, 3 << 20, false), tlm::TLM_ACCEPTED);
        wait(sc_core::sc_time(5.0, sc_core::SC_NS));
    });
    sc_core::sc_start();
    ASSERT_EQ(pair.a.responses.size(), 3u);
    ASSERT_EQ(pair.b.responses.size(), 1u);
    ASSERT_EQ(pair.a.accepted.size(), 1u);
    ASSERT_EQ(pair.b.accepted.size(), 1u);
    EXPECT_LT(pair.a.accepted[0].time, pair.b.accepted[0].time);
    EXPECT_LT(pair.a.responses[2].time, pair.b.responses[0].time);
    EXPECT_TRUE(pair.channel.empty());
}

// The one that withholds END_RESP waits for its own next response; the other's come when they come alone.
TEST(Initiators, ALateEndOfResponseDelaysNobodyElse) {
    const DramConfig c = test_config("gddr6");
    const Picoseconds pause = 10'000'000;
    ScriptedPair pair(c, [](Scripted& a, Scripted& b) {
        a.late_end = true;
        a.send(0, 0, false);
        b.send(0, 32, false);
        a.send(1, 64, false);
        b.send(1, 96, false);
        wait(sc_core::sc_time::from_value(pause));
        a.end_response(0);
        wait(sc_core::sc_time::from_value(pause));
        a.end_response(1);
    });
    sc_core::sc_start();
    ASSERT_EQ(pair.a.responses.size(), 2u);
    ASSERT_EQ(pair.b.responses.size(), 2u);
    const Picoseconds first = (c.trcd_rd + c.cl + c.burst) * c.tck_ps;
    EXPECT_EQ(pair.a.responses[0], (Scripted::Seen{0, first}));
    EXPECT_EQ(pair.b.responses[0], (Scripted::Seen{0, first + c.tccd_l * c.tck_ps}));
    EXPECT_EQ(pair.b.responses[1], (Scripted::Seen{1, first + 3 * c.tccd_l * c.tck_ps}));
    EXPECT_EQ(pair.a.responses[1], (Scripted::Seen{1, pause}));
    EXPECT_TRUE(pair.channel.empty());
}

}  // namespace
}  // namespace ropsim
