// The L2 slice between an initiator and DRAM: times in closed form, bytes against a map of every byte, timed
// and untimed.
#include "memory/l2_slice.h"

#include "memory_client.h"

#include "base/random.h"
#include "memory/dram_channel.h"
#include "memory/untimed_l2.h"

#include <map>
#include <set>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr Picoseconds kPeriod = 1000;

L2Config small_slice() {
    L2Config c;
    c.cache = {4096, 4, 128, 32, {}};
    c.latency = 10;
    c.bytes_per_cycle = 32;
    return c;
}

DramConfig memory() {
    Parameters none;
    return dram_config(none);
}

MemoryRequest at(std::uint64_t address, std::uint32_t bytes, bool write, const LineMask* enables = nullptr) {
    MemoryRequest r;
    r.address = address;
    r.bytes = bytes;
    r.write = write;
    r.masked = enables != nullptr;
    r.enables = enables;
    r.surface = 5;
    r.cause = write ? MemoryCause::kWriteBack : MemoryCause::kFill;
    return r;
}

struct Bench {
    explicit Bench(const L2Config& config, int in_flight = 64)
        : client(wheel, in_flight), slice("slice", wheel, config, kPeriod), dram("dram", wheel, memory()) {
        client.port.socket.bind(slice.socket);
        slice.port.socket.bind(dram.socket);
    }
    EventWheel wheel{"wheel"};
    MemoryClient client;
    L2Slice slice;
    DramChannel dram;
};

std::uint64_t up(std::uint64_t value, std::uint64_t unit) {
    return (value + unit - 1) / unit;
}

TEST(L2Slice, AMissCostsMemoryMoreThanAHitAndDataTheirCycles) {
    use_picosecond_resolution();
    const L2Config c = small_slice();
    const DramConfig d = memory();
    Bench bench(c);
    // A miss of two sectors; the same again; then one that crosses into the next line, of which all is new.
    bench.client.start({{0, at(0, 64, false)}, {500000, at(0, 64, false)}, {600000, at(96, 64, false)}});
    sc_core::sc_start();
    const std::uint64_t data = (d.trcd_rd + d.cl + d.tccd_l + d.burst) * d.tck_ps;
    EXPECT_EQ(bench.client.done[0], (up(data, kPeriod) + c.latency + 2) * kPeriod);
    EXPECT_EQ(bench.client.done[1], 500000 + (c.latency + 2) * kPeriod);
    EXPECT_GT(bench.client.done[2], 600000 + (c.latency + 2) * kPeriod);
    EXPECT_EQ(bench.slice.statistics().memory[5][0].read, 64u + 32u + 32u);
}

TEST(L2Slice, DataPortBoundsHits) {
    use_picosecond_resolution();
    L2Config c = small_slice();
    c.bytes_per_cycle = 16;
    Bench bench(c);
    std::vector<MemoryClient::Item> items = {{0, at(0, 128, false)}};
    for (std::uint64_t i = 0; i < 40; ++i) items.push_back({1000000, at(0, 128, false)});
    bench.client.start(items);
    sc_core::sc_start();
    // One after the other: 8 cycles each behind the latency of the first.
    for (std::uint64_t i = 0; i < 40; ++i)
        EXPECT_EQ(bench.client.done[i + 1], 1000000 + (c.latency + 8 * (i + 1)) * kPeriod) << i;
}

TEST(L2Slice, WritesTakeTheirDataCyclesAndAreHeldBackWhenTheQueueIsFull) {
    use_picosecond_resolution();
    L2Config c = small_slice();
    c.input_queue = 2;
    c.bytes_per_cycle = 8;
    Bench bench(c);
    std::vector<MemoryClient::Item> items;
    for (std::uint64_t i = 0; i < 5; ++i) items.push_back({0, at(i * 128, 128, true)});
    bench.client.start(items);
    sc_core::sc_start();
    // Two are queued at once; the others when one leaves the queue: at its look-up, 16 cycles apart.
    const std::vector<Picoseconds> expected = {0, 0, 0, 16 * kPeriod, 32 * kPeriod};
    EXPECT_EQ(bench.client.done, expected);
    EXPECT_EQ(bench.slice.statistics().memory[5][1].read + bench.slice.statistics().memory[5][1].write, 0u);
    bench.slice.end_of_frame();
    sc_core::sc_start();
    EXPECT_EQ(bench.slice.statistics().memory[5][static_cast<int>(MemoryCause::kFlush)].write, 5u * 128u);
    EXPECT_TRUE(bench.slice.drained());
    bench.slice.finish(bench.slice.last_cycle());
}

