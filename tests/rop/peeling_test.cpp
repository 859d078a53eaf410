// Depth peeling from the front and from both ends: layer by layer against exact compositing, and its passes.
#include "tests/rop/counted_passes.h"
#include "traces/depth_test.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::draw_counting;
using test::Random;
using test::TestFrame;

// Fragments of `layers` depths at pixel (x, 0), in a shuffled order of arrival that is also the drawing
// order.
void add_layers(std::vector<Fragment>& to, int x, int layers, Random& random) {
    std::vector<float> depths;
    for (int i = 0; i < layers; ++i)
        depths.push_back((static_cast<float>(i) + 0.5f) / static_cast<float>(layers));
    random.shuffle(depths);
    for (const float z : depths)
        to.push_back(test::fragment_at(x, 0, z, random.real(0.05, 0.6),
                                       {random.real(0, 1), random.real(0, 1), random.real(0, 1)},
                                       static_cast<std::uint32_t>(to.size())));
}

// Front to back: L layers, of which the first `shown` are composited in front of the background.
TEST(DepthPeeling, ShowsTheFirstLayersAndNoOthers) {
    Random random(31);
    std::vector<Fragment> fragments;
    add_layers(fragments, 0, 9, random);
    const TraceHeader header = test::header_of(1, 1);
    const auto sorted = test::nearest_first(fragments, 0, 0);
    for (std::size_t shown = 1; shown <= 11; ++shown) {
        TestFrame frame("depth_peeling:format=float32,layers=" + std::to_string(shown), header);
        EXPECT_EQ(draw_counting(frame, fragments), static_cast<int>(std::min<std::size_t>(shown, 10)));
        EXPECT_LT(test::worst_error(frame, std::span(sorted).first(std::min<std::size_t>(shown, 9))), 1e-6);
        // Layers of these alphas are told apart.
        if (shown < 9) {
            EXPECT_GT(test::worst_error(frame, std::span(sorted).first(shown + 1)), 1e-4);
        }
    }
}

// From both ends: after p peels, the p nearest and the p furthest.
TEST(DualDepthPeeling, ShowsTheLayersOfBothEnds) {
    Random random(32);
    std::vector<Fragment> fragments;
    add_layers(fragments, 0, 9, random);
    const TraceHeader header = test::header_of(1, 1);
    const auto sorted = test::nearest_first(fragments, 0, 0);
    for (int layers = 1; layers <= 11; ++layers) {
        TestFrame frame("dual_depth_peeling:format=float32,layers=" + std::to_string(layers), header);
        const int peels = std::min((layers + 1) / 2, 5);
        EXPECT_EQ(draw_counting(frame, fragments), 1 + peels);
        std::vector<Fragment> shown;
        for (int i = 0; i < 9; ++i)
            if (i < peels || i >= 9 - peels) shown.push_back(sorted[static_cast<std::size_t>(i)]);
        EXPECT_LT(test::worst_error(frame, shown), 1e-6) << layers;
    }
}

// Passes follow the deepest pixel: one a layer and one that finds nothing; from both ends one that finds the
// ranges and one for two layers (L / 2 + 1 for even L, as Bavoil and Myers count).
TEST(Peeling, PassesFollowTheDeepestPixel) {
    for (int deepest = 1; deepest <= 8; ++deepest) {
        Random random(33);
        std::vector<Fragment> fragments;
        for (int x = 0; x < 5; ++x) add_layers(fragments, x, 1 + (deepest - 1) * x / 4, random);
        for (const char* format : {"paper", "float32"}) {
            const std::string with = std::string(":format=") + format;
            TestFrame front("depth_peeling" + with, test::header_of(5, 1));
            EXPECT_EQ(draw_counting(front, fragments), deepest + 1);
            TestFrame both("dual_depth_peeling" + with, test::header_of(5, 1));
            EXPECT_EQ(draw_counting(both, fragments), (deepest + 1) / 2 + 1);
            // Without limit both are exact: 8-bit colour and alpha of up to 8 layers, 16-bit sums.
            const double tolerance = std::string(format) == "paper" ? 8.0 / 255 : 1e-6;
            EXPECT_LT(test::worst_error(front, fragments), tolerance);
            EXPECT_LT(test::worst_error(both, fragments), tolerance);
        }
    }
}

TEST(Peeling, AnEmptyFrameTakesItsPassesOnce) {
    TestFrame front("depth_peeling", test::header_of(1, 1));
    EXPECT_EQ(draw_counting(front, {}), 1);
    TestFrame both("dual_depth_peeling", test::header_of(1, 1));
    EXPECT_EQ(draw_counting(both, {}), 2);
}

// Exact where every layer is peeled, up to 60 of them over opaque geometry, in any order of arrival. The
// first and last depths there are, 0 and 1, are layers like others.
TEST(Peeling, EveryLayerGivesTheExactImage) {
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
        Random random(seed);
        const TraceHeader header = test::opaque_header(10, 7, 1, random);
        test::FragmentOptions options;
        options.count = 2500;
        options.distinct_depths = true;
        options.most_in_a_pixel = 60;
        auto fragments = test::random_fragments(header, options, random);
        for (int x = 0; x < 10; ++x) {
            fragments.push_back(test::fragment_at(x, 0, 0.0f, 0.5f, {1, 0, 0}));
            if (test::opaque_depth(header, x, 0) > 1)
                fragments.push_back(test::fragment_at(x, 0, 1.0f, 0.5f, {0, 1, 0}));
        }
        for (const char* technique :
             {"depth_peeling:format=float32", "depth_peeling:format=float32,ties=primitive",
              "dual_depth_peeling:format=float32"}) {
            TestFrame frame(technique, header);
            frame.draw(fragments);
            EXPECT_LT(test::worst_error(frame, fragments), 1e-5) << technique;
        }
    }
}

