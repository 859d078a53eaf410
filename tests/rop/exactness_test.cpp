// Where a technique promises the exact image, it is held against compositing in double precision.
#include "tests/rop/random_fragments.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

struct Scene {
    TraceHeader header;
    std::vector<Fragment> fragments;
};

// Up to 60 layers a pixel over opaque geometry.
Scene deep_scene(std::uint64_t seed, bool distinct_depths) {
    Random random(seed);
    Scene scene{test::opaque_header(10, 7, 1, random), {}};
    test::FragmentOptions options;
    options.count = 2500;
    options.distinct_depths = distinct_depths;
    options.most_in_a_pixel = 60;
    scene.fragments = test::random_fragments(scene.header, options, random);
    return scene;
}

class Exact : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Techniques, Exact,
                         testing::Values("a_buffer:format=float32", "adaptive:nodes=64,format=float32",
                                         "slab:layers=64,bits=inf,format=float32",
                                         "depth_peeling:format=float32", "dual_depth_peeling:format=float32"),
                         [](const auto& setup) { return setup.param.substr(0, setup.param.find(':')); });

TEST_P(Exact, EnoughRoomGivesTheExactImage) {
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
        const Scene scene = deep_scene(seed, true);
        TestFrame frame(GetParam(), scene.header);
        frame.draw(scene.fragments);
        EXPECT_LT(test::worst_error(frame, scene.fragments), 1e-5);
    }
}

TEST_P(Exact, WhateverTheOrderOfArrival) {
    Scene scene = deep_scene(4, true);
    const auto fragments = scene.fragments;
    const auto expect_exact = [&] {
        TestFrame frame(GetParam(), scene.header);
        frame.draw(scene.fragments);
        EXPECT_LT(test::worst_error(frame, fragments), 1e-5);
    };
    std::ranges::sort(scene.fragments, {}, &Fragment::z);
    expect_exact();
    std::ranges::reverse(scene.fragments);
    expect_exact();
}

TEST(Exactness, AlphaBlendOfBackToFrontFragments) {
    Scene scene = deep_scene(5, true);
    std::ranges::sort(scene.fragments, std::greater<>(), &Fragment::z);
    TestFrame frame("alpha_blend:format=float32", scene.header);
    frame.draw(scene.fragments);
    EXPECT_LT(test::worst_error(frame, scene.fragments), 1e-5);
    std::ranges::reverse(scene.fragments);
    TestFrame wrong("alpha_blend:format=float32", scene.header);
    wrong.draw(scene.fragments);
    EXPECT_GT(test::worst_error(wrong, scene.fragments), 0.1) << "front to back is not what it composites";
}

// Alpha is blended too: 1 - product of (1 - alpha) over an opaque target stays 1.
TEST(Exactness, AlphaBlendLeavesAnOpaqueTargetOpaque) {
    TestFrame frame("alpha_blend:format=float32", test::header_of(1, 1));
    frame.draw_one(test::fragment_at(0, 0, 0.5f, 0.25f, {1, 1, 1}));
    EXPECT_EQ(std::bit_cast<float>(frame.words(0, 0)[3]), 1.0f);
}

// Of equal depths the earlier arrival is nearer (test::composited says the same).
TEST(DepthTies, EarlierArrivalIsNearer) {
    for (const char* technique : {"a_buffer:format=float32", "slab:layers=64,bits=inf,format=float32"}) {
        const Scene scene = deep_scene(6, false);
        TestFrame frame(technique, scene.header);
        frame.draw(scene.fragments);
        EXPECT_LT(test::worst_error(frame, scene.fragments), 1e-5) << technique;

        TestFrame two(technique, test::header_of(1, 1));
        two.draw_one(test::fragment_at(0, 0, 0.5f, 1.0f, {1, 0, 0}, 0));
        two.draw_one(test::fragment_at(0, 0, 0.5f, 1.0f, {0, 1, 0}, 1));
        EXPECT_EQ(two.color(), (std::array<float, 3>{1, 0, 0})) << technique;
    }
}

