// Cycles that follow from the configuration: the latency of one quad, and what bounds the throughput of many.
#include "tests/model/machine_driver.h"

#include <cmath>

namespace ropsim {
namespace {

using nlohmann::json;
using ThroughputTest = ModelTest;

std::uint64_t round_up(std::uint64_t value, std::uint64_t unit) {
    return (value + unit - 1) / unit;
}

// One fragment in an idle machine whose memory must be read. Each stage takes what the configuration says;
// clock crossings wait for the next edge. After the write the line is flushed, and the frame ends with its
// last data.
TEST_F(ThroughputTest, LatencyOfALoneQuadIsTheSumOfItsStages) {
    const std::string trace = write(plain_header(8, 8), {fragment_at(5, 6, 0.5f, 0)});
    for (const Settings& extra :
         {Settings{}, Settings{"clock.rop_mhz=900", "clock.shader_mhz=1700", "shader.alu_lanes=16"},
          Settings{"dram.device=lpddr4", "cache.hit_latency=9", "rop.crossbar_latency=5"},
          Settings{"datapath.latency.multiplier=20", "shader.latency=7", "dram.device=hbm2"}}) {
        Settings settings = {"rop.partitions=1", "cache.fast_clear=false"};
        settings.insert(settings.end(), extra.begin(), extra.end());
        const MachineConfig c = configured(settings);
        const std::uint64_t rop = c.rop_period_ps;
        const DramConfig& d = c.dram;
        const std::uint64_t exported = round_up(lone_quad_shaded(c, 16), rop);
        const std::uint64_t tagged =
            exported + c.crossbar_latency;  // the miss leaves in the cycle of the tag check
        const std::uint64_t asked = round_up(tagged * rop, d.tck_ps);
        const std::uint64_t data =
            asked + d.activate_to_read() + d.read_cycles();  // bank closed, nobody else there
        const std::uint64_t filled = round_up(data * d.tck_ps, rop);
        // (1 - alpha) x behind + colour, behind converted from binary16 meanwhile, the result converted back.
        const auto latency = [&](Unit u) {
            return static_cast<std::uint64_t>(c.datapath.latency[static_cast<std::size_t>(u)]);
        };
        const std::uint64_t operation = std::max(latency(Unit::kAdder), latency(Unit::kConverter)) +
                                        latency(Unit::kMultiplier) + latency(Unit::kAdder) +
                                        latency(Unit::kConverter) + 1;  // RGBA16F's second turn
        const std::uint64_t written =
            filled + c.cache_hit_latency + operation + 1;  // a cycle for its one line
        // The flush leaves at once, the row is still open, and read to write turnaround has long passed.
        const std::uint64_t flushed = round_up(written * rop, d.tck_ps) + d.write_cycles();
        const std::uint64_t cycles = std::max(written + 1, round_up(flushed * d.tck_ps, rop));
        ASSERT_LT(flushed, d.trefi) << "a refresh would interfere";
        ASSERT_GE(round_up(written * rop, d.tck_ps), asked + d.activate_to_read() + d.trtw)
            << "the turnaround would interfere";
        const json result = run(trace, "alpha_blend", settings);
        EXPECT_EQ(result["cycles"], cycles) << fmt::format("{}", fmt::join(settings, " "));
        EXPECT_EQ(result["dram"]["row_misses"], 1);
        EXPECT_EQ(result["dram"]["row_hits"], 1);
    }
}

// The fragments of one-pixel quads that sweep an image of 32x32 again and again: hazards are 1024 quads
// apart.
std::vector<Fragment> sweep(int count) {
    std::vector<Fragment> fragments;
    for (int i = 0; i < count; ++i) {
        // Pixel by pixel of the quads' first, then of their second ...
        const int quad = i % 256;
        const int pixel = i / 256 % 4;
        fragments.push_back(fragment_at(quad % 16 * 2 + pixel % 2, quad / 16 * 2 + pixel / 2, 0.5f,
                                        static_cast<std::uint32_t>(i)));
    }
    return fragments;
}

// With one multiplier a lane, the four multiplications of a blend keep the units for four cycles.
TEST_F(ThroughputTest, OperationUnitsBoundTheThroughput) {
    constexpr int kCount = 20000;
    const std::string trace = write(plain_header(32, 32), sweep(kCount));
    const Settings settings = {"rop.partitions=1", "rop.lanes=1", "rop.multipliers=1", "cache.kibibytes=64"};
    const json result = run(trace, "alpha_blend", settings);
    EXPECT_EQ(result["operation"]["blend"]["count"], kCount);
    EXPECT_EQ(result["operation"]["blend"]["interval_cycles"], 4);
    EXPECT_EQ(result["stages"]["rop_operation"]["busy"], 4 * kCount);
    EXPECT_GE(result["cycles"], 4 * kCount);
    EXPECT_LE(result["cycles"].get<double>(), 1.02 * 4 * kCount);
    // Fully provided, and at full rate, one quad a cycle: then the tag check, one line a cycle, is as fast.
    const json wide = run(trace, "alpha_blend",
                          {"rop.partitions=1", "rop.lanes=1", "rop.rate.bits_64=1", "cache.kibibytes=64"});
    EXPECT_EQ(wide["stages"]["rop_operation"]["busy"], kCount);
    EXPECT_GE(wide["cycles"], kCount);
    EXPECT_LE(wide["cycles"].get<double>(), 1.06 * kCount);
}

// 4 lanes of 16 instructions a quad over `alu_lanes`.
TEST_F(ThroughputTest, ShaderLanesBoundTheThroughput) {
    constexpr int kCount = 10000;
    const std::string trace = write(plain_header(32, 32), sweep(kCount));
    for (const int lanes : {4, 12, 16}) {
        const json result = run(trace, "alpha_blend",
                                {"clock.rop_mhz=1000", "clock.shader_mhz=1000", "shader.cores=1",
                                 fmt::format("shader.alu_lanes={}", lanes)});
        const double expected = kCount * 4.0 * 16.0 / lanes;
        EXPECT_GE(result["cycles"].get<double>(), expected);
        EXPECT_LE(result["cycles"].get<double>(), 1.02 * expected) << lanes;
        EXPECT_NEAR(result["shader_alu_utilisation"].get<double>(), 1.0, 0.02);
        // All other cycles than those in which quads leave are spent on shading.
        const json& front_end = result["stages"]["front_end"];
        EXPECT_NEAR(front_end["stall"]["shading"].get<double>() + front_end["busy"].get<double>(), expected,
                    0.02 * expected);
        EXPECT_NEAR(result["stages"]["shader_core"]["busy"].get<double>(), expected, 0.001 * expected);
    }
}

// Fragments at one pixel: each reads what the one before has written, so it takes the cache's read, the
// operation and the write. With the pixel's granularity four pixels of a quad overlap, with the quad's they
// do not.
TEST_F(ThroughputTest, TheInterlockBoundsTheThroughputOfAPixel) {
    constexpr int kCount = 6000;
    std::vector<Fragment> one;
    std::vector<Fragment> four;
    for (int i = 0; i < kCount; ++i) {
        one.push_back(fragment_at(3, 3, 0.5f, static_cast<std::uint32_t>(i)));
        four.push_back(fragment_at(2 + i % 2, 2 + i / 2 % 2, 0.5f, static_cast<std::uint32_t>(i)));
    }
    const std::string same = write(plain_header(8, 8), one, "one");
    const std::string spread = write(plain_header(8, 8), four, "four");
    for (const int hit : {1, 4, 11}) {
        const std::string hit_latency = fmt::format("cache.hit_latency={}", hit);
        const MachineConfig c = configured();
        // Two adders, a multiplier, a converter, a second turn: see the lone quad.
        const double operation = 2 + 2 + 2 + 1 + 1;
        ASSERT_EQ(c.datapath.latency[static_cast<std::size_t>(Unit::kAdder)], 2);
        ASSERT_EQ(c.datapath.latency[static_cast<std::size_t>(Unit::kMultiplier)], 2);
        ASSERT_EQ(c.datapath.latency[static_cast<std::size_t>(Unit::kConverter)], 1);
        const double each = hit + operation + 1;
        const auto cycles = [&](const std::string& trace, const char* granularity) {
            return run(trace, "alpha_blend", {hit_latency, granularity})["cycles"].get<double>();
        };
        EXPECT_NEAR(cycles(same, "rop.interlock=quad") / kCount, each, 0.02 * each + 800.0 / kCount);
        EXPECT_NEAR(cycles(same, "rop.interlock=pixel") / kCount, each, 0.02 * each + 800.0 / kCount);
        EXPECT_NEAR(cycles(spread, "rop.interlock=quad") / kCount, each, 0.02 * each + 800.0 / kCount);
        EXPECT_NEAR(cycles(spread, "rop.interlock=pixel") / kCount, each / 4, 0.02 * each + 800.0 / kCount);
    }
}

// A screen of one layer, every byte read and written once: the pins are busy most of the time, cannot be
// faster than their peak, and a memory of half the clock takes twice the time.
TEST_F(ThroughputTest, MemoryBoundsAStreamingLayer) {
    std::vector<Fragment> fragments;
    std::uint32_t primitive = 0;
    for (int tile = 0; tile < 32 * 32; ++tile)
        for (int i = 0; i < 64; ++i) {
            const int quad = i / 4;
            fragments.push_back(fragment_at(tile % 32 * 8 + quad % 4 * 2 + i % 2,
                                            tile / 32 * 8 + quad / 4 * 2 + i % 4 / 2, 0.5f, primitive));
            primitive += i % 4 == 3 ? 1 : 0;
        }
    const std::string trace = write(plain_header(256, 256), fragments);
    const Settings settings = {"rop.partitions=2", "cache.fast_clear=false", "dram.trefi=0", "rop.lanes=4"};
    const MachineConfig c = configured(settings);
    const json result = run(trace, "alpha_blend", settings);
    const double bytes = 256.0 * 256.0 * 8.0;
    EXPECT_EQ(result["dram"]["read_bytes"].get<double>(), bytes);
    EXPECT_EQ(result["dram"]["write_bytes"].get<double>(), bytes);
    const double peak_seconds = 2 * bytes / 2 / c.dram.peak_bytes_per_second();
    EXPECT_GE(result["seconds"].get<double>(), peak_seconds);
    // The channels' cycles are whole: two of them at most are cut off at the end.
    EXPECT_NEAR(result["dram"]["utilisation"].get<double>(), peak_seconds / result["seconds"].get<double>(),
                1e-4);
    EXPECT_GT(result["dram"]["utilisation"].get<double>(), 0.4);
    Settings slow = settings;
    slow.push_back(fmt::format("dram.tck_ps={}", 2 * c.dram.tck_ps));
    const json twice = run(trace, "alpha_blend", slow);
    EXPECT_NEAR(twice["seconds"].get<double>() / result["seconds"].get<double>(), 2.0, 0.06);
}

}  // namespace
}  // namespace ropsim
