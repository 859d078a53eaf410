// Memory and bandwidth of adaptive transparency against Salvi et al. 2011: table 1, figure 10, and what each
// kind of memory reads and writes.
#include "tests/rop/random_fragments.h"
#include "tests/rop/worst_case_bytes.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

constexpr double kMegabyte = 1048576;
constexpr double kPixels = 1280.0 * 720;

// Bytes of a list's node and of a pixel's head, as declared.
struct ListBytes {
    int node = 0;
    int pixel = 0;
};
ListBytes list_bytes(const std::string& technique, int spatial_samples) {
    const auto operation = TestFrame::make(technique, test::header_of(4, 4, spatial_samples));
    ListBytes bytes;
    for (const Surface& s : operation->declaration().surfaces)
        if (s.layout == Layout::kPool) bytes.node = s.element_bytes();
    bytes.pixel = operation->declaration().storage_bits_per_pixel() / 8;
    return bytes;
}
double megabytes(const ListBytes& bytes, double fragments, bool with_heads) {
    return (fragments * bytes.node + (with_heads ? kPixels * bytes.pixel : 0)) / kMegabyte;
}

// Table 1, variable memory. Fragments are printed to .1 or .01 million: the printed size must be among what
// that can mean. SMOKE, HAIR and FOREST are nodes and heads; POWER PLANT comes out without the heads only.
TEST(AdaptiveTable1, VariableMemory) {
    for (const char* technique : {"adaptive:memory=variable", "a_buffer"}) {
        const ListBytes bytes = list_bytes(technique, 1);
        EXPECT_EQ(bytes.node, 12) << technique;
        EXPECT_EQ(bytes.pixel, 4) << technique;
        const auto expect_printed = [&](double millions, double half_digit, double printed, bool heads) {
            EXPECT_GE(printed + 0.05, megabytes(bytes, 1e6 * (millions - half_digit), heads)) << millions;
            EXPECT_LE(printed - 0.05, megabytes(bytes, 1e6 * (millions + half_digit), heads)) << millions;
        };
        expect_printed(10.6, 0.05, 125.4, true);  // 124.2 to 125.4: its last
        expect_printed(15.0, 0.05, 174.6, true);  // 174.6 to 175.7: its first
        expect_printed(6.0, 0.05, 72.6, true);
        expect_printed(2.69, 0.005, 30.8, false);
        expect_printed(3.47, 0.005, 39.7, false);  // 4 samples
        EXPECT_NEAR(megabytes(bytes, 2.69e6, true), 34.30, 0.005) << "with heads, printed 30.8";
        EXPECT_NEAR(megabytes(bytes, 3.47e6, true), 43.23, 0.005) << "with heads, printed 39.7";
    }
}

TEST(AdaptiveTable1, CoverageIsInTheDepth) {
    EXPECT_EQ(list_bytes("adaptive:memory=variable", 4).node, 12);
    EXPECT_EQ(list_bytes("adaptive:memory=variable", 4).pixel, 4);
}

// Depth-based stochastic transparency keeps depths a stored sample, and total alpha and colour with their
// weight a pixel, or as often as there are spatial samples (Salvi et al., section 4.2). The technique here
// keeps the latter once, or once a stored sample: what one costs follows from both.
struct OnceAndEach {
    double depths = 0;  // all of them
    double one_color = 0;
};
template <class Measure>
OnceAndEach stochastic_parts(int samples, Measure measure) {
    const std::string base = fmt::format("stochastic:method=depth_based,samples={}", samples);
    const double once = measure(base);
    const double each = measure(base + ",total_alpha=sample,accumulator=sample");
    const double one_color = (each - once) / (samples - 1);
    return {once - one_color, one_color};
}

