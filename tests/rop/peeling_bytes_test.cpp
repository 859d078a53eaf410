// What peeling moves: a fragment's bytes at most, and a small scene counted by hand.
#include "tests/rop/counted_passes.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::AccessBytes;
using test::draw_counting;
using test::TestFrame;

// Bytes by surface, of a table's entry or of a log.
std::vector<AccessBytes> surface_bytes(const Declaration& declaration, const PixelAccess& access) {
    std::vector<AccessBytes> bytes;
    for (std::size_t s = 0; s < declaration.surfaces.size(); ++s)
        bytes.push_back({access_bytes(declaration.surfaces[s], access[s].read),
                         access_bytes(declaration.surfaces[s], access[s].write)});
    return bytes;
}
std::vector<AccessBytes> logged_bytes(TestFrame& frame) {
    std::vector<AccessBytes> bytes;
    for (std::size_t s = 0; s < frame.declaration().surfaces.size(); ++s) {
        const auto element = static_cast<std::uint64_t>(frame.declaration().surfaces[s].element_bytes());
        bytes.push_back({frame.log().read_elements(s) * element, frame.log().write_elements(s) * element});
    }
    return bytes;
}
void expect_bytes(const std::vector<AccessBytes>& got, const std::vector<AccessBytes>& expected) {
    ASSERT_EQ(got.size(), expected.size());
    for (std::size_t s = 0; s < got.size(); ++s) {
        EXPECT_EQ(got[s].read, expected[s].read) << "surface " << s;
        EXPECT_EQ(got[s].write, expected[s].write) << "surface " << s;
    }
}

// A layer pass reads two depths and writes one and an RGBA8 colour, on 96 bits; the accumulated colour is 64
// more.
TEST(DepthPeeling, AFragmentReadsAndWritesEightBytesAtMost) {
    TestFrame frame("depth_peeling", test::header_of(1, 1));
    const Declaration& declared = frame.declaration();
    EXPECT_EQ(declared.surfaces[0].bits_per_pixel() + declared.surfaces[1].bits_per_pixel(), 96);
    EXPECT_EQ(declared.storage_bits_per_pixel(), 160);
    const CostTable table = frame.operation().cost(test::plain_shape());
    expect_bytes(surface_bytes(declared, table[0].worst), {{8, 0}, {0, 0}, {0, 0}});
    expect_bytes(surface_bytes(declared, table[1].worst), {{8, 4}, {0, 4}, {0, 0}});
    expect_bytes(surface_bytes(declared, table[2].worst), {{0, 0}, {4, 4}, {8, 8}});
    expect_bytes(surface_bytes(declared, table[3].worst), {{0, 0}, {0, 0}, {8, 0}});
    // The numbers of two layers are stored with their depths.
    TestFrame by_primitive("depth_peeling:ties=primitive", test::header_of(1, 1));
    EXPECT_EQ(by_primitive.declaration().storage_bits_per_pixel(), 160 + 64);
    const CostTable with_order = by_primitive.operation().cost(test::plain_shape());
    expect_bytes(surface_bytes(by_primitive.declaration(), with_order[1].worst),
                 {{8, 4}, {0, 4}, {0, 0}, {8, 4}});
}

// The three targets of a pass, 24 bytes read and written: the range found and the two colours. What that
// count leaves out is the range of the pass before: 8 bytes more read, 64 bits more stored.
TEST(DualDepthPeeling, AFragmentReadsAndWritesThreeTargetsAtMost) {
    TestFrame frame("dual_depth_peeling", test::header_of(1, 1));
    const Declaration& declared = frame.declaration();
    EXPECT_EQ(declared.storage_bits_per_pixel(), 192 + 64);
    const CostTable table = frame.operation().cost(test::plain_shape());
    expect_bytes(surface_bytes(declared, table[0].worst), {{8, 8}, {0, 0}, {0, 0}});      // range
    expect_bytes(surface_bytes(declared, table[1].worst), {{16, 8}, {0, 0}, {0, 0}});     // outside
    expect_bytes(surface_bytes(declared, table[2].worst), {{8 + 8, 8}, {8, 8}, {8, 8}});  // end
    expect_bytes(surface_bytes(declared, table[3].worst), {{16, 8}, {0, 0}, {0, 0}});     // inside
    expect_bytes(surface_bytes(declared, table[4].worst), {{0, 0}, {8, 0}, {8, 0}});      // resolve
}

// Three layers at one pixel, the furthest first, counted by hand.
TEST(Peeling, BytesOfASmallSceneByHand) {
    std::vector<Fragment> fragments;
    for (const float z : {0.75f, 0.5f, 0.25f})
        fragments.push_back(test::fragment_at(0, 0, z, 0.5f, {1, 1, 1}));
    // Four rounds of three fragments read both depths. They keep 3, 2, 1 and 0 fragments: each is nearer than
    // the one before. Four blends read the layer, three of them find one.
    TestFrame front("depth_peeling", test::header_of(1, 1));
    EXPECT_EQ(draw_counting(front, fragments), 4);
    expect_bytes(logged_bytes(front), {{12ull * 8, 6ull * 4}, {4ull * 4, 9ull * 4}, {3ull * 8, 3ull * 8}});
    EXPECT_EQ(front.log().path_count(0), 6u);
    EXPECT_EQ(front.log().path_count(1), 6u);

    // The first pass widens the range three times. The first peel composites both ends and finds the middle,
    // the second empties the range of the first pass and composites the middle: three ends.
    TestFrame both("dual_depth_peeling", test::header_of(1, 1));
    EXPECT_EQ(draw_counting(both, fragments), 3);
    expect_bytes(logged_bytes(both), {{3ull * 8 + 6ull * 16, 5ull * 8}, {2ull * 8, 2ull * 8}, {8, 8}});
    EXPECT_EQ(both.log().path_count(1), 2u);
    EXPECT_EQ(both.log().path_count(2), 3u);
    EXPECT_EQ(both.log().path_count(3), 1u);
}

// Depths that mark what is empty lie outside of [0, 1]: a format that cannot hold them is refused.
TEST(Peeling, DepthFormatsMustHoldTheMarks) {
    for (const char* technique :
         {"depth_peeling:depth_format=unorm24", "dual_depth_peeling:depth_format=unorm24",
          "dual_depth_peeling:depth_format=snorm8"})
        EXPECT_THROW(TestFrame::make(technique, test::header_of(1, 1)), UserError) << technique;
}

}  // namespace
}  // namespace ropsim
