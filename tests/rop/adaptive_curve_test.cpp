// The curve of adaptive transparency, node by node, against one kept the slow way; what removal leaves
// untouched; what fragments of equal depth do to each other.
#include "tests/rop/random_fragments.h"
#include "tests/rop/slow_curve.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::SlowCurve;
using test::TestFrame;

// Every removal, every set of candidates, every rule of equal depth.
std::vector<SlowCurve> all_rules() {
    std::vector<SlowCurve> rules;
    for (const char* removal : {"underestimate", "overestimate", "node_by_node"})
        for (const char* candidates : {"paper", "protect_furthest", "protect_front_half"})
            for (const char* equal_depth : {"in_front", "behind", "merge"})
                for (const std::size_t nodes : {2u, 5u, 8u, 11u})
                    rules.push_back({nodes, removal, candidates, equal_depth, {}, false});
    return rules;
}
std::string keys_of(const SlowCurve& rules) {
    return fmt::format("adaptive:nodes={},removal={},candidates={},equal_depth={},format=float32",
                       rules.most_nodes, rules.removal, rules.candidates, rules.equal_depth);
}

// Depths and alphas on coarse grids, so that depths, errors and transmittances tie, 0 among them.
Fragment coarse_fragment(Random& random) {
    const float z = static_cast<float>(random.integer(0, 40)) / 64;
    const float a = static_cast<float>(random.integer(0, 16)) / 16;
    return test::fragment_at(0, 0, z, a, {0, 0, 0});
}

void expect_nodes(TestFrame& frame, const SlowCurve& expected, const std::string& when) {
    const std::size_t n = expected.most_nodes;
    const auto words = frame.words(0, 0);
    for (std::size_t j = 0; j < expected.nodes.size(); ++j) {
        ASSERT_EQ(std::bit_cast<float>(words[j]), expected.nodes[j].z) << when << ", node " << j;
        ASSERT_EQ(std::bit_cast<float>(words[n + j]), expected.nodes[j].t) << when << ", node " << j;
    }
    for (std::size_t j = expected.nodes.size(); j < n; ++j)
        ASSERT_EQ(std::bit_cast<float>(words[j]), 1e30f) << when << ": unused";
}

TEST(AdaptiveCurve, IsTheOneKeptTheSlowWay) {
    for (const SlowCurve& rules : all_rules()) {
        Random random(9);
        for (int pixel = 0; pixel < 12; ++pixel) {
            TestFrame frame(keys_of(rules), test::header_of(1, 1));
            SlowCurve expected = rules;
            for (int i = 0; i < 30; ++i) {
                const Fragment f = coarse_fragment(random);
                frame.draw_pass(0, {&f, 1});
                expected.insert(f.z, 1.0f - f.a);
                ASSERT_NO_FATAL_FAILURE(
                    expect_nodes(frame, expected, fmt::format("{} fragment {}", keys_of(rules), i)));
            }
        }
    }
}

// What the composite looks up is what `visibility` says: the transmittance strictly in front.
TEST(AdaptiveCurve, VisibilityIsWhatTheCompositeTakes) {
    for (const char* memory : {"fixed", "shader", "variable"}) {
        Random random(10);
        SlowCurve expected;
        std::vector<Fragment> fragments;
        for (int i = 0; i < 30; ++i) fragments.push_back(coarse_fragment(random));
        TestFrame frame(fmt::format("adaptive:format=float32,memory={}", memory), test::header_of(1, 1));
        frame.draw(fragments);
        if (std::string(memory) == "variable") std::ranges::reverse(fragments);
        for (const Fragment& f : fragments) expected.insert(f.z, 1.0f - f.a);
        std::vector<float> depths;
        for (int i = -1; i < 100; ++i) depths.push_back(static_cast<float>(i) / 128);
        std::vector<float> values(depths.size());
        ASSERT_TRUE(frame.operation().has_visibility());
        frame.operation().visibility(frame.store(), 0, 0, depths, values);
        for (std::size_t i = 0; i < depths.size(); ++i)
            ASSERT_EQ(values[i], expected.in_front(depths[i])) << memory << " at " << depths[i];
    }
}

