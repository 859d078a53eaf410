// The port and the channel under the base protocol's rules, and the checker itself on those who break them.
#include "base_protocol_checker.h"
#include "dram_driver.h"
#include "memory_client.h"

#include "base/random.h"
#include "memory/dram_channel.h"

#include <functional>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

void expect_protocol_kept(const std::string& device,
                          const std::vector<std::pair<std::string, std::string>>& keys) {
    const DramConfig config = test_config(device, keys);
    use_picosecond_resolution();
    EventWheel wheel("wheel");
    MemoryClient client(wheel, 64);
    BaseProtocolChecker checker("checker");
    DramChannel channel("channel", wheel, config);
    client.port.socket.bind(checker.target);
    checker.initiator.bind(channel.socket);
    std::vector<MemoryClient::Item> items;
    Picoseconds time = 0;
    for (std::uint64_t i = 0; i < 30000; ++i) {
        const std::uint64_t r = mix64(i + 5);
        if (r % 40 == 0) time += r >> 8 & 0xfffff;
        if (r % 3000 == 0) time += 20'000'000;
        MemoryRequest request;
        request.address =
            ((r >> 20 & 1) != 0 ? r >> 24 & 4095 : r >> 24 & (config.capacity_bytes() - 1)) & ~31ull;
        request.bytes = 32u << (r >> 16 & 1);
        request.write = (r >> 17 & 3) == 0;
        request.masked = request.write && (r >> 19 & 1) != 0;
        request.cause = request.write ? MemoryCause::kWriteBack : MemoryCause::kFill;
        request.address = std::min(request.address, config.capacity_bytes() - 64);
        items.push_back({time, request});
    }
    client.start(items);
    sc_core::sc_start();
    checker.finish();
    EXPECT_THAT(checker.violations(), testing::IsEmpty());
    EXPECT_EQ(checker.transactions(), items.size());
    EXPECT_GT(checker.refusals, 100u);
    for (const Picoseconds done : client.done) ASSERT_NE(done, kNever);
    channel.finish(sc_core::sc_time_stamp().value());
    EXPECT_EQ(channel.statistics().reads + channel.statistics().writes, items.size());
}

TEST(BaseProtocol, IsKeptOnGddr6) {
    expect_protocol_kept("gddr6", {});
}
TEST(BaseProtocol, IsKeptOnHbm2) {
    expect_protocol_kept("hbm2", {{"dram.read_queue", "16"}});
}

// Both ends of a checker in the hands of a test.
struct Puppets : sc_core::sc_module {
    struct Manager : tlm::tlm_mm_interface {
        void free(tlm::tlm_generic_payload*) override {}
    };
    using Answer =
        std::function<tlm::tlm_sync_enum(tlm::tlm_generic_payload&, tlm::tlm_phase&, sc_core::sc_time&)>;

    explicit Puppets(const sc_core::sc_module_name& name)
        : sc_module(name), checker("checker"), initiator("initiator"), target("target") {
        initiator.bind(checker.target);
        checker.initiator.bind(target);
        initiator.register_nb_transport_bw(this, &Puppets::backward);
        target.register_nb_transport_fw(this, &Puppets::forward);
        for (tlm::tlm_generic_payload& p : payload) {
            p.set_mm(&manager);
            p.set_command(tlm::TLM_READ_COMMAND);
            p.set_data_length(32);
            p.set_streaming_width(32);
            p.acquire();
        }
    }
    tlm::tlm_sync_enum forward(tlm::tlm_generic_payload& p, tlm::tlm_phase& phase, sc_core::sc_time& delay) {
        return on_forward(p, phase, delay);
    }
    tlm::tlm_sync_enum backward(tlm::tlm_generic_payload& p, tlm::tlm_phase& phase, sc_core::sc_time& delay) {
        return on_backward(p, phase, delay);
    }
    // Calls from the initiator and from the target.
    void fw(int which, tlm::tlm_phase phase, double nanoseconds = 0) {
        sc_core::sc_time delay(nanoseconds, sc_core::SC_NS);
        initiator->nb_transport_fw(payload[which], phase, delay);
    }
    void bw(int which, tlm::tlm_phase phase, double nanoseconds = 0) {
        if (phase == tlm::BEGIN_RESP && sets_status) payload[which].set_response_status(tlm::TLM_OK_RESPONSE);
        sc_core::sc_time delay(nanoseconds, sc_core::SC_NS);
        target->nb_transport_bw(payload[which], phase, delay);
    }
    void release_all() {
        for (tlm::tlm_generic_payload& p : payload) p.release();
    }

