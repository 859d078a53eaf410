// Multi-layer alpha blending: where it is exact, what merging costs where it is not, and each rule of merging
// against brute force.
#include "tests/rop/layer_lists.h"
#include "tests/rop/worst_case_bytes.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::LayerList;
using test::Random;
using test::TestFrame;

enum Path : std::size_t { kInsert, kInsertMerge };

constexpr std::array kRules = {"tail", "closest", "least_error", "transmittance", "opacity"};

// Which entry is merged into the one in front of it, straight from the rules' words.
std::size_t entry_by_rule(const std::string& rule, const LayerList& list) {
    const std::size_t last = list.size() - 1;
    if (rule == "tail") return last;
    if (rule == "closest" || rule == "least_error") {
        std::size_t best = 1;
        double least = 1e300;
        double through = 1;  // of everything in front of entry j
        for (std::size_t j = 1; j <= last; ++j) {
            through *= list[j - 1].t;
            double error = list[j].z - list[j - 1].z;
            if (rule == "least_error") error *= through * (1 - list[j].t);
            if (error < least) {
                least = error;
                best = j;
            }
        }
        return best;
    }
    const double sign = rule == "opacity" ? -1 : 1;
    std::size_t least = 0;
    for (std::size_t i = 1; i <= last; ++i)
        if (sign * list[i].t < sign * list[least].t) least = i;
    if (least == 0) return 1;
    if (least == last) return last;
    return sign * list[least - 1].t < sign * list[least + 1].t ? least : least + 1;
}

std::string technique(const std::string& rule, int layers, const std::string& more = "format=float32") {
    return "mlab:merge=" + rule + ",layers=" + std::to_string(layers) + "," + more;
}

std::vector<Fragment> sorted(std::vector<Fragment> fragments, bool near_first) {
    // By number: std::stable_sort's buffer in libstdc++ 12 ignores the alignment of a Fragment.
    std::vector<std::size_t> order(fragments.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {},
                             [&](std::size_t i) { return near_first ? fragments[i].z : -fragments[i].z; });
    std::vector<Fragment> result;
    for (const std::size_t i : order) result.push_back(fragments[i]);
    return result;
}

// Bits a pixel and bytes a fragment that moves everything, of k = 2, 4 and 8.
TEST(Mlab, ClaimedStorageAndTraffic) {
    for (const int k : {2, 4, 8}) {
        const std::string text = "mlab:layers=" + std::to_string(k);
        EXPECT_EQ(test::storage_bits(text), 64 * k);
        const auto bytes = test::worst_case_bytes(text);
        EXPECT_EQ(bytes.read, static_cast<std::uint64_t>(8 * k));
        EXPECT_EQ(bytes.write, static_cast<std::uint64_t>(8 * k));
    }
}

TEST(Mlab, ExactWhileLayersSuffice) {
    Random random(201);
    const TraceHeader header = test::opaque_header(9, 7, 1, random);
    test::FragmentOptions options;
    options.count = 800;
    options.distinct_depths = true;
    options.most_in_a_pixel = 16;
    const auto fragments = test::random_fragments(header, options, random);
    for (const std::string rule : kRules) {
        TestFrame frame(technique(rule, 16), header);
        frame.draw(fragments);
        EXPECT_EQ(frame.log().path_count(kInsertMerge), 0u);
        EXPECT_LT(test::worst_error(frame, fragments), 1e-6) << rule;
    }
}

// Whatever is merged, nothing comes between the two later on.
TEST(Mlab, ExactForSortedArrivalInEitherDirection) {
    Random random(202);
    const auto fragments = test::random_layers(8, 60, random, [&] { return random.real(0, 0.3); });
    for (const std::string rule : kRules)
        for (const int layers : {1, 2, 4, 8})
            for (const bool near_first : {true, false}) {
                TestFrame frame(technique(rule, layers), test::header_of(8, 8));
                frame.draw(sorted(fragments, near_first));
                EXPECT_GT(frame.log().path_count(kInsertMerge), 3000u);
                EXPECT_LT(test::worst_error(frame, fragments), 1e-5)
                    << rule << " " << layers << " near first " << near_first;
            }
}