// Adaptive transparency's own rule: visibility is looked up strictly in front, so fragments of equal depth
// are not attenuated by each other, while all of them attenuate what lies behind. Closed form over groups of
// equal depth.
TEST(DepthTies, AdaptiveFragmentsOfEqualDepthDoNotAttenuateEachOther) {
    Scene scene = deep_scene(7, false);
    TestFrame frame("adaptive:nodes=64,format=float32", scene.header);
    frame.draw(scene.fragments);
    const std::vector<float> image = frame.image();
    int ties = 0;
    for (int pixel = 0; pixel < scene.header.width * scene.header.height; ++pixel) {
        const int x = pixel % scene.header.width;
        const int y = pixel / scene.header.width;
        std::map<float, std::array<double, 4>> groups;  // by depth: colour sum, transmittance
        for (const Fragment& f : scene.fragments) {
            if (f.x != x || f.y != y) continue;
            auto& group = groups.try_emplace(f.z, std::array<double, 4>{0, 0, 0, 1}).first->second;
            ties += group[3] != 1 ? 1 : 0;
            group = {group[0] + f.r, group[1] + f.g, group[2] + f.b,
                     group[3] * (1.0 - static_cast<double>(f.a))};
        }
        const auto background = test::background_of(scene.header, x, y);
        for (std::size_t c = 0; c < 3; ++c) {
            double sum = 0;
            double transmittance = 1;
            for (const auto& [z, group] : groups) {
                sum += transmittance * group[c];
                transmittance *= group[3];
            }
            ASSERT_NEAR(image[static_cast<std::size_t>(3 * pixel) + c], sum + transmittance * background[c],
                        1e-5);
        }
    }
    EXPECT_GT(ties, 100);
}

// Two coplanar layers of alpha 0.5 sum to 1 in front of black, where "over" gives 0.75; the background still
// shows by 1/4.
TEST(DepthTies, AdaptiveCoplanarPair) {
    TestFrame frame("adaptive:nodes=4,format=float32", test::header_of(1, 1, 1, {0, 0, 0.5f}));
    const std::vector<Fragment> pair = {test::fragment_at(0, 0, 0.5f, 0.5f, {1, 0, 0}),
                                        test::fragment_at(0, 0, 0.5f, 0.5f, {1, 0, 0})};
    frame.draw(pair);
    EXPECT_EQ(frame.color(), (std::array<float, 3>{1.0f, 0, 0.125f}));
}

// Section 3.2 of Salvi et al.: removal by underestimation leaves the total transmittance alone. Black
// fragments in front of white: the image is the total transmittance, the product of all 1 - alpha in order of
// arrival, bit for bit.
TEST(AdaptiveTransparency, TotalTransmittanceIsExactWhateverIsRemoved) {
    for (const int nodes : {2, 4, 8}) {
        for (const bool sorted : {false, true}) {
            Random random(8);
            std::vector<Fragment> fragments;
            float product = 1;
            double exact = 1;
            for (int i = 0; i < 1000; ++i)
                fragments.push_back(
                    test::fragment_at(0, 0, random.real(0, 1), random.real(0, 0.02), {0, 0, 0}));
            if (sorted) std::ranges::sort(fragments, {}, &Fragment::z);
            for (const Fragment& f : fragments) {
                product *= 1.0f - f.a;
                exact *= 1.0 - static_cast<double>(f.a);
            }
            TestFrame frame("adaptive:format=float32,nodes=" + std::to_string(nodes),
                            test::header_of(1, 1, 1, {1, 1, 1}));
            frame.draw(fragments);
            EXPECT_GT(frame.log().path_count(1), 900u) << "removals";
            EXPECT_EQ(frame.color()[0], product);
            // 1000 subtractions and 1000 products, each within half an ulp and of random sign: 6 standard
            // deviations of a uniform rounding error.
            EXPECT_NEAR(frame.color()[0] / exact, 1.0, 6 * std::sqrt(2000 / 12.0) * 0x1p-23);
        }
    }
}

