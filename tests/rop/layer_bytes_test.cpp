// Bits a pixel and worst-case bytes a fragment of techniques of sorted layers, counted by hand, against the
// control paths' own accesses; and what single fragments move.
#include "tests/rop/worst_case_bytes.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

struct Expected {
    const char* technique;
    int bits;                   // a pixel
    std::uint64_t read, write;  // bytes a fragment, all passes
};

// A layer is 8 bytes: depth with RGBA8; without a colour, depth with a 32-bit alpha; with masks, depth, RGB8
// and b bits, or depth and b bits. Counts are 4 bytes, the tail 8, an RGBA16F accumulator 8 and total alpha
// 2, read and written in the first pass. Wyman's normalisation cannot do without total alpha: 112 and 208
// bytes (the accumulator alone) are those of composite=accumulated.
constexpr Expected kExpected[] = {
    {"slab:layers=4", 256, 32, 32},
    {"slab:layers=8", 512, 64, 64},
    {"slab:layers=4,composite=accumulated", 320, 72, 40},
    {"slab:layers=8,composite=accumulated", 576, 136, 72},
    {"slab:layers=4,composite=normalised", 336, 74, 42},
    {"slab:layers=8,composite=normalised", 592, 138, 74},
    {"slab:layers=8,bits=8,coverage=discrete", 512, 64, 64},
    {"slab:layers=8,bits=16,coverage=discrete", 576, 72, 72},
    {"slab:layers=8,bits=8,coverage=discrete,composite=normalised", 400, 90, 50},
    {"slab:layers=8,bits=64,coverage=discrete,composite=normalised", 848, 202, 106},
    {"k_buffer:layers=4", 288, 36, 36},
    {"k_buffer:layers=8", 544, 68, 68},
    {"k_plus_buffer:layers=4", 288, 36, 20},
    {"k_plus_buffer:layers=8", 544, 68, 20},
    {"hybrid:layers=4", 320, 40, 40},
    {"hybrid:layers=8", 576, 72, 72},
};

TEST(LayerBytes, WorstCase) {
    for (const Expected& e : kExpected) {
        EXPECT_EQ(test::storage_bits(e.technique), e.bits) << e.technique;
        const auto [read, write] = test::worst_case_bytes(e.technique);
        EXPECT_EQ(read, e.read) << e.technique;
        EXPECT_EQ(write, e.write) << e.technique;
    }
}

// Bytes of the latest fragment.
test::AccessBytes drawn(TestFrame& frame, const Fragment& fragment) {
    frame.log().clear_records();
    frame.draw_one(fragment);
    return test::bytes_of(frame.declaration(), frame.log().record_access(0));
}
void expect_bytes(TestFrame& frame, float z, std::uint64_t read, std::uint64_t write) {
    const auto bytes = drawn(frame, test::fragment_at(0, 0, z, 0.5f, {1, 1, 1}));
    EXPECT_EQ(bytes.read, read) << z;
    EXPECT_EQ(bytes.write, write) << z;
}

// The k+-buffer reads slot 0 and the count of a fragment it culls or appends, and writes at most two slots.
TEST(LayerBytes, KPlusBufferFragmentByFragment) {
    TestFrame frame("k_plus_buffer:layers=4", test::header_of(1, 1));
    expect_bytes(frame, 0.5f, 12, 12);  // slot 3
    expect_bytes(frame, 0.8f, 12, 12);  // slot 2
    expect_bytes(frame, 0.3f, 12, 12);  // slot 1
    expect_bytes(frame, 0.6f, 36, 20);  // fills: 0.8 goes to slot 0, 0.6 to slot 2
    expect_bytes(frame, 0.9f, 12, 0);   // culled
    expect_bytes(frame, 0.8f, 12, 0);   // culled: not nearer
    expect_bytes(frame, 0.4f, 36, 16);  // 0.8 is gone, 0.6 in slot 0, 0.4 in its slot
    expect_bytes(frame, 0.55f, 36, 8);  // the furthest of all: slot 0 alone
    expect_bytes(frame, 0.56f, 12, 0);
}

// The k-buffer reads everything, and writes from the fragment's place on.
TEST(LayerBytes, KBufferFragmentByFragment) {
    TestFrame frame("k_buffer:layers=4", test::header_of(1, 1));
    expect_bytes(frame, 0.5f, 36, 36);
    expect_bytes(frame, 0.8f, 36, 28);
    expect_bytes(frame, 0.9f, 36, 20);
    expect_bytes(frame, 0.3f, 36, 36);
    expect_bytes(frame, 0.85f, 36, 8);  // full: the count stays
    expect_bytes(frame, 0.85f, 36, 0);  // dropped: the earlier of equal depths stays
}

// Hybrid transparency writes the tail where something falls out or does not get in.
TEST(LayerBytes, HybridFragmentByFragment) {
    TestFrame frame("hybrid:layers=2", test::header_of(1, 1));
    expect_bytes(frame, 0.5f, 24, 16);
    expect_bytes(frame, 0.8f, 24, 8);
    expect_bytes(frame, 0.9f, 24, 8);   // the tail alone
    expect_bytes(frame, 0.7f, 24, 16);  // the last layer and the tail
    expect_bytes(frame, 0.1f, 24, 24);
}

// A fragment without a bit costs stochastic layered alpha blending nothing but its total alpha.
TEST(LayerBytes, SlabOfNoBit) {
    TestFrame frame("slab:layers=8,bits=16", test::header_of(1, 1));
    const auto bytes = drawn(frame, test::fragment_at(0, 0, 0.5f, 0.02f, {1, 1, 1}));
    EXPECT_EQ(bytes.read + bytes.write, 0u);
}

}  // namespace
}  // namespace ropsim
