// The port in front of other people's memories: early completion, annotated delays, kernel events, late
// acceptance.
#include "memory/tlm_memory_port.h"

#include "fixed_memory.h"
#include "memory_client.h"

#include <vector>

#include <gtest/gtest.h>
#include <tlm_utils/peq_with_get.h>
#include <tlm_utils/simple_target_socket.h>

namespace ropsim {
namespace {

// A memory with a fixed latency in one of several styles.
struct OtherMemory : sc_core::sc_module {
    enum class Style { kCompletesWithDelay, kRespondsWithDelay, kOwnEvents };
    SC_HAS_PROCESS(OtherMemory);
    OtherMemory(const sc_core::sc_module_name& name, Style memory_style)
        : sc_module(name), socket("socket"), style(memory_style), queue("queue") {
        socket.register_nb_transport_fw(this, &OtherMemory::forward);
        SC_METHOD(serve);
        sensitive << queue.get_event();
        dont_initialize();
    }
    tlm::tlm_sync_enum forward(tlm::tlm_generic_payload& payload, tlm::tlm_phase& phase,
                               sc_core::sc_time& delay) {
        if (phase == tlm::END_RESP) return tlm::TLM_COMPLETED;
        EXPECT_LT(payload.get_extension<RequestTag>()->surface, kMaxSurfaces);
        payload.get_data_ptr()[payload.get_data_length() - 1] = 1;  // a memory that stores bytes may
        payload.set_response_status(tlm::TLM_OK_RESPONSE);
        if (style == Style::kOwnEvents) {
            payload.acquire();
            queue.notify(payload, delay + latency);
            return tlm::TLM_ACCEPTED;  // the response implies END_REQ
        }
        delay += latency;
        if (style == Style::kCompletesWithDelay) return tlm::TLM_COMPLETED;
        phase = tlm::BEGIN_RESP;
        return tlm::TLM_UPDATED;
    }
    void serve() {
        while (tlm::tlm_generic_payload* payload = queue.get_next_transaction()) {
            tlm::tlm_phase phase = tlm::BEGIN_RESP;
            sc_core::sc_time delay;
            EXPECT_EQ(socket->nb_transport_bw(*payload, phase, delay), tlm::TLM_COMPLETED);
            payload->release();
        }
    }
    tlm_utils::simple_target_socket<OtherMemory> socket;
    const sc_core::sc_time latency = sc_core::sc_time::from_value(12345);
    Style style;
    tlm_utils::peq_with_get<tlm::tlm_generic_payload> queue;
};

void check_exact_latency(OtherMemory::Style style, bool one_at_a_time) {
    use_picosecond_resolution();
    EventWheel wheel("wheel");
    MemoryClient client(wheel, 4);
    OtherMemory memory("memory", style);
    client.port.socket.bind(memory.socket);
    std::vector<MemoryClient::Item> items;
    for (std::uint64_t i = 0; i < 40; ++i) {
        MemoryRequest request;
        request.address = i * 64;
        request.bytes = 64;
        request.write = i % 4 == 3;
        items.push_back({i * (one_at_a_time ? 20000 : 4000) + 7, request});
    }
    client.start(items);
    sc_core::sc_start();
    for (std::size_t i = 0; i < items.size(); ++i) {
        const Picoseconds issued = items[i].time;
        if (style == OtherMemory::Style::kOwnEvents && !one_at_a_time)
            EXPECT_GE(client.done[i], issued + 12345);
        else
            EXPECT_EQ(client.done[i], issued + 12345) << i;
    }
    EXPECT_EQ(client.port.in_flight(), 0);
}

TEST(TlmMemoryPort, TargetCompletesEarlyWithADelay) {
    check_exact_latency(OtherMemory::Style::kCompletesWithDelay, false);
}
TEST(TlmMemoryPort, TargetRespondsEarlyWithADelay) {
    check_exact_latency(OtherMemory::Style::kRespondsWithDelay, false);
}
TEST(TlmMemoryPort, TargetUsesKernelEvents) {
    check_exact_latency(OtherMemory::Style::kOwnEvents, true);
}
TEST(TlmMemoryPort, TargetHoldsRequestsBack) {
    check_exact_latency(OtherMemory::Style::kOwnEvents, false);
}

// Like a cache, it asks for no step when a request is done: only a place in flight wakes it.
struct SleepingClient : MemoryClient {
    SleepingClient(EventWheel& w, int in_flight) : MemoryClient(w, in_flight), clock(w) {}
    void memory_done(std::uint32_t id, bool) override { done[id] = clock.now(); }
    EventWheel& clock;
};

TEST(TlmMemoryPort, APlaceInFlightWakesTheClient) {
    use_picosecond_resolution();
    EventWheel wheel("wheel");
    SleepingClient client(wheel, 2);
    FixedMemory memory("memory", sc_core::sc_time::from_value(1000), sc_core::SC_ZERO_TIME, 8);
    client.port.socket.bind(memory.socket);
    MemoryRequest request;
    request.bytes = 64;
    client.start(std::vector<MemoryClient::Item>(6, {0, request}));
    sc_core::sc_start();
    // Two at a time, without a pause between.
    EXPECT_EQ(client.done, (std::vector<Picoseconds>{1000, 1000, 2000, 2000, 3000, 3000}));
    EXPECT_EQ(client.port.in_flight(), 0);
}

}  // namespace
}  // namespace ropsim
