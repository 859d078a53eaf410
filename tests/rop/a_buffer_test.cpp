// The A-buffer's two ways of resolving, its coverage masks, and its pool's ends.
#include "tests/rop/visibility_maps.h"
#include "tests/rop/worst_case_bytes.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Layers;
using test::MapLayer;
using test::Random;
using test::TestFrame;

// About 24 layers a pixel, one in four at the depth of another.
test::MapScene scene_with_ties(std::uint64_t seed) {
    Random random(seed);
    test::MapScene scene{test::opaque_header(7, 6, 1, random), {}, {}};
    test::FragmentOptions options;
    options.count = 1000;
    scene.fragments = test::random_fragments(scene.header, options, random);
    return scene;
}

// Equations 2 and 3 are the same sum: front to back, and as products over the list. Both are the exact image,
// in any order of arrival, ties by arrival.
TEST(ABuffer, IterativeEqualsRecursiveAndBothAreExact) {
    auto scene = scene_with_ties(51);
    Random random(52);
    for (int round = 0; round < 4; ++round) {
        TestFrame recursive("a_buffer:format=float32", scene.header);
        TestFrame iterative("a_buffer:format=float32,resolve=iterative", scene.header);
        recursive.draw(scene.fragments);
        iterative.draw(scene.fragments);
        EXPECT_LT(test::worst_error(recursive, scene.fragments), 1e-6);
        EXPECT_LT(test::worst_error(iterative, scene.fragments), 1e-6);
        random.shuffle(scene.fragments);
    }
}

TEST(ABuffer, IterativeReadsTheListForEachOfItsNodes) {
    for (const std::uint64_t n : {0u, 1u, 7u, 40u}) {
        TestFrame frame("a_buffer:resolve=iterative", test::header_of(1, 1));
        for (std::uint32_t i = 0; i < n; ++i)
            frame.draw_one(test::fragment_at(0, 0, 0.01f * static_cast<float>(i), 0.5f, {1, 1, 1}, i));
        frame.image();
        EXPECT_EQ(frame.log().read_elements(1), n * (n + 1));
        EXPECT_EQ(frame.log().path_steps(2), (std::array<std::uint64_t, 2>{n, n * n}));
    }
}

TEST(ABuffer, TellsExactVisibility) {
    const auto scene = scene_with_ties(53);
    TestFrame frame("a_buffer:format=float32", scene.header);
    frame.draw(scene.fragments);
    const auto layers = test::layers_of(scene.header, scene.fragments, {}, 0, 0, 0);
    std::vector<float> depths = {0, 1};
    for (const MapLayer& l : layers) depths.push_back(static_cast<float>(l.z));
    const auto values = test::visibility_at(frame, depths);
    for (std::size_t i = 0; i < depths.size(); ++i) {
        double product = 1;
        for (const MapLayer& l : layers)
            if (l.z < static_cast<double>(depths[i])) product *= 1 - l.a;
        EXPECT_NEAR(values[i], product, 1e-6);
    }
}

