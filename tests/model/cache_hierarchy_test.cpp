// What stands between a partition's operations and its channel: a port of limited width, separate caches, an
// L2 slice; in closed form, and that nothing of it changes what is computed.
#include "model/surface_map.h"
#include "tests/model/machine_driver.h"

#include <cmath>

namespace ropsim {
namespace {

using nlohmann::json;
using CacheHierarchyTest = ModelTest;

std::uint64_t up(std::uint64_t value, std::uint64_t unit) {
    return (value + unit - 1) / unit;
}

// A screen of one layer: every byte of it is read and written once.
std::vector<Fragment> one_layer(int tiles) {
    std::vector<Fragment> fragments;
    std::uint32_t primitive = 0;
    for (int tile = 0; tile < tiles * tiles; ++tile)
        for (int i = 0; i < 64; ++i) {
            const int quad = i / 4;
            fragments.push_back(fragment_at(tile % tiles * 8 + quad % 4 * 2 + i % 2,
                                            tile / tiles * 8 + quad / 4 * 2 + i % 4 / 2, 0.5f, primitive));
            primitive += i % 4 == 3 ? 1 : 0;
        }
    return fragments;
}

void expect_every_cycle_labelled(const json& run) {
    for (const auto& [name, stage] : run["stages"].items()) {
        std::uint64_t sum = stage["busy"].get<std::uint64_t>() + stage["idle"].get<std::uint64_t>();
        for (const auto& [reason, cycles] : stage["stall"].items()) sum += cycles.get<std::uint64_t>();
        EXPECT_EQ(sum, run["cycles"].get<std::uint64_t>() * stage["instances"].get<std::uint64_t>()) << name;
    }
}

TEST_F(CacheHierarchyTest, ANarrowPortBoundsThroughput) {
    const std::string trace = write(plain_header(256, 256), one_layer(32));
    const double bytes = 256.0 * 256.0 * 8.0;  // binary16 colour, each way
    for (const int width : {1, 2}) {
        const Settings settings = {"rop.partitions=2", "cache.fast_clear=false", "dram.device=hbm2",
                                   "dram.trefi=0", fmt::format("cache.port_bytes={}", width)};
        const json timed = run(trace, "alpha_blend", settings);
        const double each = bytes / 2 / width;
        EXPECT_GE(timed["cycles"].get<double>(), each);
        // What the caches hold when the last byte has been read is written after it; and a fill's request
        // waits in the queue behind the data of write-backs, which leaves gaps between fills.
        const double last = 16384.0 / width;
        EXPECT_LE(timed["cycles"].get<double>() / (each + last), 1.08) << width;
        EXPECT_EQ(timed["stages"]["rop_port_in"]["busy"].get<double>(), bytes / width);
        expect_every_cycle_labelled(timed);
        const json cached = run(trace, "alpha_blend", settings, {"--fidelity", "cached"});
        EXPECT_EQ(cached["bottleneck"], "rop_port");
        EXPECT_EQ(cached["cycles"].get<double>(), each);
    }
    const json wide = run(trace, "alpha_blend", {"rop.partitions=2", "cache.fast_clear=false"});
    EXPECT_FALSE(wide["stages"].contains("rop_port_in"));
}

// As the lone quad of throughput_test.cpp, with a slice in the way: it adds its latency and the cycles of the
// data to the fill, and the flush passes through it.
TEST_F(CacheHierarchyTest, LatencyOfALoneQuadBehindASlice) {
    const std::string trace = write(plain_header(8, 8), {fragment_at(5, 6, 0.5f, 0)});
    for (const Settings& extra :
         {Settings{}, Settings{"l2.latency=0", "l2.bytes_per_cycle=3"},
          Settings{"clock.rop_mhz=900", "clock.shader_mhz=1700", "l2.latency=111", "dram.device=lpddr4"}}) {
        Settings settings = {"rop.partitions=1", "cache.fast_clear=false", "l2.kibibytes=64"};
        settings.insert(settings.end(), extra.begin(), extra.end());
        const MachineConfig c = configured(settings);
        const DramConfig& d = c.dram;
        const std::uint64_t rop = c.rop_period_ps;
        const std::uint64_t tagged = up(lone_quad_shaded(c, 16), rop) + c.crossbar_latency;
        // Both look-ups and the request to memory happen in the cycle of the tag check.
        const std::uint64_t data = up(tagged * rop, d.tck_ps) + d.activate_to_read() + d.read_cycles();
        const std::uint64_t filled =
            up(data * d.tck_ps, rop) + c.l2.latency + up(c.cache.sector_bytes, c.l2.bytes_per_cycle);
        const auto latency = [&](Unit u) {
            return static_cast<std::uint64_t>(c.datapath.latency[static_cast<std::size_t>(u)]);
        };
        const std::uint64_t operation = std::max(latency(Unit::kAdder), latency(Unit::kConverter)) +
                                        latency(Unit::kMultiplier) + latency(Unit::kAdder) +
                                        latency(Unit::kConverter) + 1;  // RGBA16F's second turn
        const std::uint64_t written = filled + c.cache_hit_latency + operation + 1;
        // The ROP cache's flush is in the slice a cycle before it is known to be over.
        const std::uint64_t flushed = up((written + 1) * rop, d.tck_ps) + d.write_cycles();
        ASSERT_LT(flushed, d.trefi) << "a refresh would interfere";
        const json result = run(trace, "alpha_blend", settings);
        // The write's data may still be on their way into the slice by then.
        const std::uint64_t taken = written + up(c.cache.sector_bytes, c.l2.bytes_per_cycle);
        EXPECT_EQ(result["cycles"], std::max(taken, up(flushed * d.tck_ps, rop)))
            << fmt::format("{}", fmt::join(settings, " "));
        EXPECT_EQ(result["l2"]["misses"], 1);
        expect_every_cycle_labelled(result);
    }
}

TEST_F(CacheHierarchyTest, ASliceTakesTrafficFromThePinsAndNothingElse) {
    LayeredScene scene;
    scene.width = 200;
    scene.height = 120;
    scene.layers = 6;
    const std::string trace = write_layers(scene);
    const Settings small = {"cache.kibibytes=2", "cache.mshrs=8"};
    Settings slice = small;
    slice.insert(slice.end(), {"l2.kibibytes=1024"});
    const json without = run(trace, "adaptive", small, {}, "without");
    const json with = run(trace, "adaptive", slice, {}, "with");
    const json cached = run(trace, "adaptive", slice, {"--fidelity", "cached"}, "cached");
    EXPECT_TRUE(without["l2"].is_null());
    EXPECT_EQ(with["error"], without["error"]);
    EXPECT_LT(with["cycles"], without["cycles"]);
    const auto pins = [](const json& r) {
        return r["dram"]["read_bytes"].get<double>() + r["dram"]["write_bytes"].get<double>();
    };
    EXPECT_LT(pins(with), 0.6 * pins(without));
    EXPECT_NEAR(pins(cached) / pins(with), 1.0, 0.01);
    EXPECT_EQ(cached["stages"], nullptr);
    // Down the levels: what the ROP caches asked for, what the slices asked for, what the pins moved.
    for (const json& r : {with, cached}) {
        std::uint64_t above = 0;
        std::uint64_t below = 0;
        for (const auto& [name, surface] : r["traffic"].items()) {
            if (name == "total") continue;
            for (const auto& [cause, bytes] : surface["causes"].items()) {
                above += bytes["miss_port_read_bytes"].get<std::uint64_t>() +
                         bytes["miss_port_write_bytes"].get<std::uint64_t>();
                const std::uint64_t asked = bytes["l2_read_bytes"].get<std::uint64_t>() +
                                            bytes["l2_write_bytes"].get<std::uint64_t>();
                below += asked;
                EXPECT_EQ(bytes["pin_read_bytes"].get<std::uint64_t>() +
                              bytes["forwarded_bytes"].get<std::uint64_t>() +
                              bytes["pin_write_bytes"].get<std::uint64_t>(),
                          asked + bytes["padding_bytes"].get<std::uint64_t>())
                    << name << " " << cause;
            }
        }
        const json& l2 = r["l2"];
        EXPECT_EQ(l2["read_bytes"].get<std::uint64_t>() + l2["write_bytes"].get<std::uint64_t>(), above);
        EXPECT_EQ(
            l2["memory_read_bytes"].get<std::uint64_t>() + l2["memory_write_bytes"].get<std::uint64_t>(),
            below);
    }
    // Without the flush its dirty bytes stay where a later reader would find them.
    slice.push_back("l2.flush=false");
    const json kept = run(trace, "adaptive", slice, {"--fidelity", "cached"}, "kept");
    EXPECT_LT(kept["l2"]["memory_write_bytes"], cached["l2"]["memory_write_bytes"]);
    EXPECT_EQ(kept["l2"]["memory_read_bytes"], cached["l2"]["memory_read_bytes"]);
}

TEST_F(CacheHierarchyTest, SurfacesHaveTheClassOfWhatTheyHold) {
    const TraceHeader header = plain_header(32, 32);
    const MachineConfig config = configured();
    const auto classes = [&](const std::string& technique) {
        const auto operation = operation_for(technique, header);
        const SurfaceMap map(operation->declaration(), config, header);
        std::map<std::string, SurfaceClass> found;
        for (int s = 0; s < map.surfaces(); ++s) found[map.name(s)] = map.surface_class(s);
        return found;
    };
    const auto blend = classes("alpha_blend");
    EXPECT_EQ(blend.at("color"), SurfaceClass::kColor);
    EXPECT_EQ(blend.at("opaque_depth"), SurfaceClass::kDepth);
    EXPECT_EQ(blend.at("image"), SurfaceClass::kColor);
    const auto list = classes("a_buffer");
    EXPECT_EQ(list.at("nodes"), SurfaceClass::kNodes);
    EXPECT_EQ(list.at("head"), SurfaceClass::kColor);
    const auto samples = classes("stochastic:samples=8");
    EXPECT_EQ(samples.at("depth"), SurfaceClass::kDepth);
}

}  // namespace
}  // namespace ropsim
