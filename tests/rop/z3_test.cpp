// Z3: coverage and depth slopes kept exactly while fragments suffice, the merging of two fragments in closed
// form, and eight bits of slope.
#include "rop/nodes/small_slope.h"
#include "tests/rop/layer_lists.h"
#include "tests/rop/worst_case_bytes.h"
#include "traces/depth_test.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

enum Path : std::size_t { kInsert, kInsertMerge };

// Mask, depth, two slopes and RGBA8 of three fragments over four samples; depth and RGBA8 over one sample.
TEST(Z3, StorageFollowsFromTheBitsOfEachPart) {
    EXPECT_EQ(test::storage_bits("z3", 4), 3 * (4 + 32 + 2 * 8 + 32));
    EXPECT_EQ(test::storage_bits("z3:depth_format=unorm24", 4), 3 * (4 + 24 + 2 * 8 + 32));
    EXPECT_EQ(test::storage_bits("z3:slope_bits=16,fragments=8", 8), 8 * (8 + 32 + 2 * 16 + 32));
    EXPECT_EQ(test::storage_bits("z3", 1), 3 * (32 + 32));
    // 84 bits are kept in 11 bytes.
    const auto bytes = test::worst_case_bytes("z3", 4);
    EXPECT_EQ(bytes.read, 33u);
    EXPECT_EQ(bytes.write, 33u);
}

// Each sample composited by itself in double precision.
std::array<double, 3> exact_color(std::span<const Fragment> fragments, std::span<const DepthSlope> slopes,
                                  int samples, int x, int y, const TraceHeader& header) {
    std::array<double, 3> mean{};
    for (int m = 0; m < samples; ++m) {
        std::vector<Fragment> there;
        for (std::size_t i = 0; i < fragments.size(); ++i) {
            Fragment f = fragments[i];
            if (f.x != x || f.y != y || ((f.coverage >> m) & 1) == 0) continue;
            if (samples > 1) {
                const SamplePosition at = sample_positions(samples)[static_cast<std::size_t>(m)];
                f.z += slopes[i].dx * at.x() + slopes[i].dy * at.y();
            }
            there.push_back(f);
        }
        const auto color = test::composited(there, x, y, test::background_of(header, x, y));
        for (std::size_t c = 0; c < 3; ++c) mean[c] += color[c] / samples;
    }
    return mean;
}

// Planes steep enough to cross inside the pixel.
TEST(Z3, ExactWhileFragmentsSuffice) {
    for (const int samples : {1, 4, 8}) {
        Random random(221);
        const TraceHeader header = test::opaque_header(7, 6, samples, random);
        test::FragmentOptions options;
        options.count = 252;
        options.most_in_a_pixel = 8;
        options.distinct_depths = true;
        const auto fragments = test::random_fragments(header, options, random);
        std::vector<DepthSlope> slopes;
        for (std::size_t i = 0; i < fragments.size(); ++i)
            slopes.push_back({random.real(-0.5, 0.5), random.real(-0.5, 0.5)});
        TestFrame frame("z3:fragments=8,format=float32", header);
        frame.draw(fragments, slopes);
        const auto image = frame.image();
        EXPECT_EQ(frame.log().path_count(kInsertMerge), 0u);
        for (int pixel = 0; pixel < 42; ++pixel) {
            const auto exact = exact_color(fragments, slopes, samples, pixel % 7, pixel / 7, header);
            for (std::size_t c = 0; c < 3; ++c)
                ASSERT_NEAR(image[static_cast<std::size_t>(3 * pixel) + c], exact[c], 1e-6) << samples;
        }
    }
}

// With one sample it is multi-layer alpha blending that merges the closest, earlier arrivals in front.
TEST(Z3, WithOneSampleItIsMlabThatMergesTheClosest) {
    Random random(222);
    const TraceHeader header = test::header_of(5, 5);
    const auto fragments = test::random_fragments(header, {.count = 1000}, random);
    for (const int n : {2, 3, 8}) {
        TestFrame z3("z3:fragments=" + std::to_string(n), header);
        TestFrame mlab("mlab:merge=closest,ties=oldest,layers=" + std::to_string(n), header);
        z3.draw(fragments);
        mlab.draw(fragments);
        EXPECT_GT(z3.log().path_count(kInsertMerge), 700u);
        for (int pixel = 0; pixel < 25; ++pixel)
            ASSERT_TRUE(std::ranges::equal(z3.words(pixel % 5, pixel / 5), mlab.words(pixel % 5, pixel / 5)))
                << n << " pixel " << pixel;
    }
}

struct Part {
    float z;
    float a;
    std::array<float, 3> color;
    std::uint16_t mask;
    DepthSlope slope = {};
};

