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
        f.primitive = (kFirst + random(2) % primitives) | (random(4) % 2 == 0 ? kBackFacing : 0);
        f.z = random_unit(mix64(i), 3);
        f.a = 0.5f;
        f.coverage = 1;
        f.draw = 3;
    }
    return fragments;
}

std::vector<Fragment> expected_order(std::vector<Fragment> fragments) {
    std::sort(fragments.begin(), fragments.end(), [](const Fragment& a, const Fragment& b) {
        const auto key = [](const Fragment& f) {
            return std::make_tuple(primitive_number(f), f.y / 8, f.x / 8, f.y % 8 / 2, f.x % 8 / 2, f.y % 2,
                                   f.x % 2, f.z);
        };
        return key(a) < key(b);
    });
    return fragments;
}

FragmentRecords records_of(const std::vector<Fragment>& fragments) {
    FragmentRecords records;
    records.words.resize(8 * fragments.size());
    if (!fragments.empty())
        std::memcpy(records.words.data(), fragments.data(), fragments.size() * sizeof(Fragment));
    return records;
}

// A record of one sample (its bit) or of the centre (0), with the plane z(x, y) = z + dx x + dy y.
void add_record(FragmentRecords& records, Fragment fragment, DepthSlope slope) {
    std::uint32_t words[10];
    std::memcpy(words, &fragment, sizeof fragment);
    std::memcpy(words + 8, &slope, sizeof slope);
    records.slopes = true;
    records.words.insert(records.words.end(), words, words + 10);
}

TEST(FragmentOrderTest, EqualsAPlainSortForAnyThreadsAndArrival) {
    // From one fragment a primitive to all in one; the latter repeats pixels, which are then ordered by
    // value.
    for (std::uint32_t primitives : {1u, 7u, 5000u, 400000u}) {
        std::vector<Fragment> fragments = random_fragments(30000, primitives);
        const std::vector<Fragment> expected = expected_order(fragments);
        for (int threads : {1, 2, 5}) {
            FragmentOrder order(kWidth, 1, threads);
            std::reverse(fragments.begin(), fragments.end());
            const std::vector<Fragment>& ordered =
                order.sort(records_of(fragments), kFirst, primitives).fragments;
            ASSERT_EQ(ordered.size(), expected.size());
            EXPECT_EQ(std::memcmp(ordered.data(), expected.data(), expected.size() * sizeof(Fragment)), 0)
                << primitives << " primitives, " << threads << " threads";
        }
    }
}

TEST(FragmentOrderTest, ReusedAfterALargerPieceForgetsIt) {
    FragmentOrder order(kWidth, 1, 2);
    order.sort(records_of(random_fragments(5000, 900)), kFirst, 900);
    const std::vector<Fragment> few = random_fragments(10, 3);
    EXPECT_EQ(order.sort(records_of(few), kFirst, 3).size(), 10u);
    EXPECT_TRUE(order.sort({}, kFirst, 3).empty());
}

TEST(FragmentOrderTest, RecordsOfAPixelBecomeOneFragmentShadedAtTheCentreOrTheFirstSample) {
    const DepthSlope slope{0.0625f, -0.125f};
    const auto record = [](int x, std::uint32_t primitive, unsigned coverage, float z, float a) {
        Fragment f{};
        f.x = static_cast<std::uint16_t>(x);
        f.primitive = primitive;
        f.coverage = static_cast<std::uint16_t>(coverage);
        f.z = z;
        f.a = a;
        return f;
    };
    FragmentRecords records;
    add_record(records, record(5, 1, 0b0100, 0.5f, 0.3f), slope);  // samples 2 and 1, centre missed
    add_record(records, record(4, 1, 0b1000, 0.9f, 0.8f), slope);  // centre and sample 3
    add_record(records, record(5, 1, 0b0010, 0.25f, 0.2f), slope);
    add_record(records, record(4, 1, 0, 0.625f, 0.7f), slope);
    add_record(records, record(9, 1, 0, 0.5f, 0.9f), slope);       // the centre alone
    add_record(records, record(4, 0, 0b0001, 0.5f, 0.6f), slope);  // another primitive
    for (int threads : {1, 3}) {
        FragmentOrder order(kWidth, 4, threads);
        const FragmentChunk& chunk = order.sort(records, 0, 3);
        ASSERT_EQ(chunk.size(), 3u);
        ASSERT_EQ(chunk.slopes.size(), 3u);
        const std::vector<Fragment>& f = chunk.fragments;
        EXPECT_EQ(f[0].primitive, 0u);
        EXPECT_EQ(f[0].coverage, 0b0001);
        // Sample 0 lies at (-2, -6) / 16 from the centre.
        EXPECT_FLOAT_EQ(f[0].z, 0.5f - 0.0625f * (-2 / 16.0f) + 0.125f * (-6 / 16.0f));
        EXPECT_EQ(f[1].x, 4);
        EXPECT_EQ(f[1].coverage, 0b1000);
        EXPECT_EQ(f[1].a, 0.7f) << "shaded at the centre";
        EXPECT_EQ(f[1].z, 0.625f);
        EXPECT_EQ(f[2].x, 5);
        EXPECT_EQ(f[2].coverage, 0b0110);
        EXPECT_EQ(f[2].a, 0.2f) << "shaded at sample 1";
        EXPECT_FLOAT_EQ(f[2].z, 0.25f - 0.0625f * (6 / 16.0f) + 0.125f * (-2 / 16.0f));
        EXPECT_EQ(chunk.slopes[2].dy, -0.125f);
    }
}

TEST(FragmentOrderDeathTest, PrimitiveOutsideThePieceIsOurMistake) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    FragmentOrder order(kWidth, 1, 1);
    EXPECT_DEATH(order.sort(records_of(random_fragments(100, 50)), kFirst, 10), "primitive");
}

}  // namespace
}  // namespace ropsim
