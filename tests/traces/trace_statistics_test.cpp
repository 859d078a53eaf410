// Statistics of traces made by hand, and the generators' promises.
#include "traces/trace_statistics.h"

#include "tests/traces/scratch.h"
#include "traces/generators.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using ::testing::ElementsAre;

using Statistics = ScratchTest;

Fragment at(int x, int y, float z, float a, int draw = 0) {
    return {z,
            0,
            0,
            0,
            a,
            static_cast<std::uint16_t>(x),
            static_cast<std::uint16_t>(y),
            0,
            1,
            static_cast<std::uint16_t>(draw)};
}

TEST_F(Statistics, HandMadeTrace) {
    TraceHeader header;
    header.width = 3;
    header.height = 2;
    header.draws.resize(2);
    header.draws[1].depth_test = false;
    header.opaque.emplace();
    header.opaque->rgb.resize(18);
    const float none = std::numeric_limits<float>::infinity();
    header.opaque->depth = {0.5f, none, none, none, none, none};
    std::vector<Fragment> fragments{at(0, 0, 0.4f, 0.0f),     at(0, 0, 0.5f, 1.0f),  at(0, 0, 0.6f, 0.25f),
                                    at(0, 0, 0.9f, 0.25f, 1), at(2, 1, 0.9f, 0.95f), at(1, 0, 1.0f, 0.05f)};
    fragments[1].primitive = fragments[4].primitive = kBackFacing | 3;
    write_trace(path("t"), header, fragments);
    TraceReader reader(path("t"));
    const TraceStatistics s = measure_trace(reader);
    EXPECT_EQ(s.fragments, 6u);
    EXPECT_THAT(s.all.histogram, ElementsAre(3, 2, 0, 0, 1));
    EXPECT_EQ(s.all.max, 4u);
    EXPECT_EQ(s.all.covered_pixels, 3u);
    EXPECT_DOUBLE_EQ(*s.all.mean, 2.0);
    // At pixel (0, 0): z = 0.5 is not in front of 0.5, nor is 0.6; draw 1 is not tested.
    EXPECT_EQ(s.hidden_by_opaque, 2u);
    EXPECT_THAT(s.visible.histogram, ElementsAre(3, 2, 1));
    EXPECT_DOUBLE_EQ(*s.visible.mean, 4.0 / 3.0);
    EXPECT_THAT(s.alpha_histogram, ElementsAre(2, 0, 2, 0, 0, 0, 0, 0, 0, 2));
    EXPECT_NEAR(*s.alpha_mean, 2.5 / 6, 1e-7);
    EXPECT_EQ(s.facing_back, 2u);
    EXPECT_EQ(s.zero_alpha, 1u);
    EXPECT_EQ(s.full_alpha, 1u);
    EXPECT_THAT(s.draw_fragments, ElementsAre(5, 1));
}

// Two samples, at (+-1/4, +-1/4) of a pixel, with an opaque layer that covers only one of them.
TEST_F(Statistics, HiddenIsDecidedAtEachCoveredSample) {
    TraceHeader header;
    header.width = 2;
    header.height = 1;
    header.samples = 2;
    header.depth_slopes = true;
    header.draws.resize(1);
    header.opaque.emplace();
    header.opaque->rgb.resize(12);
    const float none = std::numeric_limits<float>::infinity();
    header.opaque->depth = {0.5f, none, 0.5f, 0.5f};
    FragmentChunk content;
    const auto add = [&](int x, float z, unsigned coverage, DepthSlope slope) {
        content.fragments.push_back(at(x, 0, z, 0.5f));
        content.fragments.back().coverage = static_cast<std::uint16_t>(coverage);
        content.slopes.push_back(slope);
    };
    add(0, 0.6f, 1, {});               // behind at the only sample it covers
    add(0, 0.6f, 3, {});               // nothing opaque at its second
    add(0, 0.6f, 2, {});               // in front
    add(1, 0.6f, 3, {});               // behind at both
    add(1, 0.55f, 3, {0.4f, 0});       // 0.65 and 0.45: in front at the second sample
    add(1, 0.55f, 1, {0.4f, 0});       // which this one does not cover
    add(1, 0.55f, 1, {-0.1f, -0.2f});  // 0.475
    add(1, 0.0f, 3, {9, 9});           // clamped to 1 and 0
    add(1, 0.1f, 0, {});               // covers nothing
    TraceWriter writer(path("t"), header);
    writer.append(content);
    writer.finish();
    TraceReader reader(path("t"));
    PixelLayers layers;
    const TraceStatistics s = measure_trace(reader, &layers);
    EXPECT_EQ(s.hidden_by_opaque, 3u);
    EXPECT_THAT(layers.all, ElementsAre(3, 6));
    EXPECT_THAT(layers.visible, ElementsAre(2, 3));
    ASSERT_TRUE(s.slopes);
    EXPECT_EQ(s.slopes->sloped, 4u);
    EXPECT_EQ(s.slopes->steepest, 9.0f);
    EXPECT_FALSE(s.materials || s.unusual);
}