std::unique_ptr<TestFrame> drawn(const std::string& technique, const std::vector<Part>& parts,
                                 glm::vec3 background = {0, 0, 0}) {
    auto frame = std::make_unique<TestFrame>(technique, test::header_of(1, 1, 4, background));
    std::vector<Fragment> fragments;
    std::vector<DepthSlope> slopes;
    for (const Part& p : parts) {
        fragments.push_back(test::fragment_at(0, 0, p.z, p.a, p.color));
        fragments.back().coverage = p.mask;
        slopes.push_back(p.slope);
    }
    frame->draw(fragments, slopes);
    return frame;
}

// Pieces of one surface, as triangles cut it, take one place: opaque in front of everything, nothing is lost
// whatever their number.
TEST(Z3, PiecesOfOneSurfaceMergeWithoutLoss) {
    std::vector<Part> parts = {{0.9f, 0.5f, {0, 0, 1}, 0xF}, {0.1f, 0.25f, {1, 1, 1}, 0xF}};
    for (int m = 0; m < 4; ++m)
        parts.push_back({0.5f, 1, {0, 1, 0}, static_cast<std::uint16_t>(1 << m), {0.01f, -0.02f}});
    const auto frame = drawn("z3:format=float32", parts);
    EXPECT_EQ(frame->log().path_count(kInsertMerge), 3u);
    EXPECT_EQ(frame->color(), (std::array<float, 3>{0.25f, 0.25f + 0.75f, 0.25f}));
}

// Two fragments of alpha 1/2 become one: red over samples 0, 1 and 2, green behind over 2 and 3. What the
// four samples show on average, before the background: red (1/2) at three of them, green (1/2) at one and
// (1/4) behind red at another; transmittances 1/2, 1/2, 1/4 and 1/2.
TEST(Z3, MergedColourIsTheMeanOverBothMasks) {
    const std::vector<Part> parts = {
        {0.5f, 0.5f, {1, 0, 0}, 0b0111}, {0.51f, 0.5f, {0, 1, 0}, 0b1100}, {0.9f, 0, {0, 0, 0}, 0xF}};
    const auto frame = drawn("z3:fragments=2,format=float32", parts, {0, 0, 1});
    EXPECT_EQ(frame->log().path_count(kInsertMerge), 1u);
    const auto color = frame->color();
    EXPECT_NEAR(color[0], 3 * 0.5 / 4, 1e-7);
    EXPECT_NEAR(color[1], (0.5 + 0.25) / 4, 1e-7);
    EXPECT_NEAR(color[2], (0.5 + 0.5 + 0.25 + 0.5) / 4, 1e-7);
}

// The price: the merged colour is even over the mask, so that what comes behind or in front of part of it
// mixes with both. Red and green halves, merged, then an opaque blue half in front of the red one: half blue,
// a quarter each of what was all green.
TEST(Z3, MergedColourNoLongerKnowsItsSamples) {
    const std::vector<Part> parts = {{0.5f, 1, {1, 0, 0}, 0b0011},
                                     {0.5f, 1, {0, 1, 0}, 0b1100},
                                     {0.9f, 1, {1, 1, 1}, 0xF},
                                     {0.1f, 1, {0, 0, 1}, 0b0011}};
    EXPECT_EQ(drawn("z3:fragments=4,format=float32", parts)->color(), (std::array<float, 3>{0, 0.5f, 0.5f}));
    EXPECT_EQ(drawn("z3:fragments=2,format=float32", parts)->color(),
              (std::array<float, 3>{0.25f, 0.25f, 0.5f}));
}

// The plane is that of the fragment that covers more. Two pieces are merged; a third fragment lies between
// the two planes at every sample, so that the picture says which one was kept.
TEST(Z3, MergedPlaneIsTheWidersOrTheNearers) {
    const auto blue_in_front = [](std::uint16_t near_mask, std::uint16_t far_mask) {
        const auto frame = drawn("z3:fragments=2,format=float32", {{0.4f, 1, {1, 0, 0}, near_mask},
                                                                   {0.5f, 1, {0, 1, 0}, far_mask},
                                                                   {0.9f, 1, {1, 1, 1}, 0xF},
                                                                   {0.45f, 1, {0, 0, 1}, 0xF}});
        return frame->color()[2] == 1.0f;
    };
    EXPECT_TRUE(blue_in_front(0b0001, 0b1110));
    EXPECT_FALSE(blue_in_front(0b0111, 0b1000));
    EXPECT_FALSE(blue_in_front(0b0011, 0b1100));
}