// Two layers hold z = 0.1 and, merged at the nearer depth, 0.5 with 0.9. What comes at 0.7 stands in truth
// between the merged two, and is composited behind both. (At 0.3 it would be exact.)
TEST(Mlab, AFragmentBetweenMergedLayersIsCompositedBehindThem) {
    const std::vector<std::pair<float, float>> arrivals = {
        {0.5f, 0.5f}, {0.1f, 0.25f}, {0.9f, 0.75f}, {0.7f, 0.5f}};
    std::vector<Fragment> fragments;
    for (std::uint32_t i = 0; i < arrivals.size(); ++i) {
        std::array<float, 3> color{};
        if (i > 0) color[i - 1] = 1;
        fragments.push_back(test::fragment_at(0, 0, arrivals[i].first, arrivals[i].second, color, i));
    }
    TestFrame frame(technique("tail", 2), test::header_of(1, 1, 1, {0, 0, 0}));
    frame.draw(fragments);
    // In front of z = 0.9: 0.75 * 0.5; then it hides 3/4 of z = 0.7. In truth 0.7 is in front.
    EXPECT_EQ(frame.color(),
              (std::array<float, 3>{0.25f, 0.75f * 0.5f * 0.75f, 0.75f * 0.5f * 0.25f * 0.5f}));
    const auto exact = test::composited(fragments, 0, 0, {0, 0, 0});
    EXPECT_DOUBLE_EQ(exact[1], 0.75 * 0.5 * 0.5 * 0.75);
    EXPECT_DOUBLE_EQ(exact[2], 0.75 * 0.5 * 0.5);
    fragments.back().z = 0.3f;
    TestFrame in_front(technique("tail", 2), test::header_of(1, 1, 1, {0, 0, 0}));
    in_front.draw(fragments);
    EXPECT_LT(test::worst_error(in_front, fragments), 1e-7);
}

TEST(Mlab, EveryRuleOfMergingAgainstBruteForce) {
    for (const std::string rule : kRules)
        for (const int layers : {1, 2, 5, 8}) {
            Random random(203);
            const auto fragments =
                test::random_layers(8, 40, random, [&] { return random.real(0.05, 0.95); });
            TestFrame frame(technique(rule, layers), test::header_of(8, 8));
            frame.draw(fragments);
            const auto image = frame.image();
            double from_exact = 0;
            for (int pixel = 0; pixel < 64; ++pixel) {
                const LayerList list =
                    test::merged_list(fragments, pixel % 8, pixel / 8, static_cast<std::size_t>(layers), true,
                                      [&](const LayerList& l) { return entry_by_rule(rule, l); });
                const auto background = test::background_of(frame.header(), pixel % 8, pixel / 8);
                const auto expected = test::composited(list, background);
                const auto words = frame.words(pixel % 8, pixel / 8);
                for (std::size_t i = 0; i < list.size(); ++i)
                    ASSERT_EQ(std::bit_cast<float>(words[i]), static_cast<float>(list[i].z))
                        << rule << " " << layers << " pixel " << pixel;
                const auto exact = test::composited(fragments, pixel % 8, pixel / 8, background);
                for (std::size_t c = 0; c < 3; ++c) {
                    ASSERT_NEAR(image[static_cast<std::size_t>(3 * pixel) + c], expected[c], 2e-6);
                    from_exact = std::max(from_exact, std::abs(expected[c] - exact[c]));
                }
            }
            EXPECT_GT(from_exact, 0.001) << rule << ": the order mattered";
        }
}

