// The TLM side: exact times, back-pressure, the base protocol with other people's models, errors.
#include "memory/dram_channel.h"

#include "dram_driver.h"
#include "memory_client.h"

#include "base/random.h"

#include <functional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

MemoryRequest read(std::uint64_t address, std::uint32_t bytes = 64) {
    MemoryRequest request;
    request.address = address;
    request.bytes = bytes;
    return request;
}

MemoryRequest write(std::uint64_t address, std::uint32_t bytes = 64, bool masked = false) {
    MemoryRequest request = read(address, bytes);
    request.write = true;
    request.masked = masked;
    request.cause = MemoryCause::kWriteBack;
    return request;
}

// A wheel, a client and a channel, bound.
struct System {
    explicit System(const DramConfig& config, int in_flight = 64)
        : resolution((use_picosecond_resolution(), 0)),
          wheel("wheel"),
          client(wheel, in_flight),
          channel("channel", wheel, config) {
        client.port.socket.bind(channel.socket);
    }
    int resolution;
    EventWheel wheel;
    MemoryClient client;
    DramChannel channel;
};

TEST(DramChannel, ReadTakesExactlyItsCycles) {
    const DramConfig c = test_config("gddr6");
    System system(c);
    const Picoseconds whole = 1000 * c.tck_ps;
    // The second request comes between two clock edges: it counts from the next.
    system.client.start({{whole, read(0, 32)}, {2 * whole - 1, read(32, 32)}});
    sc_core::sc_start();
    EXPECT_EQ(system.client.done[0], whole + (c.trcd_rd + c.cl + c.burst) * c.tck_ps);
    EXPECT_EQ(system.client.done[1], 2 * whole + (c.cl + c.burst) * c.tck_ps);
    EXPECT_TRUE(system.channel.empty());
    EXPECT_EQ(sc_core::sc_time_stamp().value(), system.client.done[1]);
}

TEST(DramChannel, FullQueueHoldsTheRequestBack) {
    const DramConfig c = test_config("gddr5");
    System system(c, 256);
    std::vector<MemoryClient::Item> items;
    for (std::uint64_t i = 0; i < 2000; ++i) {
        const std::uint64_t address = (mix64(i) & 0xfffff) * 64;
        items.push_back({0, i % 3 == 0 ? write(address) : read(address)});
    }
    system.client.start(items);
    sc_core::sc_start();
    for (const Picoseconds done : system.client.done) EXPECT_NE(done, kNever);
    EXPECT_GT(system.client.freed, 0);
    EXPECT_EQ(system.client.port.in_flight(), 0);
    system.channel.finish(sc_core::sc_time_stamp().value());
    const DramStatistics& s = system.channel.statistics();
    EXPECT_GT(s.blocked_cycles, s.cycles / 2);
    EXPECT_EQ(s.reads + s.writes, 2000u);
    EXPECT_EQ(s.cycles, (sc_core::sc_time_stamp().value() + c.tck_ps - 1) / c.tck_ps);
    EXPECT_LE(static_cast<double>(s.read_queue_sum), static_cast<double>(s.cycles * c.read_queue));
}

TEST(DramChannel, ReadsAndWritesOfOneAddressNeverStick) {
    System system(test_config("gddr6"), 8);
    std::vector<MemoryClient::Item> items;
    for (std::uint64_t i = 0; i < 3000; ++i) {
        const std::uint64_t r = mix64(i);
        items.push_back(
            {0, (r & 1) != 0 ? read((r >> 8 & 3) * 32) : write((r >> 8 & 3) * 32, 64, (r >> 16 & 1) != 0)});
    }
    system.client.start(items);
    sc_core::sc_start();
    for (const Picoseconds done : system.client.done) ASSERT_NE(done, kNever);
    system.channel.finish(sc_core::sc_time_stamp().value());
}

