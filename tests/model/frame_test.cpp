// The functional frame: images, counts and uncached bytes against hand counts, a plain compositor and each
// other.
#include "base/random.h"
#include "tests/model/machine_driver.h"

#include <cstring>

namespace ropsim {
namespace {

bool same(const QuadOperation& a, const QuadOperation& b) {
    return a.quad_id == b.quad_id && a.first_line == b.first_line && a.line_count == b.line_count &&
           a.interval == b.interval && a.latency == b.latency &&
           a.shader_lane_cycles == b.shader_lane_cycles && a.partition == b.partition && a.kind == b.kind &&
           a.pixels == b.pixels;
}
bool same(const LineAccess& a, const LineAccess& b) {
    return a.line_address == b.line_address && a.read_sectors == b.read_sectors && a.surface == b.surface &&
           a.write_bytes == b.write_bytes;
}
template <class T>
bool all_same(const std::vector<T>& a, const std::vector<T>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const T& x, const T& y) { return same(x, y); });
}
bool same_bits(const Image& a, const Image& b) {
    return a.width == b.width && a.height == b.height && a.values.size() == b.values.size() &&
           std::memcmp(a.values.data(), b.values.data(), a.values.size() * sizeof(float)) == 0;
}

class EveryTechnique : public ModelTest, public ::testing::WithParamInterface<std::string> {
 protected:
    RandomFragments options() const {
        RandomFragments o;
        o.seed = 11;
        o.width = 67;  // tiles cut off on both sides
        o.height = 45;
        o.count = 70000;  // several batches where quads are kept
        o.depth_levels = 500;
        o.alpha_high = 0.6f;
        o.draws = 3;
        o.opaque = true;
        return o;
    }
};

TEST_P(EveryTechnique, ImageDoesNotDependOnThreadsBatchesOrPartitions) {
    const std::string trace = write(random_header(options()), random_fragments(options()));
    const MachineConfig config = configured({"rop.partitions=5"});
    const FrameResult one = run_frame(trace, GetParam(), config, 1, false, 3);
    EXPECT_EQ(one.counts.input, 70000u);
    for (const int threads : {1, 2}) {
        for (const bool quads : {false, true}) {
            const FrameResult other = run_frame(trace, GetParam(), config, threads, quads, 3);
            EXPECT_TRUE(same_bits(one.image, other.image)) << threads << " threads, quads " << quads;
            EXPECT_EQ(one.paths, other.paths);
        }
    }
    EXPECT_TRUE(same_bits(one.image,
                          run_frame(trace, GetParam(), configured({"rop.partitions=1"}), 2, true, 3).image));
    // The same trace cut into small chunks.
    TraceWriter writer(path("pieces"), random_header(options()), {777, 16});
    writer.append(random_fragments(options()));
    writer.finish();
    EXPECT_TRUE(same_bits(one.image, run_frame(path("pieces"), GetParam(), config, 2, true, 3).image));
}

TEST_P(EveryTechnique, QuadsDoNotDependOnThreads) {
    const std::string trace = write(random_header(options()), random_fragments(options()));
    const MachineConfig config = configured({"rop.partitions=3", "cache.fast_clear=false"});
    const FrameResult one = run_frame(trace, GetParam(), config, 1, true);
    const FrameResult two = run_frame(trace, GetParam(), config, 2, true);
    EXPECT_GE(one.quads.size(), 70000u);  // no two fragments share one
    EXPECT_TRUE(all_same(one.quads, two.quads));
    for (std::size_t p = 0; p < 3; ++p) EXPECT_TRUE(all_same(one.lines[p], two.lines[p])) << p;
}

// Sum over quads of bytes written by the lines, where no two writes of one quad meet: the counted bytes.
TEST_P(EveryTechnique, TouchedBytesAreAtMostTheWorstCase) {
    const std::string trace = write(random_header(options()), random_fragments(options()));
    for (const char* clear : {"cache.fast_clear=true", "cache.fast_clear=false"}) {
        const FrameResult frame = run_frame(trace, GetParam(), configured({clear}), 2, false);
        std::uint64_t bytes = 0;
        for (std::size_t s = 0; s < frame.traffic.size(); ++s) {
            EXPECT_LE(frame.traffic[s].read, frame.traffic[s].worst_read) << frame.surfaces[s];
            EXPECT_LE(frame.traffic[s].write, frame.traffic[s].worst_write) << frame.surfaces[s];
            bytes += frame.traffic[s].read + frame.traffic[s].write;
        }
        EXPECT_GT(bytes, 70000u);
    }
}

INSTANTIATE_TEST_SUITE_P(Techniques, EveryTechnique, ::testing::ValuesIn(technique_names()),
                         [](const auto& test) { return test.param; });

using FrameTest = ModelTest;