TEST(AdaptiveCurve, EmptyPixelIsClear) {
    for (const char* memory : {"fixed", "variable"}) {
        TestFrame frame(fmt::format("adaptive:memory={}", memory), test::header_of(1, 1));
        const std::vector<float> depths = {0.0f, 0.5f, 1.0f};
        std::vector<float> values(3);
        frame.operation().visibility(frame.store(), 0, 0, depths, values);
        EXPECT_EQ(values, (std::vector<float>{1, 1, 1})) << memory;
    }
}

// Black in front of white: the total transmittance, of 1000 fragments in random order.
float total_transmittance(const std::string& keys, std::vector<Fragment>& fragments, float& product) {
    Random random(8);
    fragments.clear();
    product = 1;
    for (int i = 0; i < 1000; ++i)
        fragments.push_back(test::fragment_at(0, 0, random.real(0, 1), random.real(0, 0.02), {0, 0, 0}));
    for (const Fragment& f : fragments) product *= 1.0f - f.a;
    TestFrame frame("adaptive:format=float32," + keys, test::header_of(1, 1, 1, {1, 1, 1}));
    frame.draw(fragments);
    return frame.color()[0];
}

// Section 3.2: underestimation leaves total transmittance alone, bit for bit, whichever nodes may go and
// whatever becomes of equal depths; so does any removal that never takes the furthest node.
TEST(AdaptiveCurve, TotalTransmittanceIsExactUnlessTheFurthestNodeIsOverestimated) {
    std::vector<Fragment> fragments;
    float product = 0;
    for (const char* nodes : {"nodes=2", "nodes=4", "nodes=8", "nodes=9"}) {
        for (const char* rules :
             {"candidates=paper", "candidates=protect_furthest", "candidates=protect_front_half",
              "equal_depth=behind", "equal_depth=merge", "memory=shader", "composite=normalised",
              "removal=overestimate,candidates=protect_furthest",
              "removal=overestimate,candidates=protect_front_half",
              "removal=node_by_node,candidates=protect_furthest"}) {
            const float total = total_transmittance(fmt::format("{},{}", nodes, rules), fragments, product);
            EXPECT_EQ(total, product) << nodes << " " << rules;
        }
        for (const char* rules : {"removal=overestimate", "removal=node_by_node"})
            EXPECT_GE(total_transmittance(fmt::format("{},{}", nodes, rules), fragments, product), product);
        EXPECT_GT(total_transmittance(fmt::format("{},removal=overestimate", nodes), fragments, product),
                  1.2f * product)
            << nodes;
    }
    // The list is inserted in the opposite order: the same product with other roundings.
    EXPECT_NEAR(total_transmittance("memory=variable", fragments, product) / product, 1.0, 1e-4);
}

// The error is an area over depth as the buffer has it. Three layers, two nodes: with depth linear in the
// distance from the eye the near gap is the cheaper one to close; a perspective depth buffer spreads the near
// gap, and the far node goes, on top of the bias towards the eye that section 3.4 names.
TEST(AdaptiveCurve, PerspectiveDepthMovesRemovalAway) {
    const std::array<float, 3> distance = {1, 2, 6};
    const auto kept = [&](auto depth_at) {
        TestFrame frame("adaptive:nodes=2,format=float32", test::header_of(1, 1));
        for (std::size_t i = 0; i < 3; ++i) {
            const Fragment f =
                test::fragment_at(0, 0, depth_at(distance[i]), i == 0 ? 0.5f : 0.2f, {0, 0, 0});
            frame.draw_pass(0, {&f, 1});
        }
        const float second = std::bit_cast<float>(frame.words(0, 0)[1]);
        return second == depth_at(distance[2]) ? 2 : 1;
    };
    EXPECT_EQ(kept([](float d) { return d / 10; }), 2);
    EXPECT_EQ(kept([](float d) { return (1 / 0.5f - 1 / d) / (1 / 0.5f - 1 / 100.0f); }), 1);
}

