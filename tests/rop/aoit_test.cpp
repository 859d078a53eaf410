// Intel's one-pass AOIT: what its truncation does, and that it is multi-layer alpha blending in other
// clothes.
#include "tests/rop/layer_lists.h"
#include "tests/rop/worst_case_bytes.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

enum Path : std::size_t { kFirst, kInsert, kInsertMerge, kResolve, kResolveClear };

TestFrame frame_of(const std::string& parameters, int side = 1,
                   glm::vec3 background = {0.25f, 0.5f, 0.125f}) {
    return {"aoit:" + parameters, test::header_of(side, side, 1, background)};
}

// Bits a pixel, and the bytes of the operation that moves most: nodes and control word read, nodes written.
// (The first fragment reads the control word alone and writes both. Adding each surface's own worst case, as
// `worst_case_bytes` does, counts the control word's write on top.)
TEST(Aoit, ClaimedStorageAndTraffic) {
    struct Row {
        int nodes, bits;
        std::uint64_t read, write;
    };
    for (const Row& row : {Row{2, 160, 20, 16}, Row{4, 288, 36, 32}, Row{8, 544, 68, 64}}) {
        const std::string text = "aoit:nodes=" + std::to_string(row.nodes);
        EXPECT_EQ(test::storage_bits(text), row.bits);
        const auto operation = TestFrame::make(text, test::header_of(1, 1));
        const CostTable table = operation->cost(test::plain_shape());
        for (const std::size_t path : {kInsert, kInsertMerge}) {
            const auto bytes = test::bytes_of(operation->declaration(), table[path].worst.data());
            EXPECT_EQ(bytes.read, row.read) << table[path].name;
            EXPECT_EQ(bytes.write, row.write) << table[path].name;
        }
        const auto first = test::bytes_of(operation->declaration(), table[kFirst].worst.data());
        EXPECT_EQ(first.read, 4u);
        EXPECT_EQ(first.write, row.write + 4);
        EXPECT_EQ(test::worst_case_bytes(text).write, row.write + 4);
        EXPECT_EQ(test::bytes_of(operation->declaration(), table[kResolveClear].worst.data()).read, 4u);
    }
}

TEST(Aoit, ExactWhileNodesSuffice) {
    Random random(211);
    const TraceHeader header = test::opaque_header(9, 7, 1, random);
    test::FragmentOptions options;
    options.count = 800;
    options.distinct_depths = true;
    options.most_in_a_pixel = 16;
    const auto fragments = test::random_fragments(header, options, random);
    TestFrame frame("aoit:nodes=16,format=float32", header);
    frame.draw(fragments);
    EXPECT_EQ(frame.log().path_count(kInsertMerge), 0u);
    EXPECT_LT(test::worst_error(frame, fragments), 1e-6);
}

TEST(Aoit, ExactForSortedArrivalInEitherDirection) {
    Random random(212);
    auto fragments = test::random_layers(8, 60, random, [&] { return random.real(0, 0.3); });
    for (const int direction : {1, -1}) {
        std::ranges::sort(fragments, {},
                          [&](const Fragment& f) { return static_cast<float>(direction) * f.z; });
        for (const int nodes : {2, 4, 8}) {
            TestFrame frame = frame_of("format=float32,nodes=" + std::to_string(nodes), 8);
            frame.draw(fragments);
            EXPECT_LT(test::worst_error(frame, fragments), 1e-5)
                << nodes << " nodes, direction " << direction;
        }
    }
}

// The same layers, with transmittances from the eye instead of each one's own.
TEST(Aoit, IsMultiLayerAlphaBlendingUpToRounding) {
    Random random(213);
    const auto fragments = test::random_layers(8, 60, random, [&] { return random.real(0, 0.5); });
    for (const int count : {2, 3, 8}) {
        TestFrame aoit = frame_of("format=float32,nodes=" + std::to_string(count), 8);
        TestFrame mlab("mlab:format=float32,layers=" + std::to_string(count), test::header_of(8, 8));
        aoit.draw(fragments);
        mlab.draw(fragments);
        EXPECT_GT(test::worst_error(aoit, fragments), 0.01);
        const auto a = aoit.image();
        const auto b = mlab.image();
        for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 1e-5) << count;
    }
}

float transmittance_of_thin_layers(const std::string& parameters, int layers, float alpha) {
    TestFrame frame = frame_of(parameters, 1, {1, 1, 1});
    Random random(214);
    for (int i = 0; i < layers; ++i)
        frame.draw_one(test::fragment_at(0, 0, random.real(0, 1), alpha, {0, 0, 0}));
    return frame.color()[0];
}

