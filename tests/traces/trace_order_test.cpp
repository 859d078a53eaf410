// Sorting arrivals: the orders are what they are called, stable, and nothing but the order changes.
#include "traces/trace_order.h"

#include "tests/traces/trace_conversion.h"
#include "traces/stress_traces.h"
#include "traces/trace_header.h"
#include "traces/value_ranges.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <tuple>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

class TraceOrder : public ScratchTest {
 protected:
    void SetUp() override {
        ScratchTest::SetUp();
        options_.depth_levels = 7;  // many ties
        options_.draws = 3;
        options_.slopes = options_.materials = options_.opaque = true;
        options_.count = 20000;
        content_ = random_chunk(options_);
        // So that neither depth nor arrival order sorts by primitive already.
        // Facing, bit 31, takes no part in it.
        for (Fragment& f : content_.fragments)
            f.primitive = (f.primitive * 7919u) % 101u | (f.primitive % 3 == 0 ? kBackFacing : 0);
        write_whole(path("t"), random_header(options_), content_);
    }
    // Sorts by a key with the standard library's stable sort.
    template <typename KeyOf>
    FragmentChunk sorted(KeyOf&& key_of) const {
        std::vector<std::size_t> index(content_.size());
        std::iota(index.begin(), index.end(), std::size_t{0});
        std::stable_sort(index.begin(), index.end(), [&](std::size_t a, std::size_t b) {
            return key_of(content_.fragments[a]) < key_of(content_.fragments[b]);
        });
        FragmentChunk result;
        for (const std::size_t i : index) {
            result.fragments.push_back(content_.fragments[i]);
            result.slopes.push_back(content_.slopes[i]);
            result.materials.push_back(content_.materials[i]);
        }
        return result;
    }
    FragmentChunk ordered(ArrivalOrder order, std::uint64_t seed = 0) {
        order_trace(path("t"), path("o"), order, seed);
        EXPECT_EQ(header_text(TraceReader(path("o")).header(), 8),
                  header_text(TraceReader(path("t")).header(), 8));
        return read_raw(path("o"));
    }

    RandomFragments options_;
    FragmentChunk content_;
};

TEST_F(TraceOrder, SortsAreStable) {
    EXPECT_TRUE(
        same_content(ordered(ArrivalOrder::kNearToFar), sorted([](const Fragment& f) { return f.z; })));
    EXPECT_TRUE(
        same_content(ordered(ArrivalOrder::kFarToNear), sorted([](const Fragment& f) { return -f.z; })));
    EXPECT_TRUE(same_content(ordered(ArrivalOrder::kPrimitive), sorted([](const Fragment& f) {
                                 return std::tuple(f.draw, primitive_number(f));
                             })));
    EXPECT_TRUE(same_content(ordered(ArrivalOrder::kTile),
                             sorted([](const Fragment& f) { return std::tuple(f.y / 8, f.x / 8); })));
}

// One ulp apart is apart, also among denormals.
TEST_F(TraceOrder, NeighbouringDepthsAreToldApart) {
    write_stress_trace("depth_ends", path("t"));
    const FragmentChunk far_first = ordered(ArrivalOrder::kFarToNear);
    for (std::size_t i = 1; i < far_first.size(); ++i)
        ASSERT_GE(far_first.fragments[i - 1].z, far_first.fragments[i].z);
    const FragmentChunk near_first = ordered(ArrivalOrder::kNearToFar);
    for (std::size_t i = 1; i < near_first.size(); ++i)
        ASSERT_LE(near_first.fragments[i - 1].z, near_first.fragments[i].z);
}

TEST_F(TraceOrder, ShuffleKeepsTheOrderOfTies) {
    const FragmentChunk shuffled = ordered(ArrivalOrder::kShuffle, 5);
    EXPECT_FALSE(same_content(shuffled, content_));
    EXPECT_TRUE(same_content(shuffled, ordered(ArrivalOrder::kShuffle, 5)));
    EXPECT_FALSE(same_content(shuffled, ordered(ArrivalOrder::kShuffle, 6)));
    // Grouped by pixel and depth, in arrival order, both hold the same.
    const auto grouped = [](const FragmentChunk& chunk) {
        std::map<std::tuple<int, int, float>, std::vector<std::tuple<std::uint32_t, float, float, float>>>
            groups;
        for (std::size_t i = 0; i < chunk.size(); ++i) {
            const Fragment& f = chunk.fragments[i];
            groups[{f.x, f.y, f.z}].emplace_back(f.primitive, f.r, chunk.slopes[i].dx,
                                                 chunk.materials[i].eta);
        }
        return groups;
    };
    const auto groups = grouped(content_);
    EXPECT_EQ(grouped(shuffled), groups);
    EXPECT_GT(content_.size(), groups.size() * 2);  // there are ties to speak of
}

// Where a fragment ends up is uniform: the mean place of the first half is the middle.
TEST_F(TraceOrder, ShuffleMixes) {
    options_.depth_levels = 0;
    content_ = random_chunk(options_);
    write_whole(path("t"), random_header(options_), content_);
    double sum = 0;
    double squares = 0;
    const FragmentChunk shuffled = ordered(ArrivalOrder::kShuffle);
    for (std::size_t i = 0; i < shuffled.size(); ++i) {
        const double place = static_cast<double>(i) / 20000;
        const bool first_half = shuffled.fragments[i].primitive < 10000;
        sum += first_half ? place : 0;
        squares += first_half ? place * place : 0;
    }
    EXPECT_NEAR(sum / 10000, 0.5, 6 * std::sqrt(1.0 / 12 / 10000));
    EXPECT_NEAR(squares / 10000, 1.0 / 3, 6 * std::sqrt(4.0 / 45 / 10000));
}

TEST_F(TraceOrder, ValuesThatAreNotFiniteAreSortedAndKept) {
    write_stress_trace("non_finite", path("t"));
    const FragmentChunk after = ordered(ArrivalOrder::kNearToFar);
    ASSERT_EQ(after.size(), read_raw(path("t")).size());
    for (std::size_t i = 1; i < after.size(); ++i) {
        Fragment a = after.fragments[i - 1];
        Fragment b = after.fragments[i];
        bring_into_range(a);
        bring_into_range(b);
        ASSERT_LE(a.z, b.z);
    }
    const auto nans = [](const FragmentChunk& chunk) {
        return std::count_if(chunk.fragments.begin(), chunk.fragments.end(),
                             [](const Fragment& f) { return std::isnan(f.z) || std::isnan(f.a); });
    };
    EXPECT_EQ(nans(after), 2);
}

}  // namespace
}  // namespace ropsim
