// A million random requests of every surface and cause: bytes add up cause by cause, every read is answered
// once, and no two accesses of one burst change places.
#include "dram_driver.h"

#include "base/random.h"
#include "memory/memory_system.h"

#include <map>
#include <ostream>
#include <unordered_map>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

struct Setup {
    const char* device;
    std::vector<std::pair<std::string, std::string>> keys;
};

void PrintTo(const Setup& setup, std::ostream* out) {
    *out << setup.device;
    for (const auto& [key, value] : setup.keys) *out << " " << key << "=" << value;
}

struct Counted {
    std::uint64_t useful = 0, bus = 0, forwarded = 0;
};
using Table = std::map<std::pair<int, int>, Counted>;  // by surface and cause

void expect_equal(const Table& wanted, const DramStatistics::ByClient& counted, const char* what) {
    for (int s = 0; s < kMaxSurfaces; ++s) {
        for (int c = 0; c < kMemoryCauses; ++c) {
            const auto at = wanted.find({s, c});
            const Counted expected = at == wanted.end() ? Counted{} : at->second;
            const DramBytes& bytes = counted[static_cast<std::size_t>(s)][static_cast<std::size_t>(c)];
            EXPECT_EQ(bytes.useful, expected.useful) << what << " surface " << s << " cause " << c;
            EXPECT_EQ(bytes.bus, expected.bus) << what << " surface " << s << " cause " << c;
            EXPECT_EQ(bytes.forwarded, expected.forwarded) << what << " surface " << s << " cause " << c;
        }
    }
}

// One channel with an account of its own.
class Account : public DramCommandTrace {
 public:
    Account(const DramConfig& config) : config_(config), map_(config, "test"), scheduler(config) {
        scheduler.set_trace(this);
        outstanding_.resize(config.max_reads());
        for (std::uint32_t i = 0; i < config.max_reads(); ++i) free_.push_back(i);
    }

    void offer(DramRequest request, DramCycle cycle) {
        while (scheduler.next() < cycle) step();
        now_ = std::max(now_, cycle);
        const DramCycle arrival = now_;
        while (!try_offer(request, arrival)) {
            ASSERT_NE(scheduler.next(), kNoCycle);
            step();
        }
    }
    void finish() {
        while (scheduler.next() != kNoCycle) step();
        scheduler.finish(now_);
        EXPECT_EQ(answered, reads);
        EXPECT_EQ(free_.size(), outstanding_.size());
        // Of each burst the reads and writes came in the order of the requests.
        EXPECT_EQ(wanted_.size(), issued_.size());
        for (const auto& [burst, order] : wanted_) ASSERT_EQ(order, issued_[burst]) << burst;
    }
    void command(DramCycle, DramCommand command, std::uint32_t bank, std::uint32_t row,
                 std::uint32_t column) override {
        if (command == DramCommand::kRead) issued_[key({0, 0, bank, row, column})] += 'R';
        if (command == DramCommand::kWrite) issued_[key({0, 0, bank, row, column})] += 'W';
    }

 private:
    static std::uint64_t key(const DramPlace& p) {
        return (std::uint64_t{p.bank} << 24 | p.row) << 24 | p.column;
    }
    void step() {
        now_ = std::max(now_, scheduler.next());
        scheduler.step(now_);
        collect();
    }
    bool try_offer(DramRequest& request, DramCycle arrival) {
        if (!request.write) {
            if (free_.empty()) return false;
            request.number = free_.back();
        }
        const std::uint64_t unmoved =
            scheduler.statistics().forwarded_reads + scheduler.statistics().merged_writes;
        if (!scheduler.push(request, arrival, now_)) return false;
        const bool moved =
            unmoved == scheduler.statistics().forwarded_reads + scheduler.statistics().merged_writes;
        count(request, moved);
        if (request.write) return true;
        ++reads;
        free_.pop_back();
        outstanding_[request.number] = true;
        collect();
        return true;
    }
    void count(const DramRequest& request, bool moved) {
        const std::uint64_t size = config_.burst_bytes();
        Counted& counted =
            (request.write ? written : read)[{request.surface, static_cast<int>(request.cause)}];
        counted.useful += request.bytes;
        if (!moved) counted.forwarded += request.bytes;
        for (std::uint64_t burst = request.address / size;
             moved && burst <= (request.address + request.bytes - 1) / size; ++burst) {
            counted.bus += size;
            wanted_[key(map_.place(burst * size))] += request.write ? 'W' : 'R';
        }
    }
    void collect() {
        for (const DramScheduler::Finished& done : scheduler.finished()) {
            ASSERT_TRUE(outstanding_[done.number]) << "answered twice";
            outstanding_[done.number] = false;
            free_.push_back(done.number);
            ++answered;
        }
        scheduler.finished().clear();
    }

    DramConfig config_;
    AddressMap map_;
    std::unordered_map<std::uint64_t, std::string> wanted_, issued_;  // by burst
    std::vector<bool> outstanding_;
    std::vector<std::uint32_t> free_;
    DramCycle now_ = 0;

 public:
    DramScheduler scheduler;
    Table read, written;
    std::uint64_t reads = 0, answered = 0;
};

