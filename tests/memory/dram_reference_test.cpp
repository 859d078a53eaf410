// Bandwidth, activations and latency against what two independent simulators measured with the same
// parameters: DRAMsim3 (2981759) on GDDR5, Ramulator 2.1 (c5b1c3a) on GDDR6. Requests of 64 bytes over 1 GiB,
// as fast as accepted.
#include "dram_driver.h"

#include <ostream>
#include <string>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

// SplitMix64, as the published workloads define it.
std::uint64_t splitmix(std::uint64_t x) {
    x += 0x9E3779B97F4A7C15ull;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ull;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBull;
    return x ^ (x >> 31);
}

enum class Load { kSequentialRead, kRandomRead, kSequentialMix };

struct Measured {
    const char* device;
    Load load;
    double gigabytes_per_second;
    double tolerance;    // relative
    double activations;  // per request
};

void PrintTo(const Measured& m, std::ostream* out) {
    *out << m.device;
}

class Reference : public testing::TestWithParam<Measured> {};
// The mix depends on each simulator's write policy, which differ more than their timings do.
INSTANTIATE_TEST_SUITE_P(Simulators, Reference,
                         testing::Values(Measured{"gddr5", Load::kSequentialRead, 45.34, 0.03, 0.009},
                                         Measured{"gddr5", Load::kRandomRead, 8.16, 0.02, 1.007},
                                         Measured{"gddr5", Load::kSequentialMix, 35.90, 0.05, 0.009},
                                         Measured{"gddr6", Load::kSequentialRead, 19.82, 0.04, 0.034},
                                         Measured{"gddr6", Load::kRandomRead, 9.19, 0.02, 1.011},
                                         Measured{"gddr6", Load::kSequentialMix, 15.63, 0.20, 0.036}));

TEST_P(Reference, Agrees) {
    const Measured& m = GetParam();
    const DramConfig c = test_config(m.device);
    DramDriver d(c);
    d.scheduler.set_trace(nullptr);
    const std::uint64_t count = 300000;
    for (std::uint64_t i = 0; i < count; ++i) {
        const std::uint64_t block =
            m.load == Load::kRandomRead ? splitmix(20240607 + i) & 0xffffff : i & 0xffffff;
        const bool write = m.load == Load::kSequentialMix && (splitmix(20240607 ^ (i * 7919)) >> 17 & 1) != 0;
        d.offer(block * 64 & (c.capacity_bytes() - 1), 64, write);
    }
    d.drain();
    d.scheduler.finish(d.now);
    const DramStatistics& s = d.scheduler.statistics();
    const double seconds = static_cast<double>(s.cycles) * c.tck_ps * 1e-12;
    EXPECT_NEAR(count * 64 / seconds * 1e-9 / m.gigabytes_per_second, 1.0, m.tolerance);
    EXPECT_NEAR(static_cast<double>(s.activations) / count, m.activations, 0.02);
}

// Random reads, one outstanding: mean unloaded latency.
TEST(Reference, UnloadedLatencyAgrees) {
    const std::pair<const char*, double> devices[] = {{"gddr5", 47.8}, {"gddr6", 48.8}};
    for (const auto& [device, nanoseconds] : devices) {
        const DramConfig c = test_config(device);
        DramDriver d(c);
        for (std::uint64_t i = 0; i < 20000; ++i) {
            d.offer((splitmix(20240607 + i) & 0xffffff) * 64 & (c.capacity_bytes() - 1), 64, false);
            d.drain();
            d.now = std::max(d.now, d.finished.back().cycle);
        }
        EXPECT_NEAR(d.scheduler.statistics().read_latency.mean() * c.tck_ps * 1e-3 / nanoseconds, 1.0, 0.04)
            << device;
    }
}

}  // namespace
}  // namespace ropsim