// As many layers as nodes are exact whatever would be removed next.
TEST(AdaptiveCurve, AsManyFragmentsAsNodesAreExact) {
    for (const char* rules :
         {"removal=overestimate", "removal=node_by_node", "candidates=protect_front_half",
          "candidates=protect_furthest", "equal_depth=behind", "equal_depth=merge", "composite=normalised",
          "memory=shader", "memory=variable", "memory=variable,removal=node_by_node,composite=normalised"}) {
        Random random(11);
        const TraceHeader header = test::opaque_header(9, 7, 1, random);
        test::FragmentOptions options;
        options.count = 340;
        options.distinct_depths = true;
        options.most_in_a_pixel = 8;
        const auto fragments = test::random_fragments(header, options, random);
        TestFrame frame(fmt::format("adaptive:nodes=8,format=float32,{}", rules), header);
        frame.draw(fragments);
        EXPECT_LT(test::worst_error(frame, fragments), 1e-5) << rules;
    }
}

// Two coplanar layers of alpha 1/2, red over blue .5: exact compositing gives red .75, of which either order
// gives .5 to one and .25 to the other. What is behind shows by 1/4 whatever the rule.
TEST(AdaptiveEqualDepth, WhatEachRuleMakesOfACoplanarPair) {
    const std::vector<Fragment> pair = {test::fragment_at(0, 0, 0.5f, 0.5f, {1, 0, 0}),
                                        test::fragment_at(0, 0, 0.5f, 0.5f, {1, 0, 0})};
    for (const char* memory : {"fixed", "variable"}) {
        const auto red = [&](const char* rule) {
            TestFrame frame(fmt::format("adaptive:format=float32,memory={},{}", memory, rule),
                            test::header_of(1, 1, 1, {0, 0, 0.5f}));
            frame.draw(pair);
            EXPECT_EQ(frame.color()[2], 0.125f) << rule;
            return frame.color()[0];
        };
        EXPECT_EQ(red("equal_depth=in_front"), 1.0f) << "neither is attenuated: the paper's step function";
        EXPECT_EQ(red("equal_depth=behind"), 0.5f) << "each is attenuated by the other";
        EXPECT_EQ(red("equal_depth=merge"), 0.75f) << "the mean of both is exact for a pair";
        EXPECT_EQ(red("composite=normalised"), 0.75f);
        EXPECT_EQ(red("composite=normalised,equal_depth=behind"), 0.75f);
    }
}

// Merging is exact for a pair of any two alphas below 1, seen through what is in front; of two opaque ones
// nothing is left to tell how many there were, so each counts in full.
TEST(AdaptiveEqualDepth, MergedPairsOfAnyAlphas) {
    Random random(12);
    for (int i = 0; i < 200; ++i) {
        const float a = random.real(0, 0.95);
        const float b = random.real(0, 0.95);
        const std::vector<Fragment> fragments = {test::fragment_at(0, 0, 0.5f, a, {1, 1, 1}),
                                                 test::fragment_at(0, 0, 0.25f, 0.5f, {0, 0, 0}),
                                                 test::fragment_at(0, 0, 0.5f, b, {1, 1, 1})};
        TestFrame frame("adaptive:format=float32,equal_depth=merge", test::header_of(1, 1, 1, {0, 0, 0}));
        frame.draw(fragments);
        ASSERT_NEAR(frame.color()[0], 0.5 * (1 - (1.0 - a) * (1.0 - b)), 1e-6) << a << " " << b;
    }
    const std::vector<Fragment> opaque = {test::fragment_at(0, 0, 0.5f, 1, {1, 1, 1}),
                                          test::fragment_at(0, 0, 0.5f, 1, {1, 1, 1})};
    for (const char* rule : {"in_front", "behind", "merge"}) {
        TestFrame frame(fmt::format("adaptive:format=float32,equal_depth={}", rule), test::header_of(1, 1));
        frame.draw(opaque);
        EXPECT_EQ(frame.color()[0], 2.0f) << rule;
        TestFrame normalised(fmt::format("adaptive:format=float32,composite=normalised,equal_depth={}", rule),
                             test::header_of(1, 1));
        normalised.draw(opaque);
        EXPECT_EQ(normalised.color()[0], 1.0f) << rule;
    }
}