// Table 1, stochastic transparency: 4 S + 10 M bytes a pixel. 8 samples in FOREST, 16 in HAIR (whose text
// says 24) and POWER PLANT. SMOKE's 93.8 is no number of samples: 24 give 93.16.
TEST(AdaptiveTable1, StochasticTransparency) {
    const auto size = [](int samples, int spatial) {
        const OnceAndEach bits = stochastic_parts(
            samples, [](const std::string& technique) { return test::storage_bits(technique); });
        EXPECT_EQ(bits.depths, 8 * 4 * samples);
        EXPECT_EQ(bits.one_color, 8 * 10);
        return kPixels * (bits.depths + spatial * bits.one_color) / 8 / kMegabyte;
    };
    EXPECT_NEAR(size(8, 1), 36.9, 0.05);
    EXPECT_NEAR(size(16, 1), 65.0, 0.05);
    EXPECT_NEAR(size(16, 4), 91.4, 0.05);
    EXPECT_NEAR(size(24, 1), 93.16, 0.005);
    EXPECT_LT(size(24, 1), 93.75) << "SMOKE's 93.8";
    EXPECT_GT(size(25, 1), 93.85);
}

// Fixed memory: 8 bytes a node and RGBA16F; read and written by the first pass, read by the second with the
// colour read and written.
TEST(AdaptiveBytes, FixedMemoryByNodes) {
    for (const auto& [nodes, bits, total] :
         {std::array{4, 320, 112}, {8, 576, 208}, {16, 1088, 400}, {24, 1600, 592}}) {
        for (const char* memory : {"fixed", "shader"}) {
            for (const char* layout : {"interleaved", "planar"}) {
                const std::string technique =
                    fmt::format("adaptive:nodes={},memory={},layout={}", nodes, memory, layout);
                EXPECT_EQ(test::storage_bits(technique), bits) << technique;
                const auto bytes = test::worst_case_bytes(technique);
                EXPECT_EQ(bytes.read, static_cast<std::uint64_t>(2 * 8 * nodes + 8)) << technique;
                EXPECT_EQ(bytes.write, static_cast<std::uint64_t>(8 * nodes + 8)) << technique;
                EXPECT_EQ(bytes.read + bytes.write, static_cast<std::uint64_t>(total)) << technique;
            }
        }
    }
}

// A fragment of a list: head read and written, node written; at resolve the node is read twice.
std::uint64_t list_fragment_bytes(const std::string& technique, int spatial_samples) {
    const auto append = test::worst_case_bytes(technique, spatial_samples);
    TestFrame frame(technique, test::header_of(1, 1, spatial_samples));
    for (int i = 0; i < 10; ++i)
        frame.draw_one(test::fragment_at(0, 0, 0.05f * static_cast<float>(i), 0.5f, {1, 1, 1}));
    frame.image();
    std::uint64_t node_reads = 0;
    for (std::size_t s = 0; s < frame.declaration().surfaces.size(); ++s)
        if (frame.declaration().surfaces[s].layout == Layout::kPool)
            node_reads = frame.log().read_elements(s) *
                         static_cast<std::uint64_t>(frame.declaration().surfaces[s].element_bytes());
    return append.read + append.write + node_reads / 10;
}

// Figure 10's order of lines: variable memory, 8 nodes, 16 stochastic samples, at one sample a pixel and at
// four, where total transmittance and colour are kept a sample.
TEST(AdaptiveBytes, Figure10) {
    const auto worst = [](const std::string& technique, int spatial) {
        const auto bytes = test::worst_case_bytes(technique, spatial);
        return bytes.read + bytes.write;
    };
    const OnceAndEach stochastic =
        stochastic_parts(16, [&](const std::string& technique) { return worst(technique, 1); });
    EXPECT_EQ(list_fragment_bytes("adaptive:memory=variable", 1), 44u);
    EXPECT_EQ(worst("adaptive:nodes=8", 1), 208u);
    EXPECT_EQ(stochastic.depths + stochastic.one_color, 212);
    EXPECT_EQ(list_fragment_bytes("adaptive:memory=variable", 4), 44u);
    EXPECT_EQ(worst("adaptive:nodes=8", 4), 256u);
    EXPECT_EQ(worst("adaptive:nodes=8,memory=shader", 4), 256u);
    EXPECT_EQ(stochastic.depths + 4 * stochastic.one_color, 272);
}