TEST(L2Slice, RefusesWhatItCannotKeepAndTakesByteEnables) {
    use_picosecond_resolution();
    Bench bench(small_slice());
    sc_core::sc_start(sc_core::SC_ZERO_TIME);  // the sockets know one another from here on
    RequestTag tag;
    tag.surface = 1;
    tag.masked = true;
    tlm::tlm_generic_payload payload;
    payload.set_extension(&tag);
    payload.set_write();
    payload.set_address(0);
    payload.set_data_length(32);
    payload.set_streaming_width(32);
    tlm::tlm_phase phase = tlm::BEGIN_REQ;
    sc_core::sc_time delay;
    const auto send = [&] {
        payload.set_response_status(tlm::TLM_INCOMPLETE_RESPONSE);
        phase = tlm::BEGIN_REQ;
        EXPECT_EQ(bench.client.port.socket->nb_transport_fw(payload, phase, delay), tlm::TLM_COMPLETED);
        return payload.get_response_status();
    };
    EXPECT_EQ(send(), tlm::TLM_BYTE_ENABLE_ERROR_RESPONSE);
    unsigned char enables[2] = {0xff, 0};
    payload.set_byte_enable_ptr(enables);
    payload.set_byte_enable_length(2);
    EXPECT_EQ(send(), tlm::TLM_OK_RESPONSE);
    payload.set_data_length(0);
    EXPECT_EQ(send(), tlm::TLM_BURST_ERROR_RESPONSE);
    payload.set_data_length(32);
    payload.set_command(tlm::TLM_IGNORE_COMMAND);
    EXPECT_EQ(send(), tlm::TLM_COMMAND_ERROR_RESPONSE);
    sc_core::sc_start();
    bench.slice.end_of_frame();
    sc_core::sc_start();
    bench.slice.finish(bench.slice.last_cycle());
    EXPECT_EQ(bench.slice.statistics().cache.bytes_written_back, 16u);
    payload.clear_extension(&tag);
}

// The slice as maps: for each byte whether it is known and whether it is dirty.
class BytewiseSlice {
 public:
    explicit BytewiseSlice(const L2Config& config) : c_(config.cache) {}
    std::uint64_t read_from_memory = 0, written_bytes = 0;

    void access(const MemoryRequest& r) {
        std::set<std::uint64_t> lines;
        for (std::uint64_t a = r.address; a < r.address + r.bytes; ++a) lines.insert(a / c_.line_bytes);
        for (const std::uint64_t line : lines) {
            use(line);
            for (std::uint64_t a = line * c_.line_bytes; a < (line + 1) * c_.line_bytes; ++a) {
                if (a < r.address || a >= r.address + r.bytes) continue;
                const std::uint64_t b = a - r.address;
                if (r.write && (!r.masked || (r.enables->word[b / 64] >> (b % 64) & 1) != 0)) {
                    dirty_.insert(a);
                    known_.insert(a);
                }
                if (!r.write) need(a / c_.sector_bytes);
            }
        }
    }
    void flush() {
        written_bytes += dirty_.size();
        dirty_.clear();
    }