// Look-up at a fragment's own depth also finds what removal has put there: under underestimation the node in
// front of a removed one has the removed one's transmittance. The rules that look there take it for a
// coplanar fragment's, so a curve with many removals gets darker with them.
TEST(AdaptiveEqualDepth, RulesThatLookAtTheOwnDepthSeeRemovedNodes) {
    Random random(15);
    std::vector<Fragment> fragments;
    for (int i = 0; i < 64 * 32; ++i)
        fragments.push_back(test::fragment_at(i % 8, i / 8 % 8, random.real(0, 1), 0.15f, {1, 1, 1}));
    const auto mean = [&](const char* rule) {
        TestFrame frame(fmt::format("adaptive:format=float32,equal_depth={}", rule),
                        test::header_of(8, 8, 1, {0, 0, 0}));
        frame.draw(fragments);
        double sum = 0;
        for (const float v : frame.image()) sum += v / (3 * 64.0);
        return sum;
    };
    const double in_front = mean("in_front");
    const double behind = mean("behind");
    EXPECT_LT(behind, in_front - 0.02) << "depths are all different";
    EXPECT_NEAR(mean("merge"), (in_front + behind) / 2, 1e-4);
}

// A merged group takes one node, however many arrive.
TEST(AdaptiveEqualDepth, MergedFragmentsTakeNoNode) {
    TestFrame frame("adaptive:nodes=2,format=float32,equal_depth=merge", test::header_of(1, 1));
    Random random(13);
    std::vector<Fragment> fragments;
    for (int i = 0; i < 50; ++i)
        fragments.push_back(test::fragment_at(0, 0, i % 2 == 0 ? 0.25f : 0.75f, 0.1f, {1, 1, 1}));
    frame.draw_pass(0, fragments);
    const Declaration& declared = frame.declaration();
    EXPECT_EQ(frame.log().path_count(static_cast<std::size_t>(declared.path("insert"))), 2u);
    EXPECT_EQ(frame.log().path_count(static_cast<std::size_t>(declared.path("merge"))), 48u);
    EXPECT_NEAR(std::bit_cast<float>(frame.words(0, 0)[2]), std::pow(0.9, 25), 1e-6);
    EXPECT_NEAR(std::bit_cast<float>(frame.words(0, 0)[3]), std::pow(0.9, 50), 1e-6);
}

// Section 4: opaque geometry may go through the curve too. Behind an opaque fragment transmittance is 0 and
// so is every error; the ties go to the nearest node, never past the opaque one's front.
TEST(AdaptiveOpaque, FragmentsOfAlphaOneHideWhatIsBehind) {
    for (const char* rules : {"removal=underestimate", "removal=overestimate", "removal=node_by_node",
                              "equal_depth=behind", "equal_depth=merge", "memory=shader", "memory=variable",
                              "composite=normalised", "candidates=protect_front_half,nodes=9"}) {
        Random random(14);
        for (int pixel = 0; pixel < 100; ++pixel) {
            std::vector<Fragment> fragments = {test::fragment_at(0, 0, 0.5f, 1, {0.25f, 0.5f, 0.75f})};
            for (int i = 0; i < 20; ++i)
                fragments.push_back(
                    test::fragment_at(0, 0, random.real(0.5001, 1), i % 3 == 0 ? 1.0f : 0.5f, {1, 1, 1}));
            for (int i = 0; i < 3; ++i)
                fragments.push_back(test::fragment_at(0, 0, random.real(0, 0.4999), 0.5f, {1, 0, 0}));
            // The opaque one comes first, or what is in front of it may have been removed before.
            std::vector<Fragment> later(fragments.begin() + 1, fragments.end());
            random.shuffle(later);
            std::ranges::copy(later, fragments.begin() + 1);
            TestFrame frame(fmt::format("adaptive:format=float32,{}", rules), test::header_of(1, 1));
            frame.draw(fragments);
            const auto exact = test::composited(fragments, 0, 0, {0.25, 0.5, 0.125});
            for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(frame.color()[c], exact[c], 1e-5) << rules;
        }
    }
}

}  // namespace
}  // namespace ropsim
