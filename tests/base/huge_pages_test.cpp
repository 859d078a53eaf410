// Memory handed out from slabs: aligned, apart, and there until the slabs go.
#include "base/huge_pages.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

TEST(SlabsTest, PiecesAreAlignedAndApart) {
    Slabs slabs;
    std::vector<std::pair<std::uint32_t*, std::size_t>> pieces;
    // From less than a line to more than the largest slab, 8 MiB in all.
    for (const std::size_t words : {1u, 16u, 17u, 1300u, 20000u, 3u << 19, 5u, 400000u}) {
        pieces.emplace_back(slabs.take(words), words);
        std::fill_n(pieces.back().first, words, static_cast<std::uint32_t>(pieces.size()));
    }
    for (std::size_t p = 0; p < pieces.size(); ++p) {
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(pieces[p].first) % 64, 0u);
        for (std::size_t i = 0; i < pieces[p].second; ++i) ASSERT_EQ(pieces[p].first[i], p + 1) << i;
    }
}

TEST(HugePagesTest, AdviceChangesNothing) {
    std::vector<std::uint8_t> bytes(3 * kHugePage + 5, 7);
    prefer_huge_pages(bytes.data() + 1, bytes.size() - 1);
    prefer_huge_pages(bytes.data(), 0);
    EXPECT_EQ(bytes, std::vector<std::uint8_t>(bytes.size(), 7));
}

}  // namespace
}  // namespace ropsim