// The public code's "opacity merge" looks for the least number in a channel that holds transmittance. Of
// layers at 0.1, 0.3, 0.5 and 0.7 with opacities .5, .1, .8 and .2 it joins the most opaque one with what is
// more opaque beside it; by opacity, the least opaque one joins what is less opaque beside it.
TEST(Mlab, ThePublishedOpacityMergeMinimisesTransmittance) {
    const std::vector<std::pair<float, float>> layers = {
        {0.1f, 0.5f}, {0.3f, 0.1f}, {0.5f, 0.8f}, {0.7f, 0.2f}};
    const auto depths = [&](const std::string& rule) {
        TestFrame frame(technique(rule, 3), test::header_of(1, 1));
        for (const auto& [z, a] : layers) frame.draw_one(test::fragment_at(0, 0, z, a, {1, 1, 1}));
        return std::vector<float>{test::stored_real(frame, 0), test::stored_real(frame, 1),
                                  test::stored_real(frame, 2)};
    };
    EXPECT_EQ(depths("transmittance"), (std::vector<float>{0.1f, 0.3f, 0.5f})) << ".8 and .2, as .2 > .1";
    EXPECT_EQ(depths("opacity"), (std::vector<float>{0.1f, 0.5f, 0.7f})) << ".1 and .5, as .5 < .8";
    EXPECT_EQ(depths("tail"), (std::vector<float>{0.1f, 0.3f, 0.5f}));
}

// Eight bits as the public code stores them, with its arithmetic: each fragment is rounded before it is
// inserted, each merged layer after.
TEST(Mlab, StoresWhatThePublishedCodeStores) {
    Random random(204);
    constexpr std::size_t kLayers = 4;
    struct Node {
        float z;
        std::array<int, 4> rgbt;
    };
    const auto packed = [](float v) {
        return static_cast<int>(std::min(std::max(v, 0.0f), 1.0f) * 255.0f + 0.5f);
    };
    std::vector<Node> list;
    TestFrame frame("mlab:layers=4", test::header_of(1, 1));
    for (int i = 0; i < 100; ++i) {
        const Fragment f = test::fragment_at(0, 0, random.real(0, 1), random.real(0, 1),
                                             {random.real(0, 1), random.real(0, 1), random.real(0, 1)});
        frame.draw_one(f);
        Node node{f.z, {packed(f.r), packed(f.g), packed(f.b), packed(1.0f - f.a)}};
        for (Node& n : list)
            if (node.z <= n.z) std::swap(node, n);
        list.push_back(node);
        if (list.size() > kLayers) {
            const Node far = list.back();
            list.pop_back();
            const auto unpacked = [](int v) { return static_cast<float>(v) / 255.0f; };
            Node& near = list.back();
            const float t = unpacked(near.rgbt[3]);
            for (std::size_t c = 0; c < 3; ++c)
                near.rgbt[c] = packed(unpacked(near.rgbt[c]) + t * unpacked(far.rgbt[c]));
            near.rgbt[3] = packed(t * unpacked(far.rgbt[3]));
        }
        for (std::size_t n = 0; n < list.size(); ++n) {
            ASSERT_EQ(test::stored_real(frame, static_cast<int>(n)), list[n].z) << i;
            for (std::size_t c = 0; c < 3; ++c)
                ASSERT_EQ(std::lround(255 * test::stored_real(frame, static_cast<int>(kLayers + 3 * n + c))),
                          list[n].rgbt[c])
                    << i;
            ASSERT_EQ(std::lround(255 * test::stored_real(frame, static_cast<int>(4 * kLayers + n))),
                      list[n].rgbt[3])
                << i;
        }
    }
}

// Opaque fragments of one depth: the later arrival hides the earlier one, or the other way round.
TEST(Mlab, TiesGoToTheNewestOrTheOldest) {
    for (const char* ties : {"newest", "oldest"}) {
        TestFrame frame(technique("tail", 4, std::string("ties=") + ties), test::header_of(1, 1));
        frame.draw_one(test::fragment_at(0, 0, 0.5f, 1, {1, 0, 0}));
        frame.draw_one(test::fragment_at(0, 0, 0.5f, 1, {0, 1, 0}));
        const bool newest = ties == std::string("newest");
        EXPECT_EQ(frame.color(), (std::array<float, 3>{newest ? 0.0f : 1.0f, newest ? 1.0f : 0.0f, 0}))
            << ties;
    }
    // With the oldest in front, coplanar layers agree with the reference.
    Random random(205);
    const TraceHeader header = test::opaque_header(6, 6, 1, random);
    const auto fragments = test::random_fragments(header, {.count = 500, .most_in_a_pixel = 24}, random);
    TestFrame oldest(technique("tail", 24, "ties=oldest,format=float32"), header);
    oldest.draw(fragments);
    EXPECT_LT(test::worst_error(oldest, fragments), 1e-6);
    TestFrame newest(technique("tail", 24), header);
    newest.draw(fragments);
    EXPECT_GT(test::worst_error(newest, fragments), 0.1);
}

