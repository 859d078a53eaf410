// Each stress trace reads back and is what it is for.
#include "traces/stress_traces.h"

#include "base/atomic_file.h"
#include "base/error.h"
#include "tests/traces/trace_conversion.h"
#include "traces/trace_statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using ::testing::ElementsAre;

class Stress : public ScratchTest {
 protected:
    TraceStatistics made(const std::string& name) {
        write_stress_trace(name, path(name));
        content_ = read_raw(path(name));
        TraceReader reader(path(name));
        return measure_trace(reader);
    }
    FragmentChunk content_;
};

TEST_F(Stress, ListIsCompleteAndEachIsDeterministic) {
    EXPECT_GE(stress_traces().size(), 10u);
    for (const StressTrace& stress : stress_traces()) {
        write_stress_trace(stress.name, path("a"), 7);
        write_stress_trace(stress.name, path("b"), 7);
        EXPECT_EQ(read_file(path("a")), read_file(path("b"))) << stress.name;
        write_stress_trace(stress.name, path("b"), 8);
        EXPECT_NE(hash_of(path("a")), hash_of(path("b"))) << stress.name;
    }
    EXPECT_THROW(write_stress_trace("calm", path("c")), UserError);
}

TEST_F(Stress, Coplanar) {
    const TraceStatistics s = made("coplanar");
    EXPECT_EQ(s.all.max, 12u);
    EXPECT_EQ(s.all.histogram[12], 64u * 64);
    for (const Fragment& f : content_.fragments) ASSERT_EQ(f.z, 0.5f);
    EXPECT_EQ(s.draw_fragments.size(), 3u);
}

TEST_F(Stress, DeepPixel) {
    const TraceStatistics s = made("deep_pixel");
    EXPECT_EQ(s.all.max, 10000u);
    EXPECT_EQ(s.all.histogram[1], 255u);
}

TEST_F(Stress, OpaqueTail) {
    const TraceStatistics s = made("opaque_tail");
    EXPECT_EQ(s.all.histogram[16], 32u * 32);
    EXPECT_EQ(s.full_alpha, 8u * 32 * 32);
    std::vector<float> nearest_opaque(32 * 32, 2.0f), farthest_other(32 * 32, -1.0f);
    for (const Fragment& f : content_.fragments) {
        const std::size_t pixel = static_cast<std::size_t>(f.y) * 32 + f.x;
        if (f.a == 1)
            nearest_opaque[pixel] = std::min(nearest_opaque[pixel], f.z);
        else
            farthest_other[pixel] = std::max(farthest_other[pixel], f.z);
    }
    for (std::size_t i = 0; i < nearest_opaque.size(); ++i) EXPECT_LT(farthest_other[i], nearest_opaque[i]);
}

TEST_F(Stress, ExtremeAlpha) {
    const TraceStatistics s = made("extreme_alpha");
    EXPECT_EQ(s.zero_alpha + s.full_alpha, s.fragments);
    EXPECT_GT(s.zero_alpha, s.fragments / 2);
    EXPECT_GT(s.full_alpha, s.fragments / 8);
    EXPECT_TRUE(std::any_of(content_.fragments.begin(), content_.fragments.end(),
                            [](const Fragment& f) { return f.a == 0 && f.r > 0; }));
}

TEST_F(Stress, ThinMedia) {
    const TraceStatistics s = made("thin_media");
    EXPECT_EQ(s.all.histogram[1000], 16u * 16);
    for (const Fragment& f : content_.fragments) ASSERT_EQ(f.a, 1e-4f);
}

TEST_F(Stress, DepthEnds) {
    const TraceStatistics s = made("depth_ends");
    EXPECT_EQ(s.all.histogram[10], 32u * 32);
    std::set<float> depths;
    for (const Fragment& f : content_.fragments) depths.insert(f.z);
    EXPECT_EQ(depths.size(), 10u);
    for (const float z : {0.0f, std::numeric_limits<float>::denorm_min(), std::nextafter(0.5f, 0.0f),
                          std::nextafter(0.5f, 1.0f), std::nextafter(1.0f, 0.0f), 1.0f})
        EXPECT_TRUE(depths.contains(z)) << z;
}

TEST_F(Stress, NonFinite) {
    const TraceStatistics s = made("non_finite");
    ASSERT_TRUE(s.unusual && s.slopes && s.materials);
    EXPECT_EQ(s.unusual->with_nan, 15u);  // one a channel
    EXPECT_EQ(s.unusual->with_infinity, 30u);
    EXPECT_EQ(s.unusual->out_of_range,
              6u * 3);  // -0.5, 1.5, 3e38 of z, a, three transmissions and collimation
    EXPECT_EQ(s.all.histogram[3], 15u * 7);
}

TEST_F(Stress, OneNoneAndFew) {
    EXPECT_EQ(made("single_fragment").fragments, 1u);
    EXPECT_EQ(made("empty").fragments, 0u);
    const TraceStatistics s = made("large_image");
    EXPECT_EQ(s.fragments, 128u * 128 + 4);
    EXPECT_EQ(TraceReader(path("large_image")).header().width, 8192);
    EXPECT_LE(s.all.max, 2u);
    std::set<std::pair<int, int>> corners;
    for (const Fragment& f : content_.fragments)
        if ((f.x == 0 || f.x == 8191) && (f.y == 0 || f.y == 8191)) corners.insert({f.x, f.y});
    EXPECT_EQ(corners.size(), 4u);
}

}  // namespace
}  // namespace ropsim