// The removed node is the one of least error of equation 7, found here by brute force over a curve kept
// apart.
TEST(AdaptiveTransparency, RemovesTheNodeOfLeastError) {
    Random random(9);
    constexpr std::size_t kNodes = 6;
    struct Node {
        float z, t;
    };
    std::vector<Node> curve;
    TestFrame frame("adaptive:nodes=6,format=float32", test::header_of(1, 1));
    for (int i = 0; i < 500; ++i) {
        if (i % 25 == 0) curve.clear();
        const int x = 0;
        const float z = static_cast<float>(random.integer(0, 40)) / 64;
        const float a = i % 7 == 0 ? 1.0f : static_cast<float>(random.integer(0, 8)) / 8;
        if (i % 25 == 0) {
            frame.store().pixel(0, 0);
            const Surface& s = frame.declaration().surfaces[0];
            std::ranges::copy(s.clear_words, frame.store().pixel(0, 0) + s.first_word);
        }
        const Fragment f = test::fragment_at(x, 0, z, a, {0, 0, 0});
        frame.draw_pass(0, {&f, 1});
        std::size_t at = 0;
        while (at < curve.size() && curve[at].z < z) ++at;
        const float before = at == 0 ? 1.0f : curve[at - 1].t;
        for (std::size_t j = at; j < curve.size(); ++j) curve[j].t *= 1.0f - a;
        curve.insert(curve.begin() + static_cast<std::ptrdiff_t>(at), {z, before * (1.0f - a)});
        if (curve.size() > kNodes) {
            std::size_t least = 1;
            const auto error = [&](std::size_t j) {
                return (curve[j - 1].t - curve[j].t) * (curve[j].z - curve[j - 1].z);
            };
            for (std::size_t j = 2; j < curve.size(); ++j)
                if (error(j) < error(least)) least = j;
            curve[least - 1].t = curve[least].t;
            curve.erase(curve.begin() + static_cast<std::ptrdiff_t>(least));
        }
        for (std::size_t j = 0; j < curve.size(); ++j) {
            ASSERT_EQ(std::bit_cast<float>(frame.words(0, 0)[j]), curve[j].z) << i << " node " << j;
            ASSERT_EQ(std::bit_cast<float>(frame.words(0, 0)[kNodes + j]), curve[j].t) << i << " node " << j;
        }
    }
}

// A full pool drops later fragments and counts them; what came before is composited exactly.
TEST(ABuffer, AFullPoolDropsTheLatestAndCountsThem) {
    const Scene scene = deep_scene(10, true);
    TestFrame frame("a_buffer:format=float32", scene.header, 0, 1000);
    frame.draw(scene.fragments);
    EXPECT_EQ(frame.store().pool()->used(), 1000u);
    EXPECT_EQ(frame.store().pool()->overflowed(), scene.fragments.size() - 1000);
    EXPECT_LT(test::worst_error(frame, std::span(scene.fragments).first(1000)), 1e-5);
}

// The nodes a resolve reads, in the order of the list: the latest arrival first.
TEST(ABuffer, ResolveWalksEachListOnce) {
    TestFrame frame("a_buffer", test::header_of(1, 1));
    for (std::uint32_t i = 0; i < 5; ++i)
        frame.draw_one(test::fragment_at(0, 0, 0.1f * static_cast<float>(i), 0.5f, {1, 1, 1}, i));
    frame.image();
    EXPECT_EQ(frame.log().walk_nodes(), (std::vector<std::uint32_t>{4, 3, 2, 1, 0}));
    EXPECT_EQ(frame.log().read_elements(1), 5u);
    // Binary insertion of 5 entries: 1 + 2 + 2 + 3 comparisons.
    EXPECT_EQ(frame.log().path_steps(2), (std::array<std::uint64_t, 2>{5, 8}));
}

}  // namespace
}  // namespace ropsim
