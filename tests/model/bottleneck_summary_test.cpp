// Machines with one narrow place: the summary names it, from counters that show it.
#include "tests/model/machine_driver.h"

namespace ropsim {
namespace {

using nlohmann::json;

class BottleneckSummary : public ModelTest {
 protected:
    // Shares add up to 1 and fall; the first one is the answer in one line. Returns it.
    json first(const json& run) const {
        double sum = 0;
        double before = 1;
        for (const json& cause : run["bottlenecks"]) {
            sum += cause["share"].get<double>();
            EXPECT_LE(cause["share"].get<double>(), before);
            before = cause["share"].get<double>();
            std::printf("  %s: %s\n", cause["cause"].get<std::string>().c_str(),
                        cause["text"].get<std::string>().c_str());
        }
        EXPECT_NEAR(sum, 1.0, 1e-9);
        EXPECT_EQ(run["bottleneck"], run["bottlenecks"][0]["text"]);
        return run["bottlenecks"][0];
    }
    void expect(const json& run, const std::string& cause, const std::string& says) const {
        const json found = first(run);
        EXPECT_EQ(found["cause"], cause);
        EXPECT_NE(found["text"].get<std::string>().find(says), std::string::npos) << found["text"] << "\n"
                                                                                  << says;
        EXPECT_GT(found["share"].get<double>(), 0.5);
    }
    // Single pixels, quad after quad over an image of 2n x 2n, again and again.
    std::string sweep(int n, int count) const {
        std::vector<Fragment> fragments;
        for (int i = 0; i < count; ++i)
            fragments.push_back(fragment_at(i % n * 2, i / n % n * 2, 0.5f, static_cast<std::uint32_t>(i)));
        return write(plain_header(2 * n, 2 * n), fragments);
    }
};

TEST_F(BottleneckSummary, OperationUnits) {
    expect(run(sweep(16, 20000), "alpha_blend",
               {"rop.partitions=1", "rop.lanes=1", "rop.multipliers=1", "cache.kibibytes=64"}),
           "operation", "20000 quads of 4.00 cycles");
}

TEST_F(BottleneckSummary, ShaderAlus) {
    expect(run(sweep(64, 10000), "alpha_blend", {"shader.alu_lanes=8", "rop.partitions=2"}), "shading",
           "shader.alu_lanes = 8");
}

TEST_F(BottleneckSummary, Export) {
    expect(run(sweep(64, 40000), "alpha_blend",
               {"rop.partitions=4", "rop.partition_tiles=1", "shader.export_quads_per_cycle=1",
                "cache.kibibytes=64", "rop.rate.bits_64=1"}),
           "export", "shader.export_quads_per_cycle = 1");
}

TEST_F(BottleneckSummary, Rasteriser) {
    expect(run(sweep(64, 40000), "alpha_blend",
               {"rop.partitions=4", "clock.shader_mhz=250", "shader.raster_quads_per_cycle=2",
                "cache.kibibytes=64"}),
           "raster", "shader.raster_quads_per_cycle = 2");
}

TEST_F(BottleneckSummary, OnePixel) {
    std::vector<Fragment> fragments;
    for (int i = 0; i < 6000; ++i)
        fragments.push_back(fragment_at(3, 3, 0.5f, static_cast<std::uint32_t>(i)));
    expect(run(write(plain_header(8, 8), fragments), "alpha_blend", {"rop.partitions=1"}), "interlock",
           "rop.interlock = quad");
}

// Every quad's line is missing, and its place in memory is far from the last one's.
TEST_F(BottleneckSummary, OneMissRegister) {
    const Settings settings = {"rop.partitions=1", "cache.kibibytes=1", "cache.fast_clear=false",
                               "cache.mshrs=1"};
    const std::string trace = sweep(64, 20000);
    const json one = run(trace, "alpha_blend", settings);
    const json found = first(one);
    EXPECT_TRUE(found["cause"] == "fill.color" || found["cause"] == "tags.mshrs_full");
    EXPECT_NE(found["text"].get<std::string>().find("1 miss register"), std::string::npos) << found["text"];
    // Without them it is as the sentence says.
    Settings many = settings;
    many.back() = "cache.mshrs=16";
    EXPECT_LT(run(trace, "alpha_blend", many)["cycles"].get<double>(), 0.5 * one["cycles"].get<double>());
}

TEST_F(BottleneckSummary, NarrowMemory) {
    expect(run(sweep(64, 20000), "alpha_blend",
               {"rop.partitions=1", "cache.kibibytes=1", "cache.fast_clear=false", "dram.tck_ps=16000",
                "dram.trefi=0"}),
           "fill.color", "DRAM bandwidth");
}

// A working set of a little more than the cache, used in turns: LRU keeps nothing of it.
TEST_F(BottleneckSummary, ALargerCacheWouldHoldTheWorkingSet) {
    const Settings settings = {"rop.partitions=1", "cache.fast_clear=false", "cache.ways=16"};
    Settings small = settings;
    small.emplace_back("cache.kibibytes=4");
    Settings large = settings;
    large.emplace_back("cache.kibibytes=8");
    const std::string trace = sweep(13, 20000);
    const json narrow = run(trace, "alpha_blend", small);
    const std::string text = first(narrow)["text"].get<std::string>();
    const std::size_t at = text.find(" KiB more ROP cache a partition would hold ");
    ASSERT_NE(at, std::string::npos) << text;
    EXPECT_LE(text[at - 1], '4');
    const auto read = [](const json& r) { return r["dram"]["read_bytes"].get<double>(); };
    const json wide = run(trace, "alpha_blend", large);
    EXPECT_LT(read(wide), 0.1 * read(narrow));
    EXPECT_EQ(first(wide)["text"].get<std::string>().find("more ROP cache"), std::string::npos);
}

}  // namespace
}  // namespace ropsim
