// The timed machine through the program: same image as untimed, same run.json whatever the threads, every
// cycle and byte accounted for.
#include "tests/model/machine_driver.h"
#include "traces/image.h"

#include <cmath>
#include <cstring>

namespace ropsim {
namespace {

using nlohmann::json;

// What may differ between two runs of the same thing.
json without_host(json run) {
    run.erase("host");
    run.erase("threads");
    return run;
}

// Busy, idle and stalls of each stage add up to its cycles.
void expect_every_cycle_labelled(const json& run) {
    ASSERT_FALSE(run["stages"].empty());
    for (const auto& [name, stage] : run["stages"].items()) {
        std::uint64_t sum = stage["busy"].get<std::uint64_t>() + stage["idle"].get<std::uint64_t>();
        for (const auto& [reason, cycles] : stage["stall"].items()) sum += cycles.get<std::uint64_t>();
        EXPECT_EQ(sum, run["cycles"].get<std::uint64_t>() * stage["instances"].get<std::uint64_t>()) << name;
    }
}

// Pins of a surface are the sum over its causes, the total the sum over surfaces and what the DRAM counted;
// pins carry at least what crossed the miss ports (whole bursts), reads that the write queue answered apart.
void expect_bytes_add_up(const json& run, std::uint64_t burst_bytes) {
    std::uint64_t read = 0;
    std::uint64_t write = 0;
    for (const auto& [name, surface] : run["traffic"].items()) {
        if (name == "total") continue;
        std::uint64_t pin_read = 0;
        std::uint64_t pin_write = 0;
        for (const auto& [cause, bytes] : surface["causes"].items()) {
            pin_read += bytes["pin_read_bytes"].get<std::uint64_t>();
            pin_write += bytes["pin_write_bytes"].get<std::uint64_t>();
            EXPECT_GE(bytes["pin_write_bytes"], bytes["miss_port_write_bytes"]) << name << " " << cause;
            EXPECT_EQ(bytes["pin_write_bytes"].get<std::uint64_t>() % burst_bytes, 0u);
            EXPECT_EQ(bytes["pin_read_bytes"].get<std::uint64_t>() % burst_bytes, 0u);
        }
        EXPECT_EQ(surface["pin_read_bytes"], pin_read) << name;
        EXPECT_EQ(surface["pin_write_bytes"], pin_write) << name;
        read += pin_read;
        write += pin_write;
    }
    EXPECT_EQ(run["traffic"]["total"]["pin_read_bytes"], read);
    EXPECT_EQ(run["traffic"]["total"]["pin_write_bytes"], write);
    EXPECT_EQ(run["dram"]["read_bytes"], read);
    EXPECT_EQ(run["dram"]["write_bytes"], write);
}

class TimedTechnique : public ModelTest, public ::testing::WithParamInterface<std::string> {
 protected:
    std::vector<float> rgb(const std::string& out) const {
        const Image image = read_exr(path(out) + "/image.exr");
        std::vector<float> values;
        for (int y = 0; y < image.height; ++y)
            for (int x = 0; x < image.width; ++x)
                for (const char* c : {"R", "G", "B"}) values.push_back(image.pixel(x, y)[image.channel(c)]);
        return values;
    }
};

TEST_P(TimedTechnique, SameImageAndSameNumbersWhateverTheThreads) {
    RandomFragments options;
    options.width = 70;
    options.height = 50;
    options.count = 40000;
    options.opaque = true;
    const std::string trace = write(random_header(options), random_fragments(options));
    const json one = run(trace, GetParam(), {}, {"--threads", "1"}, "one");
    const json again = run(trace, GetParam(), {}, {"--threads", "1"}, "again");
    const json two = run(trace, GetParam(), {}, {"--threads", "2"}, "two");
    const json count = run(trace, GetParam(), {}, {"--threads", "2", "--fidelity", "count"}, "count");
    const json cached = run(trace, GetParam(), {}, {"--threads", "2", "--fidelity", "cached"}, "cached");
    EXPECT_EQ(without_host(one), without_host(again));
    EXPECT_EQ(without_host(one), without_host(two));
    const std::vector<float> image = rgb("count");
    for (const char* other : {"one", "two", "cached"}) {
        const std::vector<float> values = rgb(other);
        ASSERT_EQ(values.size(), image.size());
        EXPECT_EQ(std::memcmp(values.data(), image.data(), image.size() * sizeof(float)), 0) << other;
    }
    for (const char* key : {"fragments", "error", "operation", "touched_tiles"}) {
        EXPECT_EQ(one[key], count[key]) << key;
        EXPECT_EQ(cached[key], count[key]) << key;
    }
    for (const auto& [surface, bytes] : count["traffic"].items())
        for (const char* key :
             {"read_bytes", "write_bytes", "worst_case_read_bytes", "worst_case_write_bytes"})
            EXPECT_EQ(one["traffic"][surface][key], bytes[key]) << surface;
}

TEST_P(TimedTechnique, EveryCycleAndByteIsAccountedFor) {
    RandomFragments options;
    options.width = 70;
    options.height = 50;
    options.count = 20000;
    options.opaque = true;
    const std::string trace = write(random_header(options), random_fragments(options));
    const Settings small = {"cache.kibibytes=4", "cache.fast_clear=false", "rop.partitions=3",
                            "clock.shader_mhz=1100"};
    const std::uint64_t burst = configured(small).dram.burst_bytes();
    const json timed = run(trace, GetParam(), small);
    expect_every_cycle_labelled(timed);
    expect_bytes_add_up(timed, burst);
    expect_bytes_add_up(run(trace, GetParam(), small, {"--fidelity", "cached"}), burst);
    // 1e12 / 1500 MHz, rounded to whole picoseconds.
    EXPECT_NEAR(timed["seconds"].get<double>(), timed["cycles"].get<double>() * 667e-12, 1e-15);
}

// The cached machine sees the same accesses in the same order; only what is in flight differs: fetches that
// run ahead of the write that would have made them unnecessary, lines held by quads in flight (up to 32 of
// them) that replacement must pass over, reads that the write queue answers. Each concerns a few lines around
// a miss: on coherent layers the pins agree within 1% (measured: 0.004% at most).
TEST_P(TimedTechnique, CachedPinsAreCloseToTimedPins) {
    LayeredScene scene;
    scene.width = 320;
    scene.height = 180;
    scene.layers = 6;
    const std::string trace = write_layers(scene);
    const json timed = run(trace, GetParam(), {}, {}, "timed");
    const json cached = run(trace, GetParam(), {}, {"--fidelity", "cached"}, "cached");
    const auto pins = [](const json& run) {
        return run["dram"]["read_bytes"].get<double>() + run["dram"]["write_bytes"].get<double>();
    };
    std::printf("%s: cached %.0f bytes, timed %.0f (%+.2f%%); cycles %.0f of %.0f\n", GetParam().c_str(),
                pins(cached), pins(timed), 100 * (pins(cached) / pins(timed) - 1),
                cached["cycles"].get<double>(), timed["cycles"].get<double>());
    EXPECT_NEAR(pins(cached) / pins(timed), 1.0, 0.01);
    // A bottleneck is a lower bound of the time: nothing overlaps better than perfectly.
    EXPECT_LE(cached["cycles"].get<double>(), timed["cycles"].get<double>() * 1.02);
}

INSTANTIATE_TEST_SUITE_P(Techniques, TimedTechnique, ::testing::ValuesIn(technique_names()),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace ropsim