// The pool is the limit: no more than that many requests are in flight, and the client hears of each place
// that is free again.
TEST(DramChannel, FewRequestsInFlight) {
    const DramConfig c = test_config("gddr5", {{"dram.trefi", "0"}});
    System system(c, 1);
    std::vector<MemoryClient::Item> items;
    for (std::uint64_t i = 0; i < 50; ++i) items.push_back({0, read(i * 1024 * 1024)});
    system.client.start(items);
    sc_core::sc_start();
    for (std::size_t i = 1; i < items.size(); ++i)
        EXPECT_GE(system.client.done[i] - system.client.done[i - 1], (c.cl + c.burst) * c.tck_ps);
    EXPECT_EQ(system.client.freed, 50);
}

// An initiator outside the wheel: a plain SystemC thread.
struct Outsider : sc_core::sc_module {
    SC_HAS_PROCESS(Outsider);
    Outsider(const sc_core::sc_module_name& name, std::function<void(Outsider&)> script)
        : sc_module(name), socket("socket"), script_(std::move(script)) {
        socket.register_nb_transport_bw(this, &Outsider::backward);
        SC_THREAD(run);
    }
    void run() { script_(*this); }
    tlm::tlm_sync_enum backward(tlm::tlm_generic_payload&, tlm::tlm_phase& phase, sc_core::sc_time& delay) {
        if (phase == tlm::BEGIN_RESP) {
            responses.push_back(EventWheel::moment(delay));
            response.notify(delay);
        }
        if (phase != tlm::BEGIN_RESP || !late_end) return tlm::TLM_COMPLETED;
        return tlm::TLM_ACCEPTED;  // END_RESP comes later, on the forward path
    }
    tlm_utils::simple_initiator_socket<Outsider> socket;
    sc_core::sc_event response;
    std::vector<Picoseconds> responses;
    bool late_end = false;

 private:
    std::function<void(Outsider&)> script_;
};

struct Recycler : tlm::tlm_mm_interface {
    void free(tlm::tlm_generic_payload*) override { ++freed; }
    int freed = 0;
};

void fill(tlm::tlm_generic_payload& payload, std::uint64_t address, bool is_write, unsigned int bytes) {
    payload.set_command(is_write ? tlm::TLM_WRITE_COMMAND : tlm::TLM_READ_COMMAND);
    payload.set_address(address);
    payload.set_data_length(bytes);
    payload.set_streaming_width(bytes);
    payload.set_response_status(tlm::TLM_INCOMPLETE_RESPONSE);
}

struct OutsideSystem {
    OutsideSystem(const DramConfig& config, std::function<void(Outsider&)> script)
        : resolution((use_picosecond_resolution(), 0)),
          wheel("wheel"),
          outsider("outsider", std::move(script)),
          channel("channel", wheel, config) {
        outsider.socket.bind(channel.socket);
    }
    int resolution;
    EventWheel wheel;
    Outsider outsider;
    DramChannel channel;
};

TEST(DramChannel, ServesAnInitiatorOutsideTheWheel) {
    const DramConfig c = test_config("gddr6");
    Recycler recycler;
    OutsideSystem system(c, [&](Outsider& me) {
        tlm::tlm_generic_payload payload(&recycler);
        for (const std::uint64_t ahead : {0, 5}) {  // the second request is annotated with a delay
            wait(sc_core::sc_time::from_value(100 * c.tck_ps));
            fill(payload, 64 * ahead, false, 32);
            payload.acquire();
            tlm::tlm_phase phase = tlm::BEGIN_REQ;
            sc_core::sc_time delay = sc_core::sc_time::from_value(ahead * c.tck_ps);
            const tlm::tlm_sync_enum answer = me.socket->nb_transport_fw(payload, phase, delay);
            EXPECT_EQ(answer, ahead == 0 ? tlm::TLM_UPDATED : tlm::TLM_ACCEPTED);
            wait(me.response);
            EXPECT_TRUE(payload.is_response_ok());
            EXPECT_EQ(sc_core::sc_time_stamp().value(), me.responses.back());
            payload.release();
        }
    });
    sc_core::sc_start();
    ASSERT_EQ(system.outsider.responses.size(), 2u);
    const std::uint64_t first = 100 + c.trcd_rd + c.cl + c.burst;
    EXPECT_EQ(system.outsider.responses[0], first * c.tck_ps);
    EXPECT_EQ(system.outsider.responses[1], (first + 100 + 5 + c.cl + c.burst) * c.tck_ps);
    EXPECT_EQ(recycler.freed, 2);
}

