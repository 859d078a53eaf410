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
    const char* device;  // tests/memory/simulators/<device>.toml
    Load load;
    double gigabytes_per_second;
    double activations;  // per request
    double nanoseconds;  // mean latency of reads; 0: not published
};

void PrintTo(const Measured& m, std::ostream* out) {
    *out << m.device;
}

std::string device_file(const std::string& name) {
    return ROPSIM_SOURCE_DIR "/tests/memory/simulators/" + name + ".toml";
}

std::uint64_t address(const DramConfig& c, std::uint64_t i, bool random) {
    return ((random ? splitmix(20240607 + i) : i) & 0xffffff) * 64 & (c.capacity_bytes() - 1);
}

class Reference : public testing::TestWithParam<Measured> {};
INSTANTIATE_TEST_SUITE_P(
    Simulators, Reference,
    testing::Values(Measured{"dramsim3_gddr5", Load::kSequentialRead, 45.34, 0.009, 78},
                    Measured{"dramsim3_gddr5", Load::kRandomRead, 8.16, 1.007, 872},
                    Measured{"dramsim3_gddr5", Load::kSequentialMix, 35.90, 0.009, 0},
                    Measured{"ramulator_gddr6", Load::kSequentialRead, 19.82, 0.034, 68},
                    Measured{"ramulator_gddr6", Load::kRandomRead, 9.19, 1.011, 140},
                    Measured{"ramulator_gddr6", Load::kSequentialMix, 15.63, 0.036, 0},
                    Measured{"ramulator_gddr6_mop4", Load::kSequentialRead, 23.00, 0.135, 62},
                    Measured{"ramulator_gddr6_mop4", Load::kRandomRead, 4.66, 2.000, 262},
                    Measured{"ramulator_gddr6_mop4", Load::kSequentialMix, 14.44, 0.252, 0},
                    Measured{"dramsim3_gddr6", Load::kSequentialRead, 31.77, 0, 0},
                    Measured{"dramsim3_gddr6", Load::kRandomRead, 7.33, 0, 0}));

TEST_P(Reference, Agrees) {
    const Measured& m = GetParam();
    const DramConfig c = test_config(device_file(m.device));
    DramDriver d(c);
    d.scheduler.set_trace(nullptr);
    const std::uint64_t count = 300000;
    for (std::uint64_t i = 0; i < count; ++i) {
        const bool write = m.load == Load::kSequentialMix && (splitmix(20240607 ^ (i * 7919)) >> 17 & 1) != 0;
        d.offer(address(c, i, m.load == Load::kRandomRead), 64, write);
    }
    d.drain();
    d.scheduler.finish(d.now);
    const DramStatistics& s = d.scheduler.statistics();
    const double seconds = static_cast<double>(s.cycles) * c.tck_ps * 1e-12;
    EXPECT_NEAR(count * 64 / seconds * 1e-9 / m.gigabytes_per_second, 1.0, 0.03);
    // Published with three digits behind the point.
    if (m.activations != 0) {
        EXPECT_NEAR(static_cast<double>(s.activations) / count, m.activations, 0.03 * m.activations + 0.0005);
    }
    if (m.nanoseconds != 0) {
        EXPECT_NEAR(s.read_latency.mean() * c.tck_ps * 1e-3 / m.nanoseconds, 1.0, 0.06);
    }
}

// Random reads, one outstanding: mean unloaded latency.
TEST(Reference, UnloadedLatencyAgrees) {
    const std::pair<const char*, double> devices[] = {
        {"dramsim3_gddr5", 47.8}, {"ramulator_gddr6", 48.8}, {"ramulator_gddr6_mop4", 55.5}};
    for (const auto& [device, nanoseconds] : devices) {
        const DramConfig c = test_config(device_file(device));
        DramDriver d(c);
        d.scheduler.set_trace(nullptr);
        for (std::uint64_t i = 0; i < 20000; ++i) {
            d.offer(address(c, i, true), 64, false);
            d.drain();
            d.now = std::max(d.now, d.finished.back().cycle);
        }
        EXPECT_NEAR(d.scheduler.statistics().read_latency.mean() * c.tck_ps * 1e-3 / nanoseconds, 1.0, 0.015)
            << device;
    }
}

}  // namespace
}  // namespace ropsim