// The second of four samples lies 6/16 to the right and 2/16 up: y points down.
TEST_F(Statistics, SlopesFollowTheSamplePositions) {
    TraceHeader header;
    header.width = header.height = 1;
    header.samples = 4;
    header.depth_slopes = true;
    header.draws.resize(1);
    header.opaque.emplace();
    header.opaque->rgb.resize(12);
    header.opaque->depth.assign(4, 0.5f);
    FragmentChunk content;
    content.fragments.assign(4, at(0, 0, 0.5f, 0.5f));
    for (Fragment& f : content.fragments) f.coverage = 2;
    // 0.5375 twice, 0.525 and 0.4875.
    content.slopes = {{0.1f, 0}, {0.1f, 0}, {0.1f, 0.1f}, {0, 0.1f}};
    TraceWriter writer(path("t"), header);
    writer.append(content);
    writer.finish();
    TraceReader reader(path("t"));
    EXPECT_EQ(measure_trace(reader).hidden_by_opaque, 3u);
}

TEST_F(Statistics, MaterialsAreCountedByWhatTheyDo) {
    TraceHeader header;
    header.width = header.height = 1;
    header.materials = true;
    header.draws.resize(1);
    FragmentChunk content;
    content.fragments.assign(4, at(0, 0, 0.5f, 0.5f));
    content.materials.resize(4);
    content.materials[0].transmission[2] = 0.1f;
    content.materials[1].collimation = 0.9f;
    content.materials[1].eta = 1.5f;
    content.materials[2].eta = 0.9f;
    TraceWriter writer(path("t"), header);
    writer.append(content);
    writer.finish();
    TraceReader reader(path("t"));
    const TraceStatistics s = measure_trace(reader);
    ASSERT_TRUE(s.materials);
    EXPECT_EQ(s.materials->transmissive, 1u);
    EXPECT_EQ(s.materials->scattering, 1u);
    EXPECT_EQ(s.materials->refractive, 2u);
}

TEST_F(Statistics, EmptyTraceHasNoMeans) {
    TraceHeader header;
    header.width = 4;
    header.height = 4;
    write_trace(path("t"), header, {});
    TraceReader reader(path("t"));
    const TraceStatistics s = measure_trace(reader);
    EXPECT_FALSE(s.all.mean);
    EXPECT_FALSE(s.alpha_mean);
    EXPECT_THAT(s.all.histogram, ElementsAre(16));
}

TEST_F(Statistics, ReaderIsLeftAtTheStart) {
    write_trace(path("t"), random_header({}), random_fragments({}));
    TraceReader reader(path("t"));
    measure_trace(reader);
    std::vector<Fragment> chunk;
    ASSERT_TRUE(reader.next(chunk));
    EXPECT_EQ(chunk.size(), 10000u);
    EXPECT_EQ(chunk[0].primitive, 0u);
}

TEST(RandomFragments, KeepTheirRanges) {
    RandomFragments options;
    options.width = 17;
    options.height = 5;
    options.samples = 4;
    options.partial_coverage = true;
    options.alpha_low = 0.25f;
    options.alpha_high = 0.75f;
    options.depth_levels = 4;
    options.draws = 3;
    std::vector<int> pixels(std::size_t{17} * 5), masks(16), draws(3), depths(4);
    for (const Fragment& f : random_fragments(options)) {
        ++pixels[static_cast<std::size_t>(f.y) * 17 + f.x];
        ++masks[f.coverage];
        ++draws[f.draw];
        ++depths[static_cast<std::size_t>(f.z * 4)];
        ASSERT_EQ(f.z, (std::floor(f.z * 4) + 0.5f) / 4);
        ASSERT_TRUE(f.a >= 0.25f && f.a <= 0.75f && f.r <= f.a && f.g <= f.a && f.b <= f.a);
    }
    EXPECT_EQ(masks[0], 0);
    // 10000 draws over n equal cells: six standard deviations of a binomial count.
    const auto uniform = [](const std::vector<int>& counts, std::size_t first, double cells) {
        for (std::size_t i = first; i < counts.size(); ++i)
            EXPECT_NEAR(counts[i], 10000 / cells, 6 * std::sqrt(10000 / cells * (1 - 1 / cells)));
    };
    uniform(pixels, 0, 85);
    uniform(masks, 1, 15);
    uniform(draws, 0, 3);
    uniform(depths, 0, 4);
}

TEST(RandomFragments, OrdersAreSortedStablyAndHoldTheSameFragments) {
    RandomFragments options;
    options.depth_levels = 10;
    const std::vector<Fragment> shuffled = random_fragments(options);
    options.order = RandomFragments::Order::kBackToFront;
    std::vector<Fragment> sorted = random_fragments(options);
    for (std::size_t i = 1; i < sorted.size(); ++i) {
        ASSERT_GE(sorted[i - 1].z, sorted[i].z);
        ASSERT_TRUE(sorted[i - 1].z > sorted[i].z || sorted[i - 1].primitive < sorted[i].primitive);
    }
    std::sort(sorted.begin(), sorted.end(),
              [](const auto& a, const auto& b) { return a.primitive < b.primitive; });
    for (std::size_t i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i].z, shuffled[i].z);
}

TEST_F(Statistics, LayeredSceneCoversEveryPixelOnceALayer) {
    LayeredScene options;
    options.width = 101;
    options.height = 67;
    options.layers = 3;
    TraceWriter writer(path("t"), layered_header(options));
    append_layered(options, writer);
    writer.finish();
    TraceReader reader(path("t"));
    const TraceStatistics s = measure_trace(reader);
    EXPECT_THAT(s.all.histogram, ElementsAre(0, 0, 0, 101 * 67));
    EXPECT_THAT(s.draw_fragments, ElementsAre(101 * 67, 101 * 67, 101 * 67));
}

}  // namespace
}  // namespace ropsim
