// Odd machines: caches smaller than one quad's state, single entries everywhere, every line and sector size,
// many partitions. Each run must end, and with the image of the untimed one.
#include "tests/model/machine_driver.h"
#include "traces/image.h"

#include <cstring>
#include <random>

namespace ropsim {
namespace {

class OddMachine : public ModelTest, public ::testing::WithParamInterface<int> {};

template <class T>
T pick(std::mt19937& random, std::initializer_list<T> from) {
    return from.begin()[random() % from.size()];
}

Settings odd_settings(std::mt19937& random) {
    Settings s;
    const auto set = [&](const char* key, auto value) { s.push_back(fmt::format("{}={}", key, value)); };
    const int line = pick(random, {64, 128, 256});
    const int sector = std::min(line, pick(random, {8, 16, 32, 64, 128, 256}));
    const int ways = pick(random, {1, 2, 4});
    set("cache.line_bytes", line);
    set("cache.sector_bytes", sector);
    set("cache.ways", ways);
    set("cache.kibibytes", pick(random, {1, 1, 2, 16}));
    set("cache.mshrs", pick(random, {1, 2, 256}));
    set("cache.hit_latency", pick(random, {0, 4, 100}));
    set("cache.request_queue", std::max({16, line / sector, pick(random, {16, 100})}));
    set("cache.fast_clear", pick(random, {"true", "false"}));
    set("rop.partitions", pick(random, {1, 2, 3, 7, 64}));
    set("rop.partition_tiles", pick(random, {1, 2, 64}));
    set("rop.lanes", pick(random, {1, 3, 64}));
    set("rop.input_queue", pick(random, {1, 16}));
    set("rop.quads_in_flight", pick(random, {1, 2, 32}));
    set("rop.crossbar_latency", pick(random, {0, 32}));
    set("rop.interlock", pick(random, {"quad", "pixel"}));
    set("clock.rop_mhz", pick(random, {"10", "999.9", "10000"}));
    set("clock.shader_mhz", pick(random, {"10", "1234", "10000"}));
    set("shader.alu_lanes", pick(random, {1, 1000, 1 << 20}));
    set("shader.latency", pick(random, {0, 300}));
    set("shader.quads_in_flight", pick(random, {1, 77, 1 << 20}));
    set("shader.raster_quads_per_cycle", pick(random, {1, 1024}));
    set("shader.export_quads_per_cycle", pick(random, {1, 64}));
    set("rop.multipliers", pick(random, {0, 1}));
    set("datapath.latency.adder", pick(random, {0, 2, 1000}));
    set("dram.device", pick(random, {"gddr3", "gddr5", "gddr5x", "gddr6", "hbm2", "lpddr4"}));
    set("pool.mebibytes", pick(random, {64, 100}));
    return s;
}

TEST_P(OddMachine, EndsWithTheRightImage) {
    std::mt19937 random(static_cast<unsigned>(GetParam()));
    const std::vector<std::string> techniques = {
        "laine_karras:samples=64", "adaptive:nodes=64", "stochastic:samples=32", "a_buffer",
        "slab:layers=16,bits=64",  "alpha_blend",       "weighted_blended"};
    const std::string& technique = techniques[static_cast<std::size_t>(GetParam()) % techniques.size()];
    RandomFragments options;
    options.seed = static_cast<std::uint64_t>(GetParam());
    options.width = pick(random, {5, 33});
    options.height = pick(random, {3, 40});
    options.count = 400;
    options.opaque = random() % 2 == 0;
    const std::string trace = write(random_header(options), random_fragments(options));
    const Settings settings = odd_settings(random);
    const nlohmann::json timed = run(trace, technique, settings, {"--threads", "2"}, "timed");
    const nlohmann::json cached = run(trace, technique, settings, {"--fidelity", "cached"}, "cached");
    const nlohmann::json count = run(trace, technique, settings, {"--fidelity", "count"}, "count");
    ASSERT_FALSE(timed.is_null() || cached.is_null() || count.is_null())
        << fmt::format("{}", fmt::join(settings, " "));
    EXPECT_EQ(timed["fragments"]["input"], 400);
    EXPECT_GT(timed["cycles"], 0);
    const Image image = read_exr(path("count/image.exr"));
    for (const char* other : {"timed/image.exr", "cached/image.exr"}) {
        const Image same = read_exr(path(other));
        ASSERT_EQ(same.values.size(), image.values.size());
        EXPECT_EQ(std::memcmp(same.values.data(), image.values.data(), image.values.size() * sizeof(float)),
                  0)
            << other;
    }
}

INSTANTIATE_TEST_SUITE_P(Machines, OddMachine, ::testing::Range(0, 42));

}  // namespace
}  // namespace ropsim