    Manager manager;
    tlm::tlm_generic_payload payload[2];
    BaseProtocolChecker checker;
    tlm_utils::simple_initiator_socket<Puppets> initiator;
    tlm_utils::simple_target_socket<Puppets> target;
    bool sets_status = true;
    Answer on_forward = [](auto&, auto&, auto&) { return tlm::TLM_ACCEPTED; };
    Answer on_backward = [](auto&, auto& phase, auto&) {
        return phase == tlm::BEGIN_RESP ? tlm::TLM_COMPLETED : tlm::TLM_ACCEPTED;
    };
};

struct Breach {
    const char* says;  // what the checker must say; empty: nothing is wrong
    std::function<void(Puppets&)> act;
};

const std::vector<Breach>& breaches() {
    using P = Puppets;
    static const std::vector<Breach> list = {
        {"", [](P& p) { p.fw(0, tlm::BEGIN_REQ), p.bw(0, tlm::END_REQ, 1), p.bw(0, tlm::BEGIN_RESP, 2); }},
        {"", [](P& p) { p.fw(0, tlm::BEGIN_REQ), p.bw(0, tlm::BEGIN_RESP, 2); }},
        {"",
         [](P& p) {
             p.on_backward = [](auto&, auto&, auto&) { return tlm::TLM_ACCEPTED; };
             p.fw(0, tlm::BEGIN_REQ), p.bw(0, tlm::END_REQ), p.fw(1, tlm::BEGIN_REQ),
                 p.bw(0, tlm::BEGIN_RESP);
             p.fw(0, tlm::END_RESP), p.bw(1, tlm::BEGIN_RESP), p.fw(1, tlm::END_RESP);
         }},
        {"BEGIN_REQ before the last END_REQ", [](P& p) { p.fw(0, tlm::BEGIN_REQ), p.fw(1, tlm::BEGIN_REQ); }},
        {"still in use",
         [](P& p) { p.fw(0, tlm::BEGIN_REQ), p.bw(0, tlm::END_REQ), p.fw(0, tlm::BEGIN_REQ); }},
        {"END_REQ out of order",
         [](P& p) { p.fw(0, tlm::BEGIN_REQ), p.bw(0, tlm::END_REQ), p.bw(0, tlm::END_REQ); }},
        {"BEGIN_RESP before the last END_RESP",
         [](P& p) {
             p.on_backward = [](auto&, auto&, auto&) { return tlm::TLM_ACCEPTED; };
             p.fw(0, tlm::BEGIN_REQ), p.bw(0, tlm::BEGIN_RESP), p.fw(1, tlm::BEGIN_REQ),
                 p.bw(1, tlm::BEGIN_RESP);
         }},
        {"END_RESP before BEGIN_RESP", [](P& p) { p.fw(0, tlm::BEGIN_REQ), p.fw(0, tlm::END_RESP); }},
        {"BEGIN_RESP out of order",
         [](P& p) {
             p.on_backward = [](auto&, auto&, auto&) { return tlm::TLM_ACCEPTED; };
             p.fw(0, tlm::BEGIN_REQ), p.bw(0, tlm::BEGIN_RESP), p.bw(0, tlm::BEGIN_RESP);
         }},
        {"END_REQ from the initiator", [](P& p) { p.fw(0, tlm::END_REQ); }},
        {"of no transaction", [](P& p) { p.bw(0, tlm::BEGIN_RESP); }},
        {"BEGIN_REQ from the target", [](P& p) { p.fw(0, tlm::BEGIN_REQ), p.bw(0, tlm::BEGIN_REQ); }},
        {"END_REQ goes back in time", [](P& p) { p.fw(0, tlm::BEGIN_REQ, 5), p.bw(0, tlm::END_REQ, 4); }},
        {"BEGIN_REQ before an earlier transaction's",
         [](P& p) { p.fw(0, tlm::BEGIN_REQ, 5), p.bw(0, tlm::BEGIN_RESP, 6), p.fw(1, tlm::BEGIN_REQ, 4); }},
        {"BEGIN_RESP before an earlier transaction's",
         [](P& p) {
             p.fw(0, tlm::BEGIN_REQ), p.bw(0, tlm::END_REQ), p.fw(1, tlm::BEGIN_REQ);
             p.bw(0, tlm::BEGIN_RESP, 6), p.bw(1, tlm::BEGIN_RESP, 5);
         }},
        {"attributes were changed",
         [](P& p) {
             p.on_forward = [](auto& payload, auto&, auto&) {
                 payload.set_address(64);
                 return tlm::TLM_ACCEPTED;
             };
             p.fw(0, tlm::BEGIN_REQ), p.bw(0, tlm::END_REQ);
         }},
        {"a response without a status",
         [](P& p) { p.sets_status = false, p.fw(0, tlm::BEGIN_REQ), p.bw(0, tlm::BEGIN_RESP); }},
        {"a response without a status",
         [](P& p) {
             p.on_forward = [](auto&, auto&, auto&) { return tlm::TLM_COMPLETED; };
             p.fw(0, tlm::BEGIN_REQ);
         }},
        {"a status before the response",
         [](P& p) { p.payload[0].set_response_status(tlm::TLM_OK_RESPONSE), p.fw(0, tlm::BEGIN_REQ); }},
        {"nobody holds the payload",
         [](P& p) { p.payload[0].release(), p.fw(0, tlm::BEGIN_REQ), p.payload[0].acquire(); }},
        {"no memory manager",
         [](P& p) {
             p.payload[0].set_mm(nullptr), p.fw(0, tlm::BEGIN_REQ), p.payload[0].set_mm(&p.manager);
         }},
        {"a length of 0", [](P& p) { p.payload[0].set_streaming_width(0), p.fw(0, tlm::BEGIN_REQ); }},
        {"only a response can be completed",
         [](P& p) {
             p.on_backward = [](auto&, auto&, auto&) { return tlm::TLM_COMPLETED; };
             p.fw(0, tlm::BEGIN_REQ), p.bw(0, tlm::END_REQ);
         }},
        {"a transaction without an end",
         [](P& p) { p.fw(0, tlm::BEGIN_REQ), p.release_all(), p.checker.finish(); }},
        {"1 references left",
         [](P& p) { p.fw(0, tlm::BEGIN_REQ), p.bw(0, tlm::BEGIN_RESP), p.checker.finish(); }},
    };
    return list;
}

TEST(BaseProtocol, BreachesAreFound) {
    use_picosecond_resolution();
    std::vector<std::unique_ptr<Puppets>> puppets;
    for (std::size_t i = 0; i < breaches().size(); ++i)
        puppets.push_back(std::make_unique<Puppets>(fmt::format("puppets_{}", i).c_str()));
    sc_core::sc_start(sc_core::SC_ZERO_TIME);
    for (std::size_t i = 0; i < breaches().size(); ++i) {
        const Breach& breach = breaches()[i];
        breach.act(*puppets[i]);
        const std::vector<std::string>& found = puppets[i]->checker.violations();
        if (*breach.says == '\0')
            EXPECT_THAT(found, testing::IsEmpty()) << i;
        else
            EXPECT_THAT(found, testing::Contains(testing::HasSubstr(breach.says))) << i;
    }
}

}  // namespace
}  // namespace ropsim