// Every insertion behind or in front takes one of 255 steps of what is left, however thin the fragment: the
// first rounds to 1, each of the other 199 truncates. 56/255 = .22 for 0.9982^200 = .70. Rounding to nearest
// stalls at 1 instead: eight bits cannot say it either way, sixteen can.
TEST(Aoit, TruncationTakesAStepForEveryLayer) {
    EXPECT_NEAR(transmittance_of_thin_layers("image_format=float32", 200, 0.0018f), 56 / 255.0, 1e-6);
    EXPECT_EQ(transmittance_of_thin_layers("transmittance_rounding=nearest", 200, 0.0018f), 1.0f);
    EXPECT_EQ(transmittance_of_thin_layers("", 300, 1e-4f), 0.0f) << "black behind 300 layers of nothing";
    const double exact = std::pow(1 - 0.0018, 200);
    EXPECT_NEAR(transmittance_of_thin_layers("format=float32", 200, 0.0018f), exact, 1e-5);
    const float sixteen = transmittance_of_thin_layers("transmittance_format=unorm16", 200, 0.0018f);
    EXPECT_LT(sixteen, exact);
    EXPECT_GT(sixteen, exact - 200 / 65535.0 - 5e-4);
}

// An opaque node in front: the published code multiplies 0 by 1 / 0 and clamps the NaN to black. Here what
// nothing can be seen of keeps its colour; either way it is not seen.
TEST(Aoit, NothingBehindAnOpaqueNodeIsNotANumber) {
    for (const char* format : {"", "format=float32,"})
        for (const int nodes : {2, 3, 4}) {
            TestFrame frame = frame_of(format + std::string("nodes=") + std::to_string(nodes));
            frame.draw_one(test::fragment_at(0, 0, 0.1f, 1, {1, 0.2f, 0}));
            for (int i = 1; i <= 12; ++i)
                frame.draw_one(
                    test::fragment_at(0, 0, 0.1f + 0.05f * static_cast<float>(i * 7 % 13), 0.5f, {0, 0, 1}));
            EXPECT_EQ(frame.log().path_count(kInsertMerge), static_cast<std::uint64_t>(13 - nodes));
            const auto color = frame.color();
            EXPECT_EQ(color[0], 1.0f);
            EXPECT_NEAR(color[1], 0.2, 1e-3);
            EXPECT_EQ(color[2], 0.0f) << format << nodes;
        }
}

// The control word: an untouched pixel is read by four bytes, and the first fragment reads no node.
TEST(Aoit, TheFirstFragmentFindsTheNodesUncleared) {
    TestFrame frame = frame_of("nodes=4,format=float32", 2);
    // Whatever an earlier frame left in the nodes.
    const Surface& nodes = frame.declaration().surfaces[0];
    for (int w = 0; w < nodes.words; ++w)
        frame.store().pixel(0, 0)[nodes.first_word + w] = std::bit_cast<std::uint32_t>(0.125f);
    EXPECT_EQ(frame.color(0, 0), (std::array<float, 3>{0.25f, 0.5f, 0.125f}));
    EXPECT_EQ(frame.log().path_count(kResolveClear), 4u);
    const std::vector<Fragment> fragments = {test::fragment_at(0, 0, 0.5f, 0.5f, {1, 0, 0}),
                                             test::fragment_at(0, 0, 0.25f, 0.25f, {0, 1, 0})};
    frame.draw(fragments);
    EXPECT_EQ(frame.log().path_count(kFirst), 1u);
    EXPECT_EQ(frame.log().path_count(kInsert), 1u);
    EXPECT_LT(test::worst_error(frame, fragments), 1e-6);
}

TEST(Aoit, TruncationNeedsSteps) {
    EXPECT_THROW(frame_of("format=float32,transmittance_rounding=down"), UserError);
    EXPECT_NO_THROW(frame_of("format=float32,transmittance_format=unorm16,transmittance_rounding=down"));
}

TEST(Aoit, VisibilityIsTheTransmittanceInFront) {
    Random random(215);
    const auto fragments = test::random_layers(4, 24, random, [&] { return random.real(0, 0.6); });
    TestFrame frame = frame_of("nodes=4,format=float32", 5);
    frame.draw(fragments);
    const std::vector<float> depths = {0, 0.25f, 0.5f, 0.75f, 1};
    std::vector<float> values(depths.size());
    for (int pixel = 0; pixel < 16; ++pixel) {
        const auto list = test::merged_list(fragments, pixel % 4, pixel / 4, 4, true,
                                            [](const test::LayerList& l) { return l.size() - 1; });
        frame.operation().visibility(frame.store(), pixel % 4, pixel / 4, depths, values);
        for (std::size_t k = 0; k < depths.size(); ++k) {
            double expected = 1;
            for (const auto& l : list) expected *= l.z < depths[k] ? l.t : 1;
            ASSERT_NEAR(values[k], expected, 1e-6) << depths[k];
        }
    }
    frame.operation().visibility(frame.store(), 4, 4, depths, values);
    for (const float value : values) EXPECT_EQ(value, 1.0f) << "nothing has been drawn there";
}

}  // namespace
}  // namespace ropsim
