// Bits a pixel and worst-case bytes a fragment of techniques of stored samples: what their declared formats
// and passes say on paper, counted by hand, against the control paths' own accesses.
#include "tests/rop/worst_case_bytes.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::TestFrame;

struct Expected {
    const char* technique;
    int bits;                   // a pixel
    std::uint64_t read, write;  // bytes a fragment, all passes of one round
};

// Depth is 4 bytes, colour 4, an RGBA16F target 8, total alpha 2. Basic: S depths read, S depths and colours
// written. Depth-based: 2 for total alpha, S depths each way, then S depths and the accumulator read and the
// accumulator written (Enderton et al. 2011, sections 3.4 and 3.5). Laine-Karras: basic, and a bit a sample
// with a 32-bit surface number (2011, section 2).
constexpr Expected kExpected[] = {
    {"stochastic:samples=4", 256, 16, 32},
    {"stochastic:samples=8", 512, 32, 64},
    {"stochastic:samples=16", 1024, 64, 128},
    {"stochastic:samples=8,method=depth_based", 336, 74, 42},
    {"stochastic:samples=16,method=depth_based", 592, 138, 74},
    {"stochastic:samples=24,method=depth_based", 848, 202, 106},
    {"stochastic:samples=16,method=depth_based,passes=merged", 592, 138, 74},
    {"stochastic:samples=8,method=depth_based,total_alpha=sample,accumulator=sample", 896, 144, 112},
    {"stochastic:samples=16,method=depth_based,total_alpha=sample,accumulator=sample", 1792, 288, 224},
    {"laine_karras:samples=8", 552, 37, 69},
    {"laine_karras:samples=16", 1072, 70, 134},
    {"laine_karras:samples=64", 4192, 268, 524},
    {"laine_karras:samples=16,method=depth_based", 640, 144, 80},
};

TEST(StoredSamplesBytes, WorstCaseOfEachPass) {
    for (const Expected& e : kExpected) {
        EXPECT_EQ(test::storage_bits(e.technique), e.bits) << e.technique;
        const auto [read, write] = test::worst_case_bytes(e.technique);
        EXPECT_EQ(read, e.read) << e.technique;
        EXPECT_EQ(write, e.write) << e.technique;
    }
}

// Batcher's odd-even merge sort of 2^p numbers has (p^2 - p + 4) 2^(p-2) - 1 comparators in p (p + 1) / 2
// stages (Knuth, volume 3, 5.3.4). Besides them Laine-Karras compares S depths and S references, and one word
// of coverage for a sample drawn twice.
TEST(StoredSamplesBytes, SortingNetworkOfLaineKarras) {
    for (int p = 2; p <= 5; ++p) {
        const int samples = 1 << p;
        const auto operation =
            TestFrame::make(fmt::format("laine_karras:samples={}", samples), test::header_of(4, 4));
        const CostTable table = operation->cost(test::plain_shape());
        const auto& draw = table[static_cast<std::size_t>(operation->declaration().path("draw"))];
        const int network = (p * p - p + 4) * (1 << p) / 4 - 1;
        EXPECT_EQ(draw.work.units[static_cast<std::size_t>(Unit::kComparator)],
                  static_cast<std::uint32_t>(network + 2 * samples + 1));
        // Four rounds of the hash a sample; the pixel's index times a power of two is a shift.
        EXPECT_EQ(draw.work.units[static_cast<std::size_t>(Unit::kIntegerMultiplier)],
                  static_cast<std::uint32_t>(4 * samples));
    }
}

}  // namespace
}  // namespace ropsim