// The framebuffer operation writes the nodes that change; a shader's write-back is the whole array.
TEST(AdaptiveBytes, AShaderWritesEveryNodeEachTime) {
    Random random(31);
    const TraceHeader header = test::header_of(8, 8);
    test::FragmentOptions options;
    options.count = 3000;
    const auto fragments = test::random_fragments(header, options, random);
    TestFrame fixed("adaptive:nodes=8", header);
    TestFrame shader("adaptive:nodes=8,memory=shader", header);
    fixed.draw(fragments);
    shader.draw(fragments);
    EXPECT_EQ(fixed.image(), shader.image());
    EXPECT_EQ(shader.log().write_elements(0), 8u * fragments.size());
    EXPECT_LT(fixed.log().write_elements(0), 7u * fragments.size());
    EXPECT_EQ(fixed.log().read_elements(0), shader.log().read_elements(0));
}

// The same function from lists, which are walked from the latest arrival to the first.
TEST(AdaptiveVariable, IsFixedMemoryFedInTheOppositeOrder) {
    for (const char* rules :
         {"nodes=4", "nodes=8,removal=node_by_node", "nodes=5,removal=overestimate,composite=normalised",
          "nodes=6,equal_depth=merge", "nodes=8,equal_depth=behind,candidates=protect_front_half"}) {
        Random random(32);
        const TraceHeader header = test::opaque_header(7, 6, 1, random);
        test::FragmentOptions options;
        options.count = 1200;
        auto fragments = test::random_fragments(header, options, random);
        TestFrame variable(fmt::format("adaptive:format=float32,memory=variable,{}", rules), header);
        variable.draw(fragments);
        std::ranges::reverse(fragments);
        TestFrame fixed(fmt::format("adaptive:format=float32,{}", rules), header);
        fixed.draw(fragments);
        EXPECT_EQ(variable.image(), fixed.image()) << rules;
    }
}

// One geometry pass; each node is fetched by both traversals, each of which takes a step a fragment.
TEST(AdaptiveVariable, TraversesListsTwice) {
    TestFrame frame("adaptive:memory=variable", test::header_of(1, 1));
    EXPECT_EQ(frame.passes(), 1);
    for (std::uint32_t i = 0; i < 5; ++i)
        frame.draw_one(test::fragment_at(0, 0, 0.1f * static_cast<float>(i), 0.5f, {1, 1, 1}, i));
    frame.image();
    EXPECT_EQ(frame.log().walk_nodes(), (std::vector<std::uint32_t>{4, 3, 2, 1, 0, 4, 3, 2, 1, 0}));
    EXPECT_EQ(frame.log().path_steps(2), (std::array<std::uint64_t, 2>{5, 5}));
    EXPECT_EQ(test::storage_bits("adaptive:memory=variable,nodes=64"), 32) << "the curve takes no memory";
}

// A full pool drops the latest; the rest is composited.
TEST(AdaptiveVariable, AFullPoolDropsTheLatest) {
    TestFrame frame("adaptive:memory=variable,format=float32", test::header_of(1, 1, 1, {1, 1, 1}), 0, 6);
    std::vector<Fragment> fragments;
    for (int i = 0; i < 10; ++i)
        fragments.push_back(test::fragment_at(0, 0, 0.05f * static_cast<float>(i), 0.5f, {0, 0, 0}));
    frame.draw(fragments);
    EXPECT_EQ(frame.store().pool()->overflowed(), 4u);
    EXPECT_EQ(frame.log().path_count(1), 4u);
    EXPECT_EQ(frame.color()[0], 0x1p-6f);
}

}  // namespace
}  // namespace ropsim
