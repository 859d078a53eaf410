// Caches of many sizes at once against runs with one cache each, and against what the frame touches.
#include "model/cache_sweep.h"

#include "model/cached_machine.h"
#include "tests/model/machine_driver.h"

namespace ropsim {
namespace {

class CacheSweepTest : public ModelTest {
 protected:
    CacheSweep swept(const std::string& trace_path, const std::string& technique,
                     const std::vector<std::uint32_t>& sizes, const Settings& settings = {},
                     int threads = 2) {
        TraceReader trace(trace_path);
        std::vector<MachineConfig> configs;
        for (const std::uint32_t size : sizes) {
            Settings one = settings;
            one.push_back(fmt::format("cache.kibibytes={}", size / 1024));
            configs.push_back(configured(one));
        }
        const auto operation = operation_for(technique, trace.header());
        Frame frame(trace, *operation, configs.front(), threads, true);
        return sweep_cache_sizes(frame, configs, threads);
    }
    MachineResult machine(const std::string& trace_path, const std::string& technique, MachineConfig config) {
        TraceReader trace(trace_path);
        const auto operation = operation_for(technique, trace.header());
        Frame frame(trace, *operation, config, 1, true);
        return run_cached_machine(frame, config, 1);
    }
    std::string layers() {
        LayeredScene scene;
        scene.width = scene.height = 200;
        scene.layers = 6;
        return write_layers(scene);
    }
};

void expect_equal(const BytesByCause& a, const BytesByCause& b, const std::string& what) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t s = 0; s < a.size(); ++s) {
        for (std::size_t c = 0; c < kMemoryCauses; ++c) {
            EXPECT_EQ(a[s][c].read, b[s][c].read) << what << " surface " << s << " cause " << c;
            EXPECT_EQ(a[s][c].write, b[s][c].write) << what << " surface " << s << " cause " << c;
        }
    }
}

ReadWriteBytes total(const std::vector<ReadWriteBytes>& surfaces) {
    ReadWriteBytes sum;
    for (const ReadWriteBytes& one : surfaces) {
        sum.read += one.read;
        sum.write += one.write;
    }
    return sum;
}

ReadWriteBytes total(const BytesByCause& surfaces) {
    ReadWriteBytes sum;
    for (const auto& causes : surfaces) {
        for (const CauseBytes& one : causes) {
            sum.read += one.read;
            sum.write += one.write;
        }
    }
    return sum;
}

TEST_F(CacheSweepTest, EachSizeIsThatOfARunWithIt) {
    const std::string trace = layers();
    // The second: bursts of 64 bytes over sectors of 32, which pads. The third: halves for depth and colour.
    for (const Settings& settings :
         {Settings{}, Settings{"dram.device=gddr5x"}, Settings{"cache.organisation=separate"}}) {
        for (const std::string technique : {"adaptive:nodes=8", "a_buffer", "stochastic:samples=4"}) {
            const std::vector<std::uint32_t> sizes{2048, 12288, 65536};
            const CacheSweep sweep = swept(trace, technique, sizes, settings);
            ASSERT_EQ(sweep.caches.size(), sizes.size());
            for (std::size_t i = 0; i < sizes.size(); ++i) {
                Settings its = settings;
                its.push_back(fmt::format("cache.kibibytes={}", sizes[i] / 1024));
                const MachineResult one = machine(trace, technique, configured(its));
                const std::string what = fmt::format("{} {} bytes", technique, sizes[i]);
                expect_equal(sweep.caches[i].miss_port, one.miss_port, what);
                expect_equal(sweep.caches[i].pins, one.pins, what);
                EXPECT_EQ(sweep.caches[i].cache.sector_hits, one.cache.sector_hits) << what;
                EXPECT_EQ(sweep.caches[i].cache.line_evictions, one.cache.line_evictions) << what;
            }
        }
    }
}