// Alpha below 1/510 rounds to a transmittance of 1. The public resolve divides the colour by 1 - T = 0; here
// such fragments vanish, whatever their number, and light without alpha is kept.
TEST(Mlab, NothingIsDividedByAVanishingTotalAlpha) {
    TestFrame thin("mlab", test::header_of(1, 1));
    for (int i = 0; i < 200; ++i)
        thin.draw_one(test::fragment_at(0, 0, 0.001f * static_cast<float>(i), 0.0018f, {1, 1, 1}));
    EXPECT_EQ(thin.color(), (std::array<float, 3>{0.25f, 0.5f, 0.125f}));
    TestFrame light("mlab", test::header_of(1, 1));
    Fragment glow = test::fragment_at(0, 0, 0.5f, 0, {0, 0, 0});
    glow.r = 0.2f;
    light.draw_one(glow);
    EXPECT_NEAR(light.color()[0], 0.45, 1e-3);
    // In float32 the same layers leave 0.9982^200 = 0.697 of the background.
    TestFrame exact("mlab:format=float32", test::header_of(1, 1, 1, {1, 1, 1}));
    for (int i = 0; i < 200; ++i)
        exact.draw_one(test::fragment_at(0, 0, 0.001f * static_cast<float>(i), 0.0018f, {0, 0, 0}));
    EXPECT_NEAR(exact.color()[0], std::pow(1 - 0.0018, 200), 1e-5);
}

// Bright light is clipped by eight bits when it is stored, and kept by formats that can hold it.
TEST(Mlab, BrightColoursNeedAFormatThatHoldsThem) {
    for (const auto& [format, red] :
         {std::pair{"unorm8", 1.0f}, std::pair{"float16", 10.0f}, std::pair{"rgb9e5", 10.0f}}) {
        TestFrame frame(std::string("mlab:color_format=") + format, test::header_of(1, 1));
        frame.draw_one(test::fragment_at(0, 0, 0.5f, 1, {10, 0, 0}));
        EXPECT_EQ(frame.color()[0], red) << format;
    }
}

// What a fragment at a depth would be seen through: exactly the layers in front while there are enough,
// the stored ones' product after.
TEST(Mlab, VisibilityIsTheStoredLayersInFront) {
    Random random(207);
    for (const int layers : {24, 4}) {
        const auto fragments = test::random_layers(4, 24, random, [&] { return random.real(0, 0.9); });
        TestFrame frame(technique("tail", layers), test::header_of(4, 4));
        frame.draw(fragments);
        ASSERT_TRUE(frame.operation().has_visibility());
        for (int pixel = 0; pixel < 16; ++pixel) {
            const int x = pixel % 4;
            const int y = pixel / 4;
            const LayerList list = test::merged_list(fragments, x, y, static_cast<std::size_t>(layers), true,
                                                     [](const LayerList& l) { return l.size() - 1; });
            std::vector<float> depths = {0, 0.25f, 0.5f, 0.75f, 1};
            depths.push_back(static_cast<float>(list[2].z));  // at a layer's own depth: in front of it
            std::vector<float> values(depths.size());
            frame.operation().visibility(frame.store(), x, y, depths, values);
            for (std::size_t k = 0; k < depths.size(); ++k) {
                double expected = 1;
                for (const auto& l : list) expected *= static_cast<float>(l.z) < depths[k] ? l.t : 1;
                ASSERT_NEAR(values[k], expected, 1e-6) << depths[k];
            }
        }
    }
}

}  // namespace
}  // namespace ropsim