class Conservation : public testing::TestWithParam<Setup> {};
INSTANTIATE_TEST_SUITE_P(
    Setups, Conservation,
    testing::Values(
        Setup{"gddr3", {{"memory.channel_bits", "10 9 8"}, {"memory.bank_bits", "13 12 11"}}},
        Setup{"gddr5", {{"memory.channels", "2"}}}, Setup{"gddr5x", {{"dram.bank_xor", "true"}}},
        Setup{"gddr6", {{"memory.channel_bits", "8^14 7^13"}, {"dram.bankgroup_bits", "12^16 7^17"}}},
        Setup{"hbm2", {{"memory.channels", "8"}}},
        Setup{"lpddr4", {{"memory.channels", "4"}, {"dram.age_cap", "100"}}},
        Setup{"gddr6", {{"dram.mapping", "row bank column:4 bankgroup column:2"}, {"dram.trefi", "0"}}}));

DramRequest random_request(std::uint64_t i, std::uint64_t capacity) {
    const std::uint64_t r = mix64(3 * i + 1);
    const std::uint64_t s = mix64(3 * i + 2);
    DramRequest request;
    request.bytes = static_cast<std::uint32_t>((r & 3) != 0 ? 32 << (r >> 2 & 3) : 1 + (r >> 2) % 256);
    // Half of them meet in a few KiB.
    request.address = (r & 0x400) != 0 ? s % 8192 : s % (capacity - 256);
    if ((r & 3) != 0) request.address &= ~std::uint64_t{31};
    request.write = (r >> 12 & 3) == 0;
    request.masked = request.write && (r >> 14 & 7) == 0;
    request.surface = static_cast<std::uint8_t>(r >> 20 & (kMaxSurfaces - 1));
    request.cause = static_cast<MemoryCause>((r >> 32) % kMemoryCauses);
    return request;
}

TEST_P(Conservation, EveryByteHasACauseAndEveryReadAnAnswer) {
    constexpr std::uint64_t kRequests = 1'000'000 / 7 + 1;  // of the seven together: a million
    Parameters parameters("test");
    parameters.set("dram.device", GetParam().device, "test");
    for (const auto& [key, value] : GetParam().keys) parameters.set(key, value, "test");
    const MemoryConfig config = memory_config(parameters);
    const int bits = std::countr_zero(config.channels) + std::countr_zero(config.dram.capacity_bytes());
    const ChannelMap map(config.channel_bits, bits, "test");
    std::vector<std::unique_ptr<Account>> channels;
    for (std::uint32_t c = 0; c < config.channels; ++c)
        channels.push_back(std::make_unique<Account>(config.dram));

    Table read, written;
    std::uint64_t cycle = 0;
    for (std::uint64_t i = 0; i < kRequests; ++i) {
        DramRequest request = random_request(i, map.capacity());
        (request.write ? written : read)[{request.surface, static_cast<int>(request.cause)}].useful +=
            request.bytes;
        if (mix64(i) % 200 == 0) cycle += mix64(i) >> 40 & 2047;
        const std::uint64_t end = request.address + request.bytes;
        for (std::uint64_t from = request.address; from < end;) {
            const std::uint64_t to = std::min(end, (from / map.granule() + 1) * map.granule());
            DramRequest part = request;
            part.address = map.local(from);
            part.bytes = static_cast<std::uint32_t>(to - from);
            channels[map.channel(from)]->offer(part, cycle);
            from = to;
        }
    }
    DramStatistics total;
    Table all_read, all_written;
    const auto add = [](Table& sum, const Table& part) {
        for (const auto& [client, counted] : part) {
            sum[client].useful += counted.useful;
            sum[client].bus += counted.bus;
            sum[client].forwarded += counted.forwarded;
        }
    };
    for (const auto& channel : channels) {
        channel->finish();
        expect_equal(channel->read, channel->scheduler.statistics().read, "read");
        expect_equal(channel->written, channel->scheduler.statistics().write, "write");
        total.add(channel->scheduler.statistics());
        add(all_read, channel->read);
        add(all_written, channel->written);
    }
    expect_equal(all_read, total.read, "total read");
    expect_equal(all_written, total.write, "total write");
    // Nothing is lost between the requests and the channels; padding is what is left.
    for (const auto& [client, counted] : read) EXPECT_EQ(all_read[client].useful, counted.useful);
    for (const auto& [client, counted] : written) EXPECT_EQ(all_written[client].useful, counted.useful);
    for (const auto& [client, counted] : all_read) EXPECT_GE(counted.bus + counted.forwarded, counted.useful);
    for (const auto& [client, counted] : all_written)
        EXPECT_GE(counted.bus + counted.forwarded, counted.useful);
    EXPECT_EQ(total.total_read().bus + total.total_write().bus,
              (total.read_bursts + total.write_bursts) * config.dram.burst_bytes());
    EXPECT_GT(total.forwarded_reads, 0u);
    EXPECT_EQ(total.row_hits + total.row_misses + total.row_conflicts > 0, true);
}

}  // namespace
}  // namespace ropsim