// A cache of one set is the ideal one.
TEST_F(CacheSweepTest, IdealIsACacheOfOneSet) {
    const std::string trace = layers();
    MachineConfig config = configured({"cache.ways=64"});
    config.cache.size_bytes = 64 * config.cache.line_bytes;
    const MachineResult one = machine(trace, "adaptive:nodes=4", config);
    const CacheSweep sweep = swept(trace, "adaptive:nodes=4", {config.cache.size_bytes});
    const auto ideal = std::find_if(sweep.ideal.begin(), sweep.ideal.end(), [&](const IdealCache& cache) {
        return cache.size_bytes == config.cache.size_bytes;
    });
    ASSERT_NE(ideal, sweep.ideal.end());
    for (std::size_t s = 0; s < one.miss_port.size(); ++s) {
        const ReadWriteBytes expected = total(BytesByCause{one.miss_port[s]});
        EXPECT_EQ(ideal->surfaces[s].read, expected.read) << s;
        EXPECT_EQ(ideal->surfaces[s].write, expected.write) << s;
    }
    // With four ways, the same size moves other bytes: there are conflicts.
    EXPECT_NE(total(sweep.caches[0].miss_port).sum(), total(ideal->surfaces).sum());
    for (std::size_t i = 1; i < sweep.ideal.size(); ++i)
        EXPECT_LE(total(sweep.ideal[i].surfaces).sum(), total(sweep.ideal[i - 1].surfaces).sum());
}

// Fragments 16 pixels apart share no quad, line or sector.
TEST_F(CacheSweepTest, ScatteredFragmentsByHand) {
    TraceHeader header = plain_header(128, 128);
    std::vector<Fragment> fragments;
    for (int pass = 0; pass < 2; ++pass)
        for (int i = 0; i < 64; ++i)
            fragments.push_back(
                fragment_at(16 * (i % 8), 16 * (i / 8), 0.5f, static_cast<std::uint32_t>(64 * pass + i)));
    const std::string trace = write(header, fragments);
    // One pixel of float16 colour, 8 bytes, in place: the target starts as the background, a constant.
    const CacheSweep sweep = swept(trace, "alpha_blend", {1024, 65536, 131072}, {"rop.partitions=1"});
    const ReadWriteBytes none = total(sweep.uncached);
    EXPECT_EQ(none.read, 128u * 32);
    EXPECT_EQ(none.write, 128u * 32);
    // 64 lines do not fit into 8: each is written back twice, and read the second time.
    EXPECT_EQ(total(sweep.caches[0].pins).read, 64u * 32);
    EXPECT_EQ(total(sweep.caches[0].pins).write, 2 * 64u * 32);
    // Nor into 512 of 4 ways: a tile has 4 lines, a row of tiles 64, so that every second tile of every
    // second row falls into 8 of the 128 sets; of twice as many it falls into 16, which hold 64 lines.
    EXPECT_EQ(total(sweep.caches[1].pins).sum(), total(sweep.caches[0].pins).sum());
    EXPECT_EQ(total(sweep.caches[2].pins).read, 0u);
    EXPECT_EQ(total(sweep.caches[2].pins).write, 64u * 32);
    // Without sets, 64 lines are enough.
    for (const IdealCache& ideal : sweep.ideal) {
        const bool fits = ideal.size_bytes == 0 || ideal.size_bytes >= 64 * 128;
        EXPECT_EQ(total(ideal.surfaces).sum(), (fits ? 1u : 3u) * 64 * 32) << ideal.size_bytes;
        EXPECT_DOUBLE_EQ(ideal.line_hit_share, fits ? 0.5 : 0.0) << ideal.size_bytes;
    }
    EXPECT_EQ(sweep.line_uses, 128u);
    EXPECT_EQ(sweep.largest_footprint, 64u * 128);
}

TEST_F(CacheSweepTest, DoesNotDependOnThreads) {
    const std::string trace = layers();
    const CacheSweep a = swept(trace, "slab", {8192}, {}, 1);
    const CacheSweep b = swept(trace, "slab", {8192}, {}, 4);
    expect_equal(a.caches[0].pins, b.caches[0].pins, "threads");
    for (std::size_t i = 0; i < a.ideal.size(); ++i)
        EXPECT_EQ(total(a.ideal[i].surfaces).sum(), total(b.ideal[i].surfaces).sum());
}

}  // namespace
}  // namespace ropsim
