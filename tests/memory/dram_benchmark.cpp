// Host speed of a DRAM channel behind its TLM port: requests of 64 bytes per second of CPU time. One workload
// a run of the program, because SystemC elaborates once: benchmark_memory [device] [random|sequential]
// [percent writes].
#include "base/error.h"
#include "base/parameters.h"
#include "base/random.h"
#include "memory/dram_channel.h"
#include "memory/tlm_memory_port.h"

#include <cstdlib>
#include <string>

#include <benchmark/benchmark.h>

namespace ropsim {
namespace {

struct Workload {
    std::string device = "gddr6";
    bool random = true;
    std::uint64_t percent_writes = 0;
} workload;

// Keeps the channel busy with as many requests as it takes.
class Feeder : public MemoryPortClient {
 public:
    explicit Feeder(EventWheel& wheel)
        : port("port", wheel, *this, 128), wheel_(wheel), id_(wheel.add(*this)) {}
    void run(std::uint64_t requests) {
        left_ = requests;
        wheel_.arm(id_, wheel_.now());
        sc_core::sc_start();
    }
    Picoseconds step(Picoseconds) {
        while (left_ != 0 && port.can_issue()) {
            --left_;
            const std::uint64_t r = mix64(count_);
            request_.address = (workload.random ? r : count_) * 64 & 0xffffffc0 & (capacity - 1);
            ++count_;
            request_.bytes = 64;
            request_.write = (r >> 32) % 100 < workload.percent_writes;
            request_.cause = request_.write ? MemoryCause::kWriteBack : MemoryCause::kFill;
            port.issue(request_);
        }
        return kNever;
    }
    void memory_done(std::uint32_t, bool) override {}  // the pool is larger than the queue
    void memory_port_free() override { wheel_.arm(id_, wheel_.now()); }
    TlmMemoryPort port;
    std::uint64_t capacity = 0;  // bytes, a power of two

 private:
    EventWheel& wheel_;
    int id_;
    MemoryRequest request_;
    std::uint64_t left_ = 0;
    std::uint64_t count_ = 0;
};

void dram_requests(benchmark::State& state) {
    static EventWheel wheel("wheel");
    static Feeder feeder(wheel);
    static Parameters parameters = [] {
        Parameters p("benchmark");
        p.set("dram.device", workload.device, "command line");
        return p;
    }();
    static DramChannel channel("channel", wheel, dram_config(parameters));
    static const bool bound = (feeder.port.socket.bind(channel.socket), true);
    (void)bound;
    feeder.capacity = channel.config().capacity_bytes();
    constexpr std::uint64_t kBatch = 200000;
    for (auto _ : state) feeder.run(kBatch);
    state.SetItemsProcessed(
        static_cast<std::int64_t>(kBatch * static_cast<std::uint64_t>(state.iterations())));
    const DramStatistics& s = channel.statistics();
    state.counters["row_hits"] =
        static_cast<double>(s.row_hits) / static_cast<double>(s.row_hits + s.row_misses + s.row_conflicts);
}
BENCHMARK(dram_requests)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace ropsim

int main(int argc, char** argv) {
    benchmark::Initialize(&argc, argv);
    if (argc > 1) ropsim::workload.device = argv[1];
    if (argc > 2) ropsim::workload.random = std::string(argv[2]) == "random";
    if (argc > 3) ropsim::workload.percent_writes = std::strtoull(argv[3], nullptr, 10);
    ropsim::use_picosecond_resolution();
    try {
        benchmark::RunSpecifiedBenchmarks();
    } catch (const ropsim::UserError& error) {
        fmt::print(stderr, "{}: {}\n", error.where(), error.what());
        return 1;
    }
    return 0;
}