// The next response waits for the END_RESP of the one before.
TEST(DramChannel, HonoursALateEndOfResponse) {
    const DramConfig c = test_config("gddr5");
    Recycler recycler;
    const Picoseconds pause = 5000 * 667;
    OutsideSystem system(c, [&](Outsider& me) {
        me.late_end = true;
        tlm::tlm_generic_payload payloads[2] = {tlm::tlm_generic_payload(&recycler),
                                                tlm::tlm_generic_payload(&recycler)};
        for (std::uint64_t i = 0; i < 2; ++i) {
            fill(payloads[i], i * 64, false, 64);
            payloads[i].acquire();
            tlm::tlm_phase phase = tlm::BEGIN_REQ;
            sc_core::sc_time delay;
            EXPECT_EQ(me.socket->nb_transport_fw(payloads[i], phase, delay), tlm::TLM_UPDATED);
        }
        for (auto& payload : payloads) {
            wait(me.response);
            wait(sc_core::sc_time::from_value(pause));
            tlm::tlm_phase phase = tlm::END_RESP;
            sc_core::sc_time delay;
            me.socket->nb_transport_fw(payload, phase, delay);
            payload.release();
        }
    });
    sc_core::sc_start();
    ASSERT_EQ(system.outsider.responses.size(), 2u);
    EXPECT_EQ(system.outsider.responses[1] - system.outsider.responses[0], pause);
    EXPECT_TRUE(system.channel.empty());
}

TEST(DramChannel, BlockingTransportTakesLatencyAndOccupancy) {
    const DramConfig c = test_config("gddr6");
    OutsideSystem system(c, [&](Outsider& me) {
        tlm::tlm_generic_payload payload;
        sc_core::sc_time delay;
        fill(payload, 0, false, 128);  // four bursts
        me.socket->b_transport(payload, delay);
        EXPECT_TRUE(payload.is_response_ok());
        EXPECT_EQ(delay.value(), (c.trcd_rd + c.cl + 4 * c.column_interval()) * c.tck_ps);
        delay = sc_core::SC_ZERO_TIME;
        fill(payload, 4096, true, 32);  // waits for the data bus
        me.socket->b_transport(payload, delay);
        EXPECT_EQ(delay.value(), (c.trcd_wr + c.cwl + 5 * c.column_interval()) * c.tck_ps);
    });
    sc_core::sc_start();
    EXPECT_EQ(system.channel.statistics().blocking_requests, 2u);
    EXPECT_EQ(system.channel.statistics().blocking_bytes, 160u);
}

TEST(DramChannel, RefusesWhatItCannotServe) {
    const DramConfig c = test_config("gddr6");
    OutsideSystem system(c, [&](Outsider& me) {
        const auto status = [&](std::uint64_t address, unsigned int bytes, bool ignore) {
            tlm::tlm_generic_payload payload;
            fill(payload, address, false, bytes);
            if (ignore) payload.set_command(tlm::TLM_IGNORE_COMMAND);
            tlm::tlm_phase phase = tlm::BEGIN_REQ;
            sc_core::sc_time delay;
            EXPECT_EQ(me.socket->nb_transport_fw(payload, phase, delay), tlm::TLM_COMPLETED);
            return payload.get_response_status();
        };
        EXPECT_EQ(status(c.capacity_bytes(), 32, false), tlm::TLM_ADDRESS_ERROR_RESPONSE);
        EXPECT_EQ(status(c.capacity_bytes() - 16, 32, false), tlm::TLM_ADDRESS_ERROR_RESPONSE);
        EXPECT_EQ(status(0, 512, false), tlm::TLM_BURST_ERROR_RESPONSE);
        EXPECT_EQ(status(0, 32, true), tlm::TLM_COMMAND_ERROR_RESPONSE);
    });
    sc_core::sc_start();
    EXPECT_EQ(system.channel.statistics().reads, 0u);
}

}  // namespace
}  // namespace ropsim