// Coverage masks in the lowest bits of depth: sample by sample in front of that sample's background. Depth
// loses those bits; layers that they would order keep the order of arrival.
TEST(ABuffer, SpatialSamplesAreCompositedOneByOne) {
    for (const int samples : {2, 4, 8}) {
        Random random(54);
        test::MapScene scene = test::map_scene(55, samples);
        // Samples of different backgrounds, and depths some of which differ only in the mask's bits.
        for (float& c : scene.header.opaque->rgb) c = random.real(0, 1);
        const std::uint32_t mask = (1u << samples) - 1;
        for (Fragment& f : scene.fragments)
            if (random.integer(0, 2) == 0)
                f.z = std::bit_cast<float>(std::bit_cast<std::uint32_t>(f.z > 0.3f ? 0.3f : 0.2f) & ~mask) +
                      static_cast<float>(random.integer(0, 1)) * 0x1p-25f;
        for (const char* resolve : {"recursive", "iterative"}) {
            TestFrame frame("a_buffer:format=float32,resolve=" + std::string(resolve), scene.header);
            frame.draw(scene.fragments, scene.slopes);
            const auto image = frame.image();
            for (int pixel = 0; pixel < scene.header.width * scene.header.height; ++pixel) {
                const int x = pixel % scene.header.width;
                const int y = pixel / scene.header.width;
                std::array<double, 3> mean{};
                for (int m = 0; m < samples; ++m) {
                    std::vector<Fragment> own;
                    for (Fragment f : scene.fragments) {
                        if (((f.coverage >> m) & 1) == 0) continue;
                        f.z = std::bit_cast<float>(std::bit_cast<std::uint32_t>(f.z) & ~mask);
                        own.push_back(f);
                    }
                    const float* b =
                        &scene.header.opaque->rgb[static_cast<std::size_t>(3 * (pixel * samples + m))];
                    const auto exact = test::composited(own, x, y, {b[0], b[1], b[2]});
                    for (std::size_t c = 0; c < 3; ++c) mean[c] += exact[c] / samples;
                }
                for (std::size_t c = 0; c < 3; ++c)
                    ASSERT_NEAR(image[static_cast<std::size_t>(3 * pixel) + c], mean[c], 1e-6)
                        << samples << " " << resolve;
            }
        }
    }
    EXPECT_THROW(TestFrame::make("a_buffer", test::header_of(1, 1, 16)), UserError);
}

// A pool of exactly as many nodes as fragments drops none; one node less drops the last. The first node,
// number 0, is a node like the others, and a walk ends after as many as were appended.
TEST(ABuffer, ThePoolEndsWhereItSays) {
    constexpr std::uint32_t kFragments = 5;
    for (const std::uint64_t nodes : {5u, 4u}) {
        TestFrame frame("a_buffer:format=float32", test::header_of(1, 1), 0, nodes);
        std::vector<Fragment> fragments;
        for (std::uint32_t i = 0; i < kFragments; ++i)
            fragments.push_back(
                test::fragment_at(0, 0, 0.9f - 0.1f * static_cast<float>(i), 0.5f, {1, 0.5f, 0}, i));
        frame.draw(fragments);
        EXPECT_EQ(frame.store().pool()->overflowed(), kFragments - nodes);
        EXPECT_EQ(frame.log().path_count(1), kFragments - nodes);
        EXPECT_LT(test::worst_error(frame, std::span(fragments).first(nodes)), 1e-6);
        EXPECT_EQ(frame.log().walk_nodes().size(), nodes);
        EXPECT_EQ(frame.log().walk_nodes().back(), 0u);
    }
}

// What the pool has no room for is blended in order of arrival, behind what it has.
TEST(ABuffer, BlendTailKeepsWhatOverflows) {
    const auto scene = test::map_scene(56);
    constexpr std::size_t kNodes = 400;
    TestFrame frame("a_buffer:format=float32,overflow=blend_tail", scene.header, 0, kNodes);
    frame.draw(scene.fragments);
    // The same fragments, those without a node moved behind all others, each in front of those before it.
    auto moved = scene.fragments;
    for (std::size_t i = kNodes; i < moved.size(); ++i) moved[i].z = 2.0f - 1e-4f * static_cast<float>(i);
    EXPECT_LT(test::worst_error(frame, moved), 1e-5);
    EXPECT_GT(test::worst_error(frame, scene.fragments), 0.1) << "which is not their order";
    TestFrame dropped("a_buffer:format=float32", scene.header, 0, kNodes);
    dropped.draw(scene.fragments);
    EXPECT_LT(test::worst_error(dropped, std::span(scene.fragments).first(kNodes)), 1e-5);
    EXPECT_EQ(test::storage_bits("a_buffer:overflow=blend_tail"), 32 + 64);
}

// 12 bytes of node and 4 of head written, 4 of head read; resolve reads 12 a fragment and traversal.
TEST(ABuffer, Bytes) {
    const auto append = test::worst_case_bytes("a_buffer");
    EXPECT_EQ(append.read, 4u);
    EXPECT_EQ(append.write, 16u);
    EXPECT_EQ(test::storage_bits("a_buffer"), 32);
    const auto declared = TestFrame::make("a_buffer", test::header_of(1, 1))->declaration();
    EXPECT_EQ(declared.surfaces[1].element_bytes(), 12);
}

}  // namespace
}  // namespace ropsim
