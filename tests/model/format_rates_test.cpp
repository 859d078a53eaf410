// Cycles of a lane by stored format and by samples: closed forms of whole runs, and brute force over access
// masks.
#include "model/format_rates.h"

#include "model/lane_groups.h"
#include "rop/operation_log.h"
#include "tests/model/machine_driver.h"

#include <random>

namespace ropsim {
namespace {

using nlohmann::json;
using FormatRatesTest = ModelTest;

// Opaque one-pixel quads, far enough apart that the interlock never waits.
std::vector<Fragment> spread(int count, std::uint16_t coverage = 1) {
    std::vector<Fragment> fragments;
    for (int i = 0; i < count; ++i) {
        fragments.push_back(
            fragment_at(i % 16 * 2, i / 16 % 16 * 2, 0.5f, static_cast<std::uint32_t>(i), 1.0f));
        fragments.back().coverage = coverage;
    }
    return fragments;
}

const Settings kOneLane = {"rop.partitions=1", "rop.lanes=1", "cache.kibibytes=64"};

Settings with(Settings settings, const Settings& more) {
    settings.insert(settings.end(), more.begin(), more.end());
    return settings;
}

// A lane is taken for the format's cycles, and that is the throughput where nothing else is narrower.
TEST_F(FormatRatesTest, TheFormatBoundsTheThroughputOfALane) {
    constexpr int kCount = 20000;
    const std::string trace = write(plain_header(32, 32), spread(kCount));
    const struct {
        const char* technique;
        Settings settings;
        int cycles;
    } cases[] = {
        {"alpha_blend:color_format=unorm8", {}, 1},
        {"alpha_blend:color_format=r11g11b10", {}, 1},
        {"alpha_blend", {}, 2},  // RGBA16F
        {"alpha_blend:color_format=unorm16", {}, 2},
        {"alpha_blend:format=float32", {}, 4},
        {"alpha_blend", {"rop.rate.bits_64=1"}, 1},
        {"alpha_blend:color_format=unorm8", {"rop.rate.bits_32=3"}, 3},
        {"alpha_blend:format=float32", {"rop.rate.bits_128=8"}, 8},
        // The slower of format and arithmetic: four multiplications.
        {"alpha_blend", {"rop.multipliers=1"}, 4},
        {"alpha_blend:format=float32", {"rop.multipliers=1", "rop.rate.bits_128=5"}, 5},
    };
    for (const auto& c : cases) {
        const json result = run(trace, c.technique, with(kOneLane, c.settings));
        SCOPED_TRACE(fmt::format("{} {}", c.technique, fmt::join(c.settings, " ")));
        EXPECT_EQ(result["stages"]["rop_operation"]["busy"], c.cycles * kCount);
        EXPECT_GE(result["cycles"], c.cycles * kCount);
        EXPECT_LE(result["cycles"].get<double>(), 1.06 * c.cycles * kCount);
    }
}

// Busy cycles of the operations on the fragments alone: with a second image pass over the same tiles they
// would not separate, so the resolve's are those of a frame without fragments that are operated.
TEST_F(FormatRatesTest, TargetsOfOneOperationFollowEachOther) {
    constexpr int kCount = 4096;
    const std::string trace = write(plain_header(32, 32), spread(kCount));
    // RGBA16F and an 8-bit target: 2 + 1; the resolve writes RGBA16F, each of the 1024 pixels once.
    const json blended = run(trace, "weighted_blended", kOneLane);
    EXPECT_EQ(blended["stages"]["rop_operation"]["busy"], 3 * kCount + 2 * 1024);
    const json wide = run(trace, "weighted_blended:format=float32", kOneLane);
    EXPECT_EQ(wide["stages"]["rop_operation"]["busy"], (4 + 1) * kCount + 4 * 1024);
    // Nodes have no rate: the visibility pass takes a cycle, the composite RGBA16F's two.
    const json adaptive = run(trace, "adaptive:nodes=4", kOneLane);
    EXPECT_EQ(adaptive["stages"]["rop_operation"]["busy"], (1 + 2) * kCount + 2 * 1024);
}

// Fragments that cover s of 4 samples, each with a depth and a colour: s turns, or fewer side by side. A
// curve of nodes belongs to the pixel.
TEST_F(FormatRatesTest, SamplesFollowEachOther) {
    constexpr int kCount = 2048;
    TraceHeader header = plain_header(32, 32);
    header.samples = 4;
    for (const auto& [coverage, samples] :
         {std::pair(1, 1), std::pair(5, 2), std::pair(7, 3), std::pair(15, 4)}) {
        const std::string trace = write(header, spread(kCount, static_cast<std::uint16_t>(coverage)),
                                        fmt::format("trace{}", coverage));
        for (const int wide : {1, 2, 4}) {
            const MachineConfig config =
                configured(with(kOneLane, {fmt::format("rop.samples_per_cycle={}", wide)}));
            const auto turns = static_cast<std::uint32_t>((samples + wide - 1) / wide);
            for (const auto& [technique, expected] :
                 {std::pair("hashed_alpha", turns), std::pair("adaptive:nodes=4", 1u)}) {
                int quads = 0;
                for (const QuadOperation& q : run_frame(trace, technique, config, 1, true).quads) {
                    if (q.kind != QuadKind::kDraw) continue;
                    ASSERT_EQ(q.interval, expected) << technique << " " << coverage << " " << wide;
                    ++quads;
                }
                EXPECT_GE(quads, kCount);
            }
        }
    }
}

std::uint32_t bits(std::uint64_t mask) {
    std::uint32_t n = 0;
    for (; mask != 0; mask &= mask - 1) ++n;
    return n;
}

// Any masks of any surfaces, against the rule written out.
TEST_F(FormatRatesTest, EveryAccessTakesWhatTheRuleSays) {
    std::mt19937_64 random(7);
    for (const std::string technique :
         {"stochastic:samples=8", "stochastic:samples=8,correction=coverage", "hashed_alpha", "depth_peeling",
          "moment_based:moments=4", "moment_based:moments=8,format=float32", "slab:layers=4,bits=32",
          "a_buffer", "adaptive:nodes=8,layout=planar", "weighted_blended", "laine_karras:samples=8"}) {
        for (const int samples : {1, 4}) {
            TraceHeader header = plain_header(16, 16);
            header.samples = samples;
            const bool one_sample_only = technique.starts_with("moment") || technique.starts_with("slab") ||
                                         technique.starts_with("weighted");
            if (samples > 1 && one_sample_only) continue;
            const auto operation = operation_for(technique, header);
            const Declaration& declared = operation->declaration();
            const MachineConfig config = configured({"rop.rate.bits_32=2", "rop.rate.bits_64=3",
                                                     "rop.rate.bits_128=7", "rop.samples_per_cycle=2"});
            const SurfaceMap map(declared, config, header);
            const LaneTurns turns(declared, map, config.rates);
            for (int trial = 0; trial < 200; ++trial) {
                PixelAccess access{};
                std::uint32_t writes = 0;
                std::uint32_t most = 1;
                for (std::size_t s = 0; s < declared.surfaces.size(); ++s) {
                    const Surface& surface = declared.surfaces[s];
                    const std::uint64_t all = all_elements(surface.elements);
                    access[s] = {random() & random() & all, random() & random() & all};
                    if (surface.layout == Layout::kPool) continue;
                    const bool planes = surface.layout == Layout::kPlanar && surface.elements > 1;
                    const auto in_turns = [&](std::uint64_t mask) {
                        if (mask == 0) return 0u;
                        return planes ? (bits(mask) + 1) / 2 : 1u;
                    };
                    const std::uint32_t rate =
                        surface.element_bits <= 32   ? 2
                        : surface.element_bits <= 64 ? 3
                        : surface.element_bits <= 128
                            ? 7
                            : 7 * static_cast<std::uint32_t>((surface.element_bits + 127) / 128);
                    if (map.surface_class(static_cast<int>(s)) == SurfaceClass::kColor)
                        writes += rate * in_turns(access[s].write);
                    if (planes) most = std::max(most, in_turns(access[s].read | access[s].write));
                }
                EXPECT_EQ(turns.cycles(access.data()), std::max(writes, most)) << technique;
                const std::uint32_t image = map.pixel_bytes(map.image()) == 16 ? 7 : 3;
                EXPECT_EQ(turns.cycles(access.data(), true), std::max(writes + image, most)) << technique;
            }
        }
    }
}

// Of 4 pixels in 2 lanes the second two start when the slower of the first two has left.
TEST(LaneGroupsTest, ALatePixelWaitsForThoseBefore) {
    PathCost path;
    path.interval = 3;
    path.work.latency = 10;
    LaneGroups groups(2);
    groups.add(path, {}, 1);
    groups.add(path, {}, 5);
    EXPECT_EQ(groups.interval(), 5u);
    EXPECT_EQ(groups.latency(), 14u);  // its fifth turn starts 4 cycles after the first
    groups.add(path, {}, 1);
    EXPECT_EQ(groups.interval(), 8u);
    EXPECT_EQ(groups.latency(), 15u);
    groups.add(path, {}, 2);
    EXPECT_EQ(groups.interval(), 8u);
    EXPECT_EQ(groups.latency(), 16u);
}

TEST_F(FormatRatesTest, RatesOutOfRangeAreRefused) {
    for (const std::string bad : {"rop.rate.bits_32=0", "rop.rate.bits_64=65", "rop.rate.bits_128=1.5",
                                  "rop.samples_per_cycle=0", "datapath.units.adder=1", "rop.comparators=-1"})
        EXPECT_THROW(configured({bad}), UserError) << bad;
}

}  // namespace
}  // namespace ropsim