// One depth in four is shared. Drawn in the order of arrival: exact by primitive; by depth alone, the first
// arrival of each depth stays and the others are lost.
TEST(DepthPeeling, EqualDepthsCollapseOrNotAsAsked) {
    Random random(34);
    const TraceHeader header = test::opaque_header(10, 7, 1, random);
    test::FragmentOptions options;
    options.count = 2500;
    options.most_in_a_pixel = 60;
    auto fragments = test::random_fragments(header, options, random);
    std::ranges::sort(fragments, {}, [](const Fragment& f) { return std::pair(f.draw, f.primitive); });
    std::vector<Fragment> first_of_each;
    std::map<std::tuple<int, int, float>, bool> seen;
    for (const Fragment& f : fragments)
        if (seen.emplace(std::tuple(f.x, f.y, f.z), true).second) first_of_each.push_back(f);
    ASSERT_LT(first_of_each.size() + 100, fragments.size());

    TestFrame exact("depth_peeling:format=float32,ties=primitive", header);
    exact.draw(fragments);
    EXPECT_LT(test::worst_error(exact, fragments), 1e-5);
    // Whatever order they arrive in, the drawing order decides.
    auto shuffled = fragments;
    random.shuffle(shuffled);
    TestFrame by_number("depth_peeling:format=float32,ties=primitive", header);
    by_number.draw(shuffled);
    EXPECT_EQ(by_number.image(), exact.image());

    TestFrame collapsed("depth_peeling:format=float32", header);
    collapsed.draw(fragments);
    EXPECT_LT(test::worst_error(collapsed, first_of_each), 1e-5);
    EXPECT_GT(test::worst_error(collapsed, fragments), 0.1);
}

// Back faces carry a mark in the primitive's upper bit, which is no part of the drawing order.
TEST(DepthPeeling, FacingDoesNotChangeTheDrawingOrder) {
    TestFrame frame("depth_peeling:format=float32,ties=primitive", test::header_of(1, 1));
    const std::vector<Fragment> pair = {test::fragment_at(0, 0, 0.5f, 1, {1, 0, 0}, 3 | kBackFacing),
                                        test::fragment_at(0, 0, 0.5f, 1, {0, 1, 0}, 4)};
    frame.draw(pair);
    EXPECT_EQ(frame.color(), (std::array<float, 3>{1, 0, 0}));
}

// From both ends, coplanar fragments are all composited in their pass: in front in order of arrival, at the
// back in reverse.
TEST(DualDepthPeeling, EqualDepthsAreCompositedTogether) {
    const std::array<float, 3> red = {1, 0, 0};
    const std::array<float, 3> green = {0, 1, 0};
    const auto image_of = [](const std::vector<Fragment>& fragments) {
        TestFrame frame("dual_depth_peeling:format=float32", test::header_of(1, 1, 1, {0, 0, 1}));
        frame.draw(fragments);
        return frame.color();
    };
    // Alone: red in front of green, half of what is left each.
    EXPECT_EQ(
        image_of({test::fragment_at(0, 0, 0.5f, 0.5f, red), test::fragment_at(0, 0, 0.5f, 0.5f, green)}),
        (std::array<float, 3>{0.5f, 0.25f, 0.25f}));
    // Behind a third layer they are at the back.
    EXPECT_EQ(image_of({test::fragment_at(0, 0, 0.5f, 0.5f, red), test::fragment_at(0, 0, 0.5f, 0.5f, green),
                        test::fragment_at(0, 0, 0.25f, 0.5f, {0, 0, 0})}),
              (std::array<float, 3>{0.125f, 0.25f, 0.125f}));
}

// Each sample of a pixel has layers of its own, at the depths that the fragments' planes have there.
TEST(Peeling, SamplesArePeeledEachForItself) {
    Random random(35);
    const TraceHeader header = test::opaque_header(6, 5, 4, random);
    test::FragmentOptions options;
    options.count = 600;
    options.distinct_depths = true;
    auto fragments = test::random_fragments(header, options, random);
    // Planes that cross within the pixel and leave the range of depths nowhere.
    std::vector<DepthSlope> slopes;
    for (Fragment& f : fragments) {
        f.z = 0.25f + 0.5f * f.z;
        slopes.push_back({random.real(-0.2, 0.2), random.real(-0.2, 0.2)});
    }
    const auto positions = sample_positions(4);
    for (const char* technique :
         {"depth_peeling:format=float32,ties=primitive", "dual_depth_peeling:format=float32"}) {
        TestFrame frame(technique, header);
        frame.draw(fragments, slopes);
        const std::vector<float> image = frame.image();
        for (int pixel = 0; pixel < 30; ++pixel) {
            const int x = pixel % 6;
            const int y = pixel / 6;
            std::array<double, 3> mean{};
            for (std::size_t m = 0; m < 4; ++m) {
                std::vector<Fragment> at_sample;
                for (std::size_t i = 0; i < fragments.size(); ++i) {
                    if (((fragments[i].coverage >> m) & 1) == 0) continue;
                    at_sample.push_back(fragments[i]);
                    at_sample.back().z = sample_depth(fragments[i], slopes[i], positions[m]);
                }
                const auto color = test::composited(at_sample, x, y, test::background_of(header, x, y));
                for (std::size_t c = 0; c < 3; ++c) mean[c] += color[c] / 4;
            }
            for (std::size_t c = 0; c < 3; ++c)
                ASSERT_NEAR(image[static_cast<std::size_t>(3 * pixel) + c], mean[c], 1e-5) << technique;
        }
    }
}

}  // namespace
}  // namespace ropsim
