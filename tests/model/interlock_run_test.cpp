// Engine `shader` through the program: the rop's image, cycles that follow from the configuration, bytes and
// cycles accounted for, and the machine's own order.
#include "tests/model/machine_driver.h"
#include "traces/image.h"

#include <cstring>

namespace ropsim {
namespace {

using nlohmann::json;

const std::vector<std::string> kShader = {"--engine", "shader"};
const std::vector<std::string> kMachineOrder = {"--engine", "shader", "--order", "machine"};

std::vector<std::string> with(std::vector<std::string> arguments, const std::vector<std::string>& more) {
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
}

class InterlockRun : public ModelTest {
 protected:
    std::vector<float> rgb(const std::string& out) const {
        const Image image = read_exr(path(out) + "/image.exr");
        std::vector<float> values;
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x)
                for (const char* c : {"R", "G", "B"}) values.push_back(image.pixel(x, y)[image.channel(c)]);
        return values;
    }
    void expect_same_image(const std::string& a, const std::string& b) const {
        const std::vector<float> one = rgb(a);
        const std::vector<float> two = rgb(b);
        ASSERT_EQ(one.size(), two.size());
        EXPECT_EQ(std::memcmp(one.data(), two.data(), one.size() * sizeof(float)), 0) << a << " " << b;
    }
    // One pixel of many layers, each of another colour.
    std::string write_pile(int count, int pixels = 1) const {
        TraceHeader header = plain_header(8, 8);
        std::vector<Fragment> fragments;
        for (int i = 0; i < count; ++i) {
            Fragment f = fragment_at(2 + i % pixels, 3, 0.5f - 1e-5f * static_cast<float>(i),
                                     static_cast<std::uint32_t>(i));
            f.g = f.a * static_cast<float>(i % 7) / 7.0f;
            fragments.push_back(f);
        }
        return write(header, fragments, fmt::format("pile_{}_{}", count, pixels));
    }
    // One-pixel quads that sweep an image of 32x32 again and again: operations on a pixel are 1024 quads
    // apart.
    std::string write_sweep(int count) const {
        std::vector<Fragment> fragments;
        for (int i = 0; i < count; ++i) {
            const int quad = i % 256;
            const int pixel = i / 256 % 4;
            fragments.push_back(fragment_at(quad % 16 * 2 + pixel % 2, quad / 16 * 2 + pixel / 2,
                                            0.9f - 1e-5f * static_cast<float>(i),
                                            static_cast<std::uint32_t>(i)));
        }
        return write(plain_header(32, 32), fragments, fmt::format("sweep_{}", count));
    }
};

// Slots that quads had after shading and ports to the L2: busy, idle and stalls make up the run.
void expect_every_cycle_labelled(const json& run) {
    ASSERT_TRUE(run["stages"].contains("interlock_quads"));
    ASSERT_TRUE(run["stages"].contains("interlock_port"));
    for (const auto& [name, stage] : run["stages"].items()) {
        std::uint64_t sum = stage["busy"].get<std::uint64_t>() + stage["idle"].get<std::uint64_t>();
        for (const auto& [reason, cycles] : stage["stall"].items()) sum += cycles.get<std::uint64_t>();
        EXPECT_EQ(sum, run["cycles"].get<std::uint64_t>() * stage["instances"].get<std::uint64_t>()) << name;
    }
}

json without_host(json run) {
    run.erase("host");
    run.erase("threads");
    return run;
}

class InterlockTechnique : public InterlockRun, public ::testing::WithParamInterface<std::string> {};

TEST_P(InterlockTechnique, TheImageIsTheRopsWhateverTheThreads) {
    RandomFragments options;
    options.width = 70;
    options.height = 50;
    options.count = 20000;
    options.opaque = true;
    const std::string trace = write(random_header(options), random_fragments(options));
    const Settings settings = {"rop.partitions=3", "clock.shader_mhz=1100", "shader.quads_in_flight=600"};
    const json rop = run(trace, GetParam(), settings, {"--fidelity", "count"}, "rop");
    const json one = run(trace, GetParam(), settings, with(kShader, {"--threads", "1"}), "one");
    const json two = run(trace, GetParam(), settings, with(kShader, {"--threads", "2"}), "two");
    const json cached = run(trace, GetParam(), settings, with(kShader, {"--fidelity", "cached"}), "cached");
    EXPECT_EQ(without_host(one), without_host(two));
    for (const char* other : {"one", "two", "cached"}) expect_same_image("rop", other);
    EXPECT_EQ(one["engine"], "shader");
    EXPECT_EQ(one["fragments"], rop["fragments"]);
    EXPECT_EQ(one["error"], rop["error"]);
    expect_every_cycle_labelled(one);
    // The same operations, at another cost.
    for (const auto& [path, operation] : rop["operation"].items())
        EXPECT_EQ(one["operation"][path]["count"], operation["count"]) << path;
    // What the DRAM moved has a surface and a cause.
    std::uint64_t read = 0;
    std::uint64_t write = 0;
    for (const auto& [name, surface] : one["traffic"].items()) {
        if (name == "total") continue;
        for (const auto& [cause, bytes] : surface["causes"].items()) {
            read += bytes["pin_read_bytes"].get<std::uint64_t>();
            write += bytes["pin_write_bytes"].get<std::uint64_t>();
        }
    }
    EXPECT_EQ(one["dram"]["read_bytes"], read);
    EXPECT_EQ(one["dram"]["write_bytes"], write);
    EXPECT_LE(cached["cycles"].get<double>(), 1.02 * one["cycles"].get<double>());
}

INSTANTIATE_TEST_SUITE_P(Techniques, InterlockTechnique, ::testing::ValuesIn(technique_names()),
                         [](const auto& test) { return test.param; });

std::uint64_t round_up(std::uint64_t value, std::uint64_t unit) {
    return (value + unit - 1) / unit;
}

// One fragment in an idle machine: every stage takes what the configuration says, clock crossings wait for
// the next edge.
TEST_F(InterlockRun, LatencyOfALoneQuadIsTheSumOfItsStages) {
    const std::string trace = write(plain_header(8, 8), {fragment_at(5, 6, 0.5f, 0)});
    for (const Settings& extra :
         {Settings{}, Settings{"clock.rop_mhz=900", "clock.shader_mhz=1700", "shader.alu_lanes=512"},
          Settings{"interlock.begin_cycles=7", "interlock.end_cycles=0", "interlock.memory_latency=33"},
          Settings{"interlock.instructions.multiplier=5", "l2.latency=21", "dram.device=hbm2"}}) {
        Settings settings = {"rop.partitions=1"};
        settings.insert(settings.end(), extra.begin(), extra.end());
        const MachineConfig c = configured(settings);
        const json result = run(trace, "alpha_blend", settings, kShader);
        const json& blend = result["operation"]["blend"];
        std::uint64_t instructions = 0;
        for (std::size_t u = 0; u < kUnitNames.size(); ++u)
            if (blend["units"].contains(std::string(kUnitNames[u])))
                instructions += blend["units"][std::string(kUnitNames[u])].get<std::uint64_t>() *
                                c.interlock.instructions[u];
        EXPECT_EQ(blend["interval_cycles"], instructions);
        // 1 - alpha beside the conversion of what is behind; multiplied, added, converted back. A lane issues
        // no more than an instruction a cycle.
        const auto chain = [&](Unit unit) {
            return std::uint64_t{c.interlock.instructions[static_cast<std::size_t>(unit)]} *
                   c.interlock.instruction_latency;
        };
        const std::uint64_t longest = std::max(chain(Unit::kAdder), chain(Unit::kConverter)) +
                                      chain(Unit::kMultiplier) + chain(Unit::kAdder) +
                                      chain(Unit::kConverter);
        const std::uint64_t operation =
            round_up(std::max(longest, instructions) * c.shader_period_ps, c.rop_period_ps);
        EXPECT_EQ(blend["latency_cycles"], operation);

        const std::uint64_t arrived = round_up(
            lone_quad_shaded(
                c, static_cast<std::uint32_t>(16 + instructions + c.interlock.overhead_instructions)),
            c.rop_period_ps);
        const std::uint64_t loads = arrived + c.interlock.begin_cycles;
        const DramConfig& d = c.dram;
        const std::uint64_t asked = round_up(loads * c.rop_period_ps, d.tck_ps);
        const std::uint64_t filled =
            round_up((asked + d.activate_to_read() + d.read_cycles()) * d.tck_ps, c.rop_period_ps);
        const std::uint64_t data = filled + c.l2.latency + 1 + c.interlock.memory_latency;
        const std::uint64_t left = data + operation + c.interlock.memory_latency + c.interlock.end_cycles;
        // The flush leaves at once; the row is still open.
        const std::uint64_t flushed = round_up(left * c.rop_period_ps, d.tck_ps) + d.write_cycles();
        ASSERT_LT(flushed, d.trefi) << "a refresh would interfere";
        EXPECT_EQ(result["cycles"], std::max(left + 1, round_up(flushed * d.tck_ps, c.rop_period_ps)))
            << fmt::format("{}", fmt::join(settings, " "));
    }
}

// In order, each operation on a pixel waits for the release of the one before: latencies of grant, load,
// instructions, store and release, all of them.
TEST_F(InterlockRun, APixelTakesACriticalSectionAnOperation) {
    constexpr int kCount = 3000;
    for (const Settings& settings :
         {Settings{"rop.partitions=1"},
          Settings{"rop.partitions=1", "interlock.begin_cycles=3", "interlock.memory_latency=70",
                   "interlock.instruction_latency=9", "l2.latency=11"}}) {
        const MachineConfig c = configured(settings);
        const json result = run(write_pile(kCount), "alpha_blend", settings, kShader);
        const double each = c.interlock.begin_cycles + c.l2.latency + 1 + c.interlock.memory_latency +
                            result["operation"]["blend"]["latency_cycles"].get<double>() +
                            c.interlock.memory_latency + c.interlock.end_cycles;
        EXPECT_NEAR(result["cycles"].get<double>(), kCount * each, 0.02 * kCount * each);
        // Two pixels of a quad at the same time, unless the quad is one.
        const auto pair = [&](const char* granularity) {
            const Settings more = with(settings, {granularity});
            return run(write_pile(kCount, 2), "alpha_blend", more, kShader)["cycles"].get<double>();
        };
        EXPECT_NEAR(pair("interlock.granularity=pixel"), kCount / 2 * each, 0.02 * kCount * each);
        EXPECT_NEAR(pair("interlock.granularity=quad"), kCount * each, 0.02 * kCount * each);
    }
}

// Operations on other pixels go on at the same time, until the lanes are busy with their instructions ...
TEST_F(InterlockRun, IndependentPixelsAreBoundByTheLanes) {
    constexpr int kCount = 10000;
    for (const int lanes : {8, 24}) {
        const Settings settings = {"clock.rop_mhz=1000", "clock.shader_mhz=1000",
                                   fmt::format("shader.alu_lanes={}", lanes), "shader.cores=1"};
        const json result = run(write_sweep(kCount), "alpha_blend", settings, kShader);
        const double instructions = result["operation"]["blend"]["interval_cycles"].get<double>() + 16 +
                                    configured(settings).interlock.overhead_instructions;
        const double expected = kCount * 4 * instructions / lanes;
        EXPECT_GE(result["cycles"].get<double>(), expected);
        EXPECT_LE(result["cycles"].get<double>(), 1.02 * expected) << lanes;
        const json cached =
            run(write_sweep(kCount), "alpha_blend", settings, with(kShader, {"--fidelity", "cached"}));
        EXPECT_EQ(cached["bottleneck"], "shading");
        EXPECT_NEAR(cached["cycles"].get<double>(), expected, 1);
    }
}

// ... or the port is: a load and a store an operation, one a cycle.
TEST_F(InterlockRun, IndependentPixelsAreBoundByThePort) {
    constexpr int kCount = 40000;
    const Settings settings = {"rop.partitions=1", "cache.kibibytes=64", "shader.alu_lanes=65536"};
    const json result = run(write_sweep(kCount), "alpha_blend", settings, kShader);
    EXPECT_GE(result["cycles"].get<double>(), 2 * kCount);
    EXPECT_LE(result["cycles"].get<double>(), 2 * kCount * 1.02 + 1000);
    EXPECT_EQ(result["stages"]["interlock_port"]["busy"], 2 * kCount);
}

// A lock that is free costs an atomic and a store an operation; one that is taken many more.
TEST_F(InterlockRun, SpinningCostsAccessesWhereOthersHaveThePixel) {
    constexpr int kCount = 1000;
    const Settings spin = {"rop.partitions=1", "interlock.mode=spin"};
    const json alone = run(write_sweep(200), "alpha_blend", spin, kShader);
    EXPECT_EQ(alone["interlock"]["tries"], 200);
    EXPECT_EQ(alone["interlock"]["retries"], 0);
    EXPECT_EQ(alone["stages"]["interlock_port"]["busy"], 4 * 200);
    const json pile = run(write_pile(kCount), "alpha_blend", spin, kShader);
    const json ordered = run(write_pile(kCount), "alpha_blend", {"rop.partitions=1"}, kShader);
    const auto tries = pile["interlock"]["tries"].get<std::uint64_t>();
    EXPECT_EQ(tries, kCount + pile["interlock"]["retries"].get<std::uint64_t>());
    EXPECT_GT(tries, 20u * kCount);
    EXPECT_EQ(pile["stages"]["interlock_port"]["busy"], tries + 3u * kCount);
    EXPECT_EQ(ordered["stages"]["interlock_port"]["busy"], 2 * kCount);
    EXPECT_EQ(ordered["interlock"]["tries"], 0);
    EXPECT_GT(pile["cycles"], ordered["cycles"]);
    expect_every_cycle_labelled(pile);
}

TEST_F(InterlockRun, InOrderTheMachinesOrderIsTheTraces) {
    run(write_pile(500), "mlab:layers=2", {}, {}, "rop");
    for (const std::string engine : {"rop", "shader"}) {
        const json result = run(write_pile(500), "mlab:layers=2", {},
                                {"--engine", engine, "--order", "machine"}, engine + "_machine");
        EXPECT_EQ(result["order"], "machine");
        EXPECT_EQ(result["machine_order"]["inversions"], 0);
        EXPECT_EQ(result["machine_order"]["pixels_different"], 0);
        expect_same_image("rop", engine + "_machine");
    }
    // Without others on its pixels, a quad that spins comes to them in order, too.
    run(write_sweep(1000), "mlab:layers=2", {}, {}, "rop_sweep");
    const json spin = run(write_sweep(1000), "mlab:layers=2", {"interlock.mode=spin"}, kMachineOrder, "spin");
    EXPECT_EQ(spin["interlock"]["retries"], 0);
    EXPECT_EQ(spin["machine_order"]["inversions"], 0);
    EXPECT_EQ(spin["machine_order"]["rmse8_to_trace_order"], 0.0);
    expect_same_image("rop_sweep", "spin");
}

TEST_F(InterlockRun, WhoSpinsOvertakesAndTheImageShowsIt) {
    RandomFragments options;
    options.width = 16;
    options.height = 16;
    options.count = 6000;
    options.opaque = true;
    options.alpha_low = 0.2f;
    const std::string trace = write(random_header(options), random_fragments(options));
    const Settings spin = {"interlock.mode=spin", "rop.partitions=2"};
    for (const char* technique :
         {"alpha_blend", "mlab:layers=2", "stochastic:samples=8", "moment_based:moments=4"}) {
        const json in_order = run(trace, technique, spin, kShader, "in_order");
        const json one = run(trace, technique, spin, with(kMachineOrder, {"--threads", "1"}), "one");
        const json two = run(trace, technique, spin, with(kMachineOrder, {"--threads", "2"}), "two");
        EXPECT_EQ(without_host(one), without_host(two)) << technique;
        expect_same_image("one", "two");
        EXPECT_GT(one["machine_order"]["inversions"], 100) << technique;
        // The clock does not know that somebody keeps a record.
        EXPECT_EQ(one["cycles"], in_order["cycles"]) << technique;
        EXPECT_EQ(one["fragments"], in_order["fragments"]) << technique;
        std::uint64_t different = 0;
        const std::vector<float> a = rgb("in_order");
        const std::vector<float> b = rgb("one");
        for (std::size_t i = 0; i < a.size(); i += 3)
            different += std::equal(&a[i], &a[i] + 3, &b[i]) ? 0 : 1;
        EXPECT_EQ(one["machine_order"]["pixels_different"], different) << technique;
    }
    const json blend = run(trace, "alpha_blend", spin, kMachineOrder);
    EXPECT_GT(blend["machine_order"]["pixels_different"], 50);
    EXPECT_GT(blend["machine_order"]["rmse8_to_trace_order"], 1.0);
}

TEST_F(InterlockRun, WhatCannotBeIsRefusedInOneLine) {
    const std::string trace = write_pile(10);
    const auto refused = [&](const std::vector<std::string>& more, const std::string& word) {
        std::vector<std::string> arguments = {"run", trace, "-o", path("refused")};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const ProgramResult result = run_program(arguments);
        EXPECT_EQ(result.status, 1) << spelled(arguments);
        EXPECT_NE(result.err.find(word), std::string::npos) << result.err;
    };
    const std::vector<std::string> blend = {"--technique", "alpha_blend", "--engine", "shader"};
    refused(with(blend, {"--order", "machine", "--fidelity", "cached"}), "--fidelity timed");
    refused(with(blend, {"--order", "machine", "--fidelity", "count"}), "--fidelity timed");
    refused({"--technique", "depth_peeling", "--engine", "shader", "--order", "machine", "--set",
             "interlock.mode=spin"},
            "repeats its passes");
    refused(with(blend, {"--set", "interlock.mode=random"}), "interlock.mode");
    refused(with(blend, {"--set", "interlock.begin_cycles=-1"}), "interlock.begin_cycles");
    refused(with(blend, {"--set", "interlock.instructions.addr=1"}), "interlock.instructions.addr");
}

}  // namespace
}  // namespace ropsim