// "Over" in arrival order with the depth test, in float, as one would write it down.
TEST_F(FrameTest, AlphaBlendIsThePlainCompositorBitForBit) {
    RandomFragments options;
    options.width = 50;
    options.height = 30;
    options.count = 20000;
    options.opaque = true;
    options.depth_levels = 100;
    TraceHeader header = random_header(options);
    header.draws.resize(2);
    header.draws[1].depth_test = false;
    std::vector<Fragment> fragments = random_fragments(options);
    for (std::size_t i = 0; i < fragments.size(); i += 3) fragments[i].draw = 1;
    std::vector<float> rgb = header.opaque->rgb;
    std::uint64_t culled = 0;
    for (const Fragment& f : fragments) {
        const std::size_t at = static_cast<std::size_t>(f.y) * 50 + f.x;
        if (f.draw == 0 && !(f.z < header.opaque->depth[at])) {
            ++culled;
            continue;
        }
        const float t = 1.0f - f.a;
        rgb[3 * at] = f.r + t * rgb[3 * at];
        rgb[3 * at + 1] = f.g + t * rgb[3 * at + 1];
        rgb[3 * at + 2] = f.b + t * rgb[3 * at + 2];
    }
    const FrameResult frame =
        run_frame(write(header, fragments), "alpha_blend:format=float32", configured(), 2, false);
    EXPECT_GT(culled, 1000u);
    EXPECT_EQ(frame.counts.depth_culled, culled);
    ASSERT_EQ(frame.image.values.size(), rgb.size());
    EXPECT_EQ(std::memcmp(frame.image.values.data(), rgb.data(), rgb.size() * sizeof(float)), 0);
}

TEST_F(FrameTest, UntouchedTilesKeepTheOpaqueLayerAndAreNeverAllocated) {
    TraceHeader header = plain_header(64, 64);
    header.opaque.emplace();
    for (std::size_t i = 0; i < 64 * 64; ++i) {
        for (std::size_t c = 0; c < 3; ++c)
            header.opaque->rgb.push_back(random_unit(i, static_cast<std::uint32_t>(c)));
        header.opaque->depth.push_back(0.5f);
    }
    const std::string trace = write(
        header, {fragment_at(20, 30, 0.25f, 0), fragment_at(50, 50, 0.75f, 1)});  // the second is behind
    for (const std::string& technique : technique_names()) {
        const FrameResult frame = run_frame(trace, technique + ":format=float32", configured(), 1, true);
        EXPECT_EQ(frame.touched_tiles, 1u) << technique;
        for (int y = 0; y < 64; ++y) {
            for (int x = 0; x < 64; ++x) {
                if (x / 8 == 20 / 8 && y / 8 == 30 / 8) continue;
                for (std::size_t c = 0; c < 3; ++c)
                    ASSERT_EQ(
                        frame.image.pixel(x, y)[c],
                        header.opaque
                            ->rgb[3 * (static_cast<std::size_t>(y) * 64 + static_cast<std::size_t>(x)) + c])
                        << technique << " " << x << "," << y;
            }
        }
        for (const QuadOperation& q : frame.quads) {
            EXPECT_TRUE(q.kind != QuadKind::kResolve || q.quad_id / 16 == 30u / 8 * 8 + 20 / 8) << technique;
        }
    }
}

// Each partition keeps the first fragments that its share holds: the image is that of a trace without the
// others.
TEST_F(FrameTest, PoolOverflowFollowsTraceOrderAndNotThreads) {
    RandomFragments options;
    options.width = 64;
    options.height = 64;
    options.count = 5000;
    const std::vector<Fragment> fragments = random_fragments(options);
    const TraceHeader header = random_header(options);
    const std::string trace = write(header, fragments);
    MachineConfig small = configured({"rop.partitions=3"});
    constexpr std::uint64_t kNodes = 1000;
    constexpr std::uint64_t kNodeBytes = 4 + 4 + 4;  // colour, depth, next
    small.pool_bytes = 3 * kNodes * kNodeBytes;

    const auto operation = operation_for("a_buffer", header);
    const SurfaceMap map(operation->declaration(), small, header);
    ASSERT_EQ(map.pool_nodes(), kNodes);
    std::vector<Fragment> kept;
    std::vector<std::uint64_t> used(3);
    for (const Fragment& f : fragments)
        if (used[static_cast<std::size_t>(
                map.partition_of(static_cast<std::size_t>(f.y / 8 * 8 + f.x / 8)))]++ < kNodes)
            kept.push_back(f);
    ASSERT_LT(kept.size(), fragments.size());

    const FrameResult one = run_frame(trace, "a_buffer", small, 1, false);
    const FrameResult two = run_frame(trace, "a_buffer", small, 2, true);
    EXPECT_EQ(one.pool_overflowed, fragments.size() - kept.size());
    EXPECT_EQ(one.pool_used, kept.size());
    EXPECT_EQ(one.paths[1], one.pool_overflowed);  // path "overflow"
    EXPECT_EQ(two.pool_overflowed, one.pool_overflowed);
    EXPECT_EQ(two.pool_used, one.pool_used);
    EXPECT_TRUE(same_bits(one.image, two.image));
    EXPECT_TRUE(same_bits(one.image,
                          run_frame(write(header, kept, "kept"), "a_buffer", configured(), 1, false).image));
    EXPECT_EQ(one.surface("nodes").write, kept.size() * kNodeBytes);
}

TEST_F(FrameTest, AnEmptyTraceIsTheBackground) {
    const std::string trace = write(plain_header(20, 10), {});
    for (const std::string& technique : technique_names()) {
        const FrameResult frame = run_frame(trace, technique, configured(), 2, true);
        EXPECT_TRUE(frame.quads.empty()) << technique;
        EXPECT_EQ(frame.image.pixel(19, 9)[2], 0.75f);
    }
}

}  // namespace
}  // namespace ropsim