 private:
    void need(std::uint64_t sector) {
        bool all = true;
        for (std::uint64_t a = sector * c_.sector_bytes; a < (sector + 1) * c_.sector_bytes; ++a)
            all &= !known_.insert(a).second;
        if (!all) read_from_memory += c_.sector_bytes;
    }
    void use(std::uint64_t line) {
        std::vector<std::uint64_t>& set = sets_[line % (c_.size_bytes / c_.line_bytes / c_.ways)];
        std::erase(set, line);
        set.push_back(line);
        if (set.size() <= c_.ways) return;
        for (std::uint64_t a = set.front() * c_.line_bytes; a < (set.front() + 1) * c_.line_bytes; ++a) {
            known_.erase(a);
            written_bytes += dirty_.erase(a);
        }
        set.erase(set.begin());
    }
    RopCacheConfig c_;
    std::map<std::uint64_t, std::vector<std::uint64_t>> sets_;  // lines, the least recently used first
    std::set<std::uint64_t> known_, dirty_;
};

// Ranges that need not know anything of lines and sectors: compressed blocks have any length.
std::vector<MemoryRequest> random_requests(std::vector<LineMask>& masks) {
    std::vector<MemoryRequest> requests;
    masks.resize(6000);
    for (std::uint32_t i = 0; i < masks.size(); ++i) {
        const std::uint64_t r = mix64(i);
        const auto bytes = static_cast<std::uint32_t>(1 + (r >> 8) % 256);
        MemoryRequest request = at((r >> 20) % 16384, bytes, (r & 1) != 0);
        if ((r & 6) == 6 && request.write) {
            for (std::uint32_t w = 0; w < 4; ++w) masks[i].word[w] = mix64(r + w);
            masks[i] = masks[i].part(0, bytes);
            request.masked = true;
            request.enables = &masks[i];
        }
        requests.push_back(request);
    }
    return requests;
}

std::uint64_t sum(const PortBytesByCause& port, bool write) {
    std::uint64_t bytes = 0;
    for (const auto& surface : port)
        for (const PortBytes& cause : surface) bytes += write ? cause.write : cause.read;
    return bytes;
}

TEST(L2Slice, BytesAgreeWithAMapOfBytesTimedAndUntimed) {
    use_picosecond_resolution();
    L2Config c = small_slice();
    c.mshrs = 4;
    std::vector<LineMask> masks;
    const std::vector<MemoryRequest> requests = random_requests(masks);
    BytewiseSlice reference(c);
    UntimedL2 untimed(c);
    std::uint64_t to_memory = 0;
    for (const MemoryRequest& r : requests) {
        reference.access(r);
        for (const MemoryRequest& below : untimed.access(r)) to_memory += below.bytes;
        ASSERT_EQ(sum(untimed.statistics().memory, false), reference.read_from_memory);
        ASSERT_EQ(untimed.statistics().cache.bytes_written_back, reference.written_bytes);
    }
    reference.flush();
    for (const MemoryRequest& below : untimed.flush()) to_memory += below.bytes;
    EXPECT_EQ(untimed.statistics().cache.bytes_written_back, reference.written_bytes);
    EXPECT_EQ(sum(untimed.statistics().memory, false) + sum(untimed.statistics().memory, true), to_memory);
    // One at a time, so that the timed slice has nothing in flight either.
    Bench bench(c);
    std::vector<MemoryClient::Item> items;
    for (std::size_t i = 0; i < requests.size(); ++i) items.push_back({i * 1000000, requests[i]});
    bench.client.start(items);
    sc_core::sc_start();
    bench.slice.end_of_frame();
    sc_core::sc_start();
    const std::uint64_t end = bench.slice.last_cycle() + 1000;
    bench.slice.finish(end);
    const L2Statistics& timed = bench.slice.statistics();
    EXPECT_EQ(sum(timed.memory, false), reference.read_from_memory);
    EXPECT_EQ(timed.cache.bytes_written_back, reference.written_bytes);
    EXPECT_EQ(sum(timed.memory, true), sum(untimed.statistics().memory, true));
    EXPECT_EQ(sum(timed.looked_up, false) + sum(timed.looked_up, true),
              sum(untimed.statistics().looked_up, false) + sum(untimed.statistics().looked_up, true));
    bench.dram.finish(end * kPeriod);
    EXPECT_EQ(bench.dram.statistics().total_read().useful, sum(timed.memory, false));
    EXPECT_EQ(bench.dram.statistics().total_write().useful, sum(timed.memory, true));
}

}  // namespace
}  // namespace ropsim
