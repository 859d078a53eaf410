// More of a resource does not cost cycles: random machines, each with and without more of it.
#include "base/isolated_call.h"
#include "model/run.h"
#include "tests/model/machine_driver.h"

#include <random>

namespace ropsim {
namespace {

// What is given more of, and by how much the cycles may grow: nothing but rounding (1 %), or what a greedy
// schedule can lose with more freedom (docs/timing-model.md, "Monotonicity").
constexpr double kMonotone = 1.01;
constexpr double kScheduled = 1.05;
struct Resource {
    const char* name;
    double bound;
    // Settings that give more; empty where the machine has all of it.
    Settings (*more)(const MachineConfig&);
};

Settings one(const char* key, std::uint64_t value) {
    return {fmt::format("{}={}", key, value)};
}

const std::vector<Resource> resources = {
    {"ROP lanes", kMonotone, [](const MachineConfig& c) { return one("rop.lanes", 2 * c.lanes); }},
    {"rasteriser's quads", kMonotone,
     [](const MachineConfig& c) {
         return one("shader.raster_quads_per_cycle", 2 * c.raster_quads_per_cycle);
     }},
    {"rasteriser's tiles", kMonotone,
     [](const MachineConfig& c) {
         return one("shader.raster_tiles_per_cycle", 2 * c.front.raster_tiles_per_cycle);
     }},
    {"export", kMonotone,
     [](const MachineConfig& c) {
         return one("shader.export_quads_per_cycle", 2 * c.export_quads_per_cycle);
     }},
    {"depth cache", kMonotone,
     [](const MachineConfig& c) { return one("depth.kibibytes", 2 * c.front.depth.kibibytes); }},
    {"depth ranges", kMonotone,
     [](const MachineConfig& c) {
         return c.front.hierarchical.enabled ? Settings{} : Settings{"hiz.enabled=true"};
     }},
    {"forwarding", kMonotone,
     [](const MachineConfig& c) {
         return c.hazards.forward_results ? Settings{} : Settings{"rop.forwarding=result"};
     }},
    {"write coalescing", kMonotone, [](const MachineConfig&) { return one("rop.write_coalescing", 32); }},
    {"DRAM clock", kMonotone, [](const MachineConfig& c) { return one("dram.tck_ps", c.dram.tck_ps / 2); }},
    {"activate to column", kMonotone,
     [](const MachineConfig& c) {
         return Settings{fmt::format("dram.trcd_rd={}", c.dram.trcd_rd / 2),
                         fmt::format("dram.trcd_wr={}", c.dram.trcd_wr / 2)};
     }},
    {"DRAM banks", kMonotone,
     [](const MachineConfig& c) { return one("dram.banks_per_group", 2 * c.dram.banks_per_group); }},
    {"shader clock", kScheduled,
     [](const MachineConfig& c) { return one("clock.shader_mhz", 2'000'000 / c.shader_period_ps); }},
    {"ALU lanes", kScheduled,
     [](const MachineConfig& c) { return one("shader.alu_lanes", 2 * c.shader_alu_lanes); }},
    {"warps", kScheduled,
     [](const MachineConfig& c) { return one("shader.warps", 2 * c.front.shader.warps); }},
    {"window", kScheduled,
     [](const MachineConfig& c) { return one("shader.quads_in_flight", 2 * c.shader_quads_in_flight); }},
    {"quads in flight in the ROP", kScheduled,
     [](const MachineConfig& c) { return one("rop.quads_in_flight", std::min(32u, 2 * c.quads_in_flight)); }},
    {"input queue", kScheduled,
     [](const MachineConfig& c) { return one("rop.input_queue", 2 * c.input_queue); }},
    // The crossbar's registers hold quads: a shorter one keeps them in the queue.
    {"crossbar", kScheduled,
     [](const MachineConfig& c) {
         const std::uint32_t half = c.crossbar_latency / 2;
         return Settings{fmt::format("rop.crossbar_latency={}", half),
                         fmt::format("rop.input_queue={}", c.input_queue + c.crossbar_latency - half)};
     }},
    {"ROP cache's misses", kScheduled,
     [](const MachineConfig& c) { return one("cache.mshrs", 2 * c.mshrs); }},
    {"ROP cache's ports", kScheduled,
     [](const MachineConfig& c) { return one("cache.ports", 2 * c.cache_ports); }},
    {"ROP cache's latency", kScheduled,
     [](const MachineConfig& c) { return one("cache.hit_latency", c.cache_hit_latency / 2); }},
    {"ROP cache", kScheduled,
     [](const MachineConfig& c) { return one("cache.kibibytes", 2 * c.cache.size_bytes / 1024); }},
    {"read queue", kScheduled,
     [](const MachineConfig& c) { return one("dram.read_queue", std::min(64u, 2 * c.dram.read_queue)); }},
    {"no refresh", kScheduled, [](const MachineConfig&) { return Settings{"dram.refresh=none"}; }},
};

struct Machine {
    std::string technique;
    Engine engine;
    Settings settings;
};

template <class T>
T pick(std::mt19937& random, std::initializer_list<T> from) {
    return from.begin()[random() % from.size()];
}

// About every third value is another one than the preset's.
Machine random_machine(std::mt19937& random) {
    Machine m;
    m.technique = pick(random, {"alpha_blend", "adaptive:nodes=4", "stochastic:samples=8", "a_buffer",
                                "slab:layers=4", "weighted_blended", "moment_based"});
    m.engine = pick(random, {Engine::kRop, Engine::kRop, Engine::kTiled, Engine::kShader});
    const auto maybe = [&](const char* key, std::initializer_list<const char*> from) {
        const char* value = pick(random, from);
        if (random() % 3 == 0) m.settings.push_back(fmt::format("{}={}", key, value));
    };
    maybe("shader.alu_lanes", {"64", "256"});
    maybe("shader.quads_in_flight", {"64", "512", "2048"});
    maybe("shader.raster_quads_per_cycle", {"1", "4"});
    maybe("shader.raster_tiles_per_cycle", {"1", "2"});
    maybe("shader.export_quads_per_cycle", {"1", "4"});
    maybe("shader.warps", {"2", "8"});
    maybe("shader.cores", {"4", "8"});
    maybe("shader.latency", {"20", "600"});
    maybe("rop.partitions", {"1", "2", "4"});
    maybe("rop.lanes", {"1", "2"});
    maybe("rop.input_queue", {"2", "8"});
    maybe("rop.quads_in_flight", {"4", "16"});
    maybe("rop.interlock", {"pixel", "tile"});
    maybe("rop.forwarding", {"result"});
    maybe("cache.kibibytes", {"4", "8", "32"});
    maybe("cache.mshrs", {"4", "8"});
    maybe("cache.hit_latency", {"2", "12"});
    maybe("cache.port_bytes", {"16", "32"});
    maybe("hiz.enabled", {"false"});
    maybe("depth.test", {"late"});
    maybe("rop.multipliers", {"1", "2"});
    maybe("dram.device", {"gddr5", "gddr6", "hbm2", "lpddr4"});
    maybe("clock.rop_mhz", {"700", "2000"});
    m.settings.insert(m.settings.end(), {"pool.mebibytes=64", "l2.kibibytes=64"});
    return m;
}

class Monotonicity : public ModelTest, public ::testing::WithParamInterface<int> {
 protected:
    // One simulation a process.
    static std::uint64_t cycles(const std::string& trace, const Machine& m, const Settings& more) {
        RunOptions options;
        options.trace = trace;
        options.technique = m.technique;
        options.engine = m.engine;
        options.error = false;
        options.settings = m.settings;
        options.settings.insert(options.settings.end(), more.begin(), more.end());
        return std::stoull(call_isolated(
            trace, {}, [&] { return fmt::format("{}", run_simulation(options).machine->rop_cycles); }));
    }
};

constexpr int kPairs = 8;  // of a machine

TEST_P(Monotonicity, MoreOfAResourceCostsNoCycles) {
    std::mt19937 random(static_cast<unsigned>(GetParam()) * 7919u + 1);
    LayeredScene layers;
    layers.seed = static_cast<std::uint64_t>(GetParam()) + 1;
    layers.width = 112;
    layers.height = 96;
    layers.layers = 4;
    layers.cell = 21;
    RandomFragments scattered;
    scattered.seed = layers.seed;
    scattered.width = scattered.height = 80;
    scattered.count = 12000;
    scattered.draws = 3;
    scattered.opaque = true;
    const std::string trace = GetParam() % 2 == 0
                                  ? write_layers(layers)
                                  : write(random_header(scattered), random_fragments(scattered));
    const Machine machine = random_machine(random);
    const MachineConfig config = configured(machine.settings);
    std::string name = machine.technique + fmt::format(" engine {}", static_cast<int>(machine.engine));
    for (const std::string& s : machine.settings) name += " " + s;
    const std::uint64_t base = cycles(trace, machine, {});
    for (std::size_t i = 0; i < kPairs; ++i) {
        const Resource& r = resources[(static_cast<std::size_t>(GetParam()) * kPairs + i) % resources.size()];
        const Settings more = r.more(config);
        if (more.empty()) continue;
        const std::uint64_t with_more = cycles(trace, machine, more);
        const double ratio = static_cast<double>(with_more) / static_cast<double>(base);
        ::testing::Test::RecordProperty(r.name, fmt::format("{:.4f}", ratio));
        EXPECT_LE(ratio, r.bound) << r.name << ": " << base << " to " << with_more << " cycles, " << name;
    }
}

INSTANTIATE_TEST_SUITE_P(Machines, Monotonicity, ::testing::Range(0, 18));

}  // namespace
}  // namespace ropsim
