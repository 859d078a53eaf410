// Counting bits without the processor's instruction: against the library's, over random words and the
// extremes.
#include "memory/bit_count.h"

#include "base/random.h"

#include <bit>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

std::uint32_t counted(std::uint64_t word) {
    return static_cast<std::uint32_t>(std::popcount(word));
}

TEST(BitCount, IsThatOfTheLibrary) {
    std::uint64_t next = 0;
    // From sparse to dense: the words of one count, and of all four, come near both ends.
    const auto word = [&next](std::uint64_t density) {
        std::uint64_t bits = mix64(++next);
        for (std::uint64_t i = 0; i < density; ++i) bits |= mix64(++next);
        return bits;
    };
    for (std::uint64_t i = 0; i < 20000; ++i) {
        const std::uint64_t a = word(i % 7);
        const std::uint64_t b = word(i % 5);
        const std::uint64_t c = ~word(i % 7);
        const std::uint64_t d = word(i % 3);
        ASSERT_EQ(bits_set(a), counted(a));
        ASSERT_EQ(bits_set(static_cast<std::uint32_t>(b)), counted(static_cast<std::uint32_t>(b)));
        ASSERT_EQ(bits_set(a, b, c, d), counted(a) + counted(b) + counted(c) + counted(d));
    }
    constexpr std::uint64_t kAll = ~std::uint64_t{0};
    EXPECT_EQ(bits_set(kAll, kAll, kAll, kAll), 256u);
    EXPECT_EQ(bits_set(kAll, 0, kAll, 1), 129u);
    EXPECT_EQ(bits_set(0, 0, 0, 0), 0u);
}

}  // namespace
}  // namespace ropsim