// Of one depth, at the centre and at every sample, the earlier arrival is in front: as in the reference.
TEST(Z3, EarlierArrivalIsNearer) {
    const std::vector<Part> parts = {{0.5f, 1, {1, 0, 0}, 0xF, {0.01f, 0}},
                                     {0.5f, 1, {0, 1, 0}, 0xF, {0.01f, 0}}};
    EXPECT_EQ(drawn("z3", parts)->color(), (std::array<float, 3>{1, 0, 0}));
}

// Only the two closest of four, and no more, are merged.
TEST(Z3, MergesNoMoreThanItMust) {
    const auto frame = drawn("z3:format=float32", {{0.8f, 0.5f, {1, 1, 1}, 0xF},
                                                   {0.1f, 0.5f, {1, 1, 1}, 0xF},
                                                   {0.35f, 0.5f, {1, 1, 1}, 0xF},
                                                   {0.5f, 0.5f, {1, 1, 1}, 0xF}});
    EXPECT_EQ(test::stored_real(*frame, 0), 0.1f);
    EXPECT_EQ(test::stored_real(*frame, 1), 0.35f);
    EXPECT_EQ(test::stored_real(*frame, 2), 0.8f);
}

// Two planes that cross along the pixel's middle: each in front on its side, sample by sample, with slopes
// kept in 8 bits; without slopes the one with the nearer centre would hide the other.
TEST(Z3, CrossingSurfacesAreOrderedSampleBySample) {
    const std::vector<Part> parts = {{0.5f, 1, {1, 0, 0}, 0xF, {0.1f, 0}},
                                     {0.501f, 1, {0, 1, 0}, 0xF, {-0.1f, 0}}};
    // x of the four samples: -2, 6, -6 and 2 sixteenths. Red is nearer at x < 0.005.
    EXPECT_EQ(drawn("z3", parts)->color(), (std::array<float, 3>{0.5f, 0.5f, 0}));
    std::vector<Part> flat = parts;
    for (Part& p : flat) p.slope = {};
    EXPECT_EQ(drawn("z3", flat)->color(), (std::array<float, 3>{1, 0, 0}));
}

TEST(Z3, VisibilityIsTheMeanOverSamples) {
    const auto frame = drawn("z3:format=float32",
                             {{0.5f, 0.5f, {1, 0, 0}, 0b0011, {0.4f, 0}}, {0.7f, 0.75f, {1, 0, 0}, 0b0110}});
    // At samples 0 and 1 the first fragment lies at 0.5 - 0.05 and 0.5 + 0.15.
    const std::vector<float> depths = {0.4f, 0.5f, 0.66f, 0.7f, 0.9f};
    const std::vector<double> expected = {1, 3.5 / 4, 3.0 / 4, (0.5 + 0.125 + 0.25 + 1) / 4,
                                          (0.5 + 0.125 + 0.25 + 1) / 4};
    std::vector<float> values(depths.size());
    frame->operation().visibility(frame->store(), 0, 0, depths, values);
    for (std::size_t k = 0; k < depths.size(); ++k) EXPECT_NEAR(values[k], expected[k], 1e-6) << depths[k];
}

// Every code is the slope nearest to itself, and any slope in range goes to the nearest of all codes.
TEST(SmallSlope, RoundsToTheNearestCode) {
    std::vector<float> values;
    for (std::uint32_t code = 0; code < 256; ++code) {
        const float value = slope_of(code);
        values.push_back(value);
        const std::uint32_t back = slope_code(value);
        EXPECT_EQ(slope_of(back), value) << code;
        EXPECT_EQ(back, ((code >> 2) & 31u) != 0 ? code : 0u);
    }
    EXPECT_EQ(*std::ranges::max_element(values), 1.75f);
    Random random(223);
    for (int i = 0; i < 5000; ++i) {
        const float slope =
            (i % 2 == 0 ? 1.0f : -1.0f) * std::ldexp(random.real(1, 2), random.integer(-33, 2));
        float nearest = 0;
        for (const float v : values)
            if (std::abs(v - slope) < std::abs(nearest - slope)) nearest = v;
        ASSERT_EQ(std::abs(slope_of(slope_code(slope)) - slope), std::abs(nearest - slope)) << slope;
        if (std::abs(slope) > 0x1p-30f && std::abs(slope) < 1.75f) {
            ASSERT_LE(std::abs(slope_of(slope_code(slope)) - slope), std::abs(slope) / 9 * 1.0001f) << slope;
        }
    }
    EXPECT_EQ(slope_of(slope_code(std::numeric_limits<float>::infinity())), 1.75f);
    EXPECT_EQ(slope_of(slope_code(-std::numeric_limits<float>::max())), -1.75f);
    EXPECT_EQ(slope_code(std::numeric_limits<float>::quiet_NaN()), 0u);
    EXPECT_EQ(slope_code(std::numeric_limits<float>::denorm_min()), 0u);
}

}  // namespace
}  // namespace ropsim
