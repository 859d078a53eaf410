// The machine against its cycle-by-cycle twin: cycles equal but for rounding, bytes over the miss ports
// equal.
#include "model/timed_machine.h"
#include "tests/model/event_twin.h"
#include "tests/model/machine_driver.h"

#include <cmath>
#include <functional>
#include <random>

#include <sys/wait.h>
#include <unistd.h>

namespace ropsim {
namespace {

using Numbers = std::vector<std::uint64_t>;

// SystemC elaborates once a process: each simulation has its own. An empty answer is a child that died.
Numbers in_child(const std::function<Numbers()>& work) {
    int ends[2];
    if (::pipe(ends) != 0) return {};
    const pid_t child = ::fork();
    if (child == 0) {
        const rlimit seconds{100, 110};
        ::setrlimit(RLIMIT_CPU, &seconds);
        const Numbers numbers = work();
        const auto bytes = static_cast<ssize_t>(numbers.size() * sizeof(std::uint64_t));
        ::_exit(::write(ends[1], numbers.data(), static_cast<std::size_t>(bytes)) == bytes ? 0 : 1);
    }
    ::close(ends[1]);
    Numbers numbers;
    std::uint64_t one = 0;
    while (::read(ends[0], &one, sizeof one) == sizeof one) numbers.push_back(one);
    ::close(ends[0]);
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? numbers : Numbers{};
}

// Cycles, then read and written miss-port bytes by surface and cause, then the cache's counts.
Numbers numbers_of(const MachineResult& r) {
    Numbers n = {r.rop_cycles};
    for (const auto& surface : r.miss_port)
        for (const CauseBytes& cause : surface) n.insert(n.end(), {cause.read, cause.write});
    if (r.l2) {
        PortBytes memory;
        for (const auto& surface : r.l2->memory)
            for (const PortBytes& cause : surface) {
                memory.read += cause.read;
                memory.write += cause.write;
            }
        n.insert(n.end(),
                 {memory.read + memory.write, r.l2->cache.sector_hits, r.l2->cache.sector_misses,
                  r.l2->cache.sector_merges, r.l2->cache.line_evictions, r.l2->cache.bytes_written_back});
    }
    n.insert(n.end(),
             {r.cache.sector_hits, r.cache.sector_misses, r.cache.sector_merges, r.cache.line_evictions});
    for (const RopCacheStatistics& c : {r.front_end.depth_cache, r.front_end.texture_cache})
        n.insert(n.end(), {c.sector_hits, c.sector_misses, c.sector_merges});
    return n;
}

struct TwinCase {
    std::string technique;
    Settings settings;
};

class Twin : public ModelTest, public ::testing::WithParamInterface<int> {
 protected:
    void compare(const std::string& trace_path, const TwinCase& c) {
        const MachineConfig config = configured(c.settings);
        const auto simulate = [&](auto&& machine) {
            return in_child([&]() -> Numbers {
                TraceReader trace(trace_path);
                const auto operation = operation_for(c.technique, trace.header());
                Frame frame(trace, *operation, config, 1, true);
                return numbers_of(machine(frame));
            });
        };
        const Numbers fast = simulate([&](Frame& f) { return run_timed_machine(f, config, 1); });
        const Numbers slow = simulate([&](Frame& f) { return run_event_twin(f, config); });
        std::string name = c.technique;
        for (const std::string& s : c.settings) name += " " + s;
        ASSERT_GT(fast.size(), 1u) << name;
        ASSERT_EQ(fast.size(), slow.size()) << name;
        const double difference = static_cast<double>(fast[0]) / static_cast<double>(slow[0]) - 1.0;
        std::printf("%llu cycles, twin %llu (%+.4f%%) %s\n", static_cast<unsigned long long>(fast[0]),
                    static_cast<unsigned long long>(slow[0]), 100 * difference, name.c_str());
        EXPECT_LE(std::abs(difference), 0.0001)
            << name;  // rounding of fractions of picoseconds is all that may differ
        EXPECT_EQ(Numbers(fast.begin() + 1, fast.end()), Numbers(slow.begin() + 1, slow.end())) << name;
    }
};

template <class T>
T pick(std::mt19937& random, std::initializer_list<T> from) {
    return from.begin()[random() % from.size()];
}

// A small machine with everything that can be full or slow drawn at random.
TwinCase random_case(int seed) {
    std::mt19937 random(static_cast<unsigned>(seed));
    const std::vector<std::string> names = {"alpha_blend",          "adaptive:nodes=4",       "a_buffer",
                                            "stochastic:samples=8", "laine_karras:samples=8", "slab:layers=4",
                                            "weighted_blended"};
    TwinCase c{names[static_cast<std::size_t>(seed) % names.size()], {}};
    const auto set = [&](const char* key, std::initializer_list<int> from) {
        c.settings.push_back(fmt::format("{}={}", key, pick(random, from)));
    };
    set("clock.rop_mhz", {500, 1000, 1500, 2000});
    set("clock.shader_mhz", {500, 1000, 1600});
    set("shader.alu_lanes", {16, 128, 4096});
    set("shader.latency", {0, 20, 300});
    set("shader.quads_in_flight", {8, 100, 4096});
    set("shader.raster_quads_per_cycle", {1, 3, 16});
    set("shader.export_quads_per_cycle", {1, 2, 8});
    set("rop.partitions", {1, 2, 3, 8});
    set("rop.lanes", {1, 4});
    set("rop.input_queue", {1, 4, 16});
    set("rop.quads_in_flight", {1, 4, 32});
    set("rop.crossbar_latency", {0, 16});
    c.settings.push_back(fmt::format("rop.interlock={}", pick(random, {"quad", "pixel", "tile"})));
    set("cache.kibibytes", {1, 2, 8});
    set("cache.ways", {1, 2, 4});
    set("cache.line_bytes", {64, 128});
    set("cache.sector_bytes", {16, 32});
    set("cache.mshrs", {1, 3, 16});
    set("cache.hit_latency", {0, 1, 4});
    set("cache.request_queue", {16, 32});
    c.settings.push_back(fmt::format("cache.fast_clear={}", pick(random, {"true", "false"})));
    set("rop.multipliers", {0, 1});
    c.settings.push_back(fmt::format("dram.device={}", pick(random, {"gddr6", "hbm2", "lpddr4"})));
    c.settings.push_back("pool.mebibytes=4");
    set("shader.raster_tiles_per_cycle", {1, 8});
    set("shader.cores", {1, 3, 16});
    set("shader.warp_quads", {1, 4, 8});
    set("shader.warps", {1, 2, 32});
    set("shader.pack_timeout", {0, 5, 100});
    c.settings.push_back(fmt::format("hiz.enabled={}", pick(random, {"true", "true", "false"})));
    c.settings.push_back(fmt::format("depth.test={}", pick(random, {"early", "early", "late"})));
    set("depth.kibibytes", {1, 2});
    set("depth.ways", {1, 2, 4});
    set("depth.quads", {1, 3, 64});
    set("depth.mshrs", {1, 2, 8});
    set("depth.latency", {1, 8, 40});
    set("texture.l1_kibibytes", {1, 4});
    set("texture.l1_ways", {1, 4});
    set("texture.latency", {1, 30, 200});
    set("texture.mshrs", {1, 4, 64});
    set("texture.quads_per_cycle", {1, 2, 4});
    set("texture.kibibytes", {1, 64});
    c.settings.push_back("texture.mebibytes=4");
    c.settings.push_back(fmt::format("rop.forwarding={}", pick(random, {"none", "result"})));
    set("rop.write_coalescing", {0, 0, 2, 32});
    return c;
}

// The same with what the cache hierarchy may have besides: separate caches, ports, an L2 slice.
TwinCase hierarchy_case(int seed) {
    TwinCase c = random_case(seed);
    std::mt19937 random(static_cast<unsigned>(seed));
    const auto set = [&](const char* key, std::initializer_list<int> from) {
        c.settings.push_back(fmt::format("{}={}", key, pick(random, from)));
    };
    set("cache.ports", {1, 2, 3});
    set("cache.port_bytes", {0, 8, 16, 32, 100});
    if (pick(random, {0, 1, 2}) != 0) {
        c.settings.push_back("cache.organisation=separate");
        c.settings.push_back("cache.kibibytes=8");
        set("cache.depth_kibibytes", {1, 3});
        set("cache.node_kibibytes", {0, 2, 4});
    }
    if (pick(random, {0, 1, 2}) != 0) {
        set("l2.kibibytes", {4, 16, 64});
        set("l2.ways", {2, 4});
        set("l2.line_bytes", {64, 128, 256});
        set("l2.sector_bytes", {16, 32, 64});
        set("l2.latency", {0, 7, 60});
        set("l2.bytes_per_cycle", {8, 24, 64});
        set("l2.mshrs", {1, 4, 32});
        set("l2.input_queue", {1, 3, 16});
        set("l2.request_queue", {16, 32});
        c.settings.push_back(fmt::format("l2.flush={}", pick(random, {"true", "true", "false"})));
        c.settings.push_back("depth.test=late");  // the twin's slice has one initiator
    }
    return c;
}

TEST_P(Twin, AgreesOnRandomFragments) {
    RandomFragments options;
    options.seed = static_cast<std::uint64_t>(GetParam()) + 100;
    options.width = 40;
    options.height = 40;
    options.count = 2500;
    options.opaque = GetParam() % 2 == 0;
    compare(write(random_header(options), random_fragments(options)), random_case(GetParam()));
}

// Draws with textures of several sizes, one without.
TEST_P(Twin, AgreesOnTextures) {
    RandomFragments options;
    options.seed = static_cast<std::uint64_t>(GetParam()) + 500;
    options.width = 40;
    options.height = 40;
    options.count = 2500;
    options.opaque = GetParam() % 2 == 0;
    TraceHeader header = random_header(options);
    for (std::size_t d = 0; d < header.draws.size(); ++d) {
        header.draws[d].full.texture_fetches = static_cast<std::uint32_t>(d + 1) % 4;
        header.draws[d].full.texture_bytes = static_cast<std::uint32_t>(d + 1) % 4 * 20;
    }
    compare(write(header, random_fragments(options)), random_case(GetParam() + 3000));
}

TEST_P(Twin, AgreesOnLayers) {
    LayeredScene scene;
    scene.seed = static_cast<std::uint64_t>(GetParam()) + 1;
    scene.width = 48;
    scene.height = 40;
    scene.layers = 3;
    scene.cell = 13;
    compare(write_layers(scene), random_case(GetParam() + 1000));
}

TEST_P(Twin, AgreesOnTheHierarchy) {
    RandomFragments options;
    options.seed = static_cast<std::uint64_t>(GetParam()) + 300;
    options.width = 40;
    options.height = 40;
    options.count = 2500;
    options.opaque = GetParam() % 2 == 0;
    compare(write(random_header(options), random_fragments(options)), hierarchy_case(GetParam() + 2000));
}

INSTANTIATE_TEST_SUITE_P(Machines, Twin, ::testing::Range(0, 24));

}  // namespace
}  // namespace ropsim
