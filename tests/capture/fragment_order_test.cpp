// FragmentOrder against a plain sort with the order spelled out.
#include "capture/fragment_order.h"

#include "base/random.h"

#include <algorithm>
#include <cstring>
#include <tuple>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr int kWidth = 203;
constexpr std::uint32_t kFirst = 1000;

std::vector<Fragment> random_fragments(std::size_t count, std::uint32_t primitives) {
    std::vector<Fragment> fragments(count);
    for (std::size_t i = 0; i < count; ++i) {
        Fragment& f = fragments[i];
        const auto random = [&](std::uint32_t draw) { return random_bits(mix64(i), draw); };
        f = {};
        f.x = static_cast<std::uint16_t>(random(0) % kWidth);
        f.y = static_cast<std::uint16_t>(random(1) % 97);
        f.primitive = kFirst + random(2) % primitives;
        f.z = random_unit(mix64(i), 3);
        f.a = 0.5f;
    }
    return fragments;
}

std::vector<Fragment> expected_order(std::vector<Fragment> fragments) {
    std::sort(fragments.begin(), fragments.end(), [](const Fragment& a, const Fragment& b) {
        const auto key = [](const Fragment& f) {
            return std::make_tuple(f.primitive, f.y / 8, f.x / 8, f.y % 8 / 2, f.x % 8 / 2, f.y % 2, f.x % 2,
                                   f.z);
        };
        return key(a) < key(b);
    });
    for (Fragment& f : fragments) {
        f.coverage = 1;
        f.draw = 3;
    }
    return fragments;
}

TEST(FragmentOrderTest, EqualsAPlainSortForAnyThreadsAndArrival) {
    // From one fragment a primitive to all in one; the latter repeats pixels, which are then ordered by
    // value.
    for (std::uint32_t primitives : {1u, 7u, 5000u, 400000u}) {
        std::vector<Fragment> fragments = random_fragments(30000, primitives);
        const std::vector<Fragment> expected = expected_order(fragments);
        for (int threads : {1, 2, 5}) {
            FragmentOrder order(kWidth, threads);
            std::reverse(fragments.begin(), fragments.end());
            const std::vector<Fragment>& ordered = order.sort(fragments, kFirst, primitives, 3);
            ASSERT_EQ(ordered.size(), expected.size());
            EXPECT_EQ(std::memcmp(ordered.data(), expected.data(), expected.size() * sizeof(Fragment)), 0)
                << primitives << " primitives, " << threads << " threads";
        }
    }
}

TEST(FragmentOrderTest, ReusedAfterALargerPieceForgetsIt) {
    FragmentOrder order(kWidth, 2);
    order.sort(random_fragments(5000, 900), kFirst, 900, 0);
    const std::vector<Fragment> few = random_fragments(10, 3);
    EXPECT_EQ(order.sort(few, kFirst, 3, 0).size(), 10u);
    EXPECT_TRUE(order.sort({}, kFirst, 3, 0).empty());
}

TEST(FragmentOrderDeathTest, PrimitiveOutsideThePieceIsOurMistake) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    FragmentOrder order(kWidth, 1);
    EXPECT_DEATH(order.sort(random_fragments(100, 50), kFirst, 10, 0), "primitive");
}

}  // namespace
}  // namespace ropsim
