// Stochastic layered alpha blending: equation 1 of Wyman 2016 reached through the operation, its dependence
// on order, and its k-buffer end.
#include "tests/rop/random_fragments.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

enum Path : std::size_t { kBehindFullList, kInsert, kResolve, kDiscard };

// Equation 1 by counting: of the (b choose t) masks of t bits, those that do not all fall on the s bits
// already set.
double visible_probability(int b, int s, int t) {
    return 1 - test::binomial(s, t) / test::binomial(b, t);
}

// How many of side * side pixels insert a fragment of alpha t / b behind one layer of alpha s / b.
std::uint64_t inserted(int b, int s, int t, int side) {
    TestFrame frame("slab:format=float32,layers=4,bits=" + std::to_string(b), test::header_of(side, side), 3);
    std::vector<Fragment> front;
    std::vector<Fragment> behind;
    for (int i = 0; i < side * side; ++i) {
        const auto alpha = [&](int count) { return static_cast<float>(count) / static_cast<float>(b); };
        front.push_back(test::fragment_at(i % side, i / side, 0.25f, alpha(s), {1, 0, 0}, 0));
        behind.push_back(test::fragment_at(i % side, i / side, 0.75f, alpha(t), {0, 1, 0}, 1));
    }
    if (s > 0) frame.draw(front);
    const std::uint64_t before = frame.log().path_count(kInsert);
    EXPECT_EQ(before, s > 0 ? front.size() : 0u)
        << "with nothing in front, every fragment with a bit is inserted";
    frame.draw(behind);
    return frame.log().path_count(kInsert) - before;
}

void expect_probability(int b, int s, int t, int side, double p) {
    const double n = side * side;
    const auto count = static_cast<double>(inserted(b, s, t, side));
    // 4.5 standard deviations of the binomial count (and one, for probabilities of nearly 0 or 1).
    EXPECT_NEAR(count, n * p, 4.5 * std::sqrt(n * p * (1 - p)) + (p > 0 && p < 1 ? 1 : 0))
        << "P_" << b << "(" << s << "," << t << ")";
}

TEST(EquationOne, PrintedValues) {
    struct Value {
        int b, s, t;
        double p;
    };
    for (const Value& v : {Value{4, 2, 2, .83333}, Value{8, 4, 2, .78571}, Value{8, 6, 3, .64286},
                           Value{16, 12, 4, .72802}, Value{16, 8, 8, .99992}}) {
        EXPECT_NEAR(visible_probability(v.b, v.s, v.t), v.p, 5e-6);
        expect_probability(v.b, v.s, v.t, 300, visible_probability(v.b, v.s, v.t));
    }
}

TEST(EquationOne, EveryCountOfEightBits) {
    for (int s = 0; s <= 8; ++s)
        for (int t = 0; t <= 8; ++t)
            expect_probability(8, s, t, 64, t > s ? 1.0 : visible_probability(8, s, t));
}

// Counts are rounded to nearest: alpha 0.43 of 4 bits is 2 bits (1.72), 0.37 one (1.48).
TEST(EquationOne, AlphasRoundToNearestCount) {
    constexpr int kSide = 200;
    for (const auto& [alpha, bits] : {std::pair{0.43f, 2}, std::pair{0.37f, 1}}) {
        TestFrame frame("slab:format=float32,layers=4,bits=4", test::header_of(kSide, kSide), 4);
        for (int layer = 0; layer < 2; ++layer) {
            std::vector<Fragment> fragments;
            for (int i = 0; i < kSide * kSide; ++i)
                fragments.push_back(test::fragment_at(i % kSide, i / kSide, layer == 0 ? 0.25f : 0.75f,
                                                      layer == 0 ? 0.5f : alpha, {1, 1, 1},
                                                      static_cast<std::uint32_t>(layer)));
            frame.draw(fragments);
        }
        const double n = kSide * kSide;
        const double p = visible_probability(4, 2, bits);
        EXPECT_NEAR(static_cast<double>(frame.log().path_count(kInsert)) - n, n * p,
                    4 * std::sqrt(n * p * (1 - p)))
            << alpha;
    }
}

// The layers in front act together: 1 - (1 - 0.5)(1 - 0.5) = 0.75 of 8 bits is 6. The layer behind does not.
TEST(EquationOne, AccumulatesTheLayersInFrontOnly) {
    constexpr int kSide = 200;
    TestFrame frame("slab:format=float32,layers=4,bits=8", test::header_of(kSide, kSide), 5);
    const std::array<std::pair<float, float>, 4> layers = {
        {{0.9f, 0.125f},
         {0.25f, 0.5f},
         {0.2f, 0.5f},
         {0.6f, 0.375f}}};  // depth and alpha in order of arrival
    std::uint64_t before = 0;
    for (std::uint32_t l = 0; l < layers.size(); ++l) {
        std::vector<Fragment> fragments;
        for (int i = 0; i < kSide * kSide; ++i)
            fragments.push_back(
                test::fragment_at(i % kSide, i / kSide, layers[l].first, layers[l].second, {1, 1, 1}, l));
        before = frame.log().path_count(kInsert);
        frame.draw(fragments);
    }
    const double n = kSide * kSide;
    EXPECT_EQ(before, 3 * kSide * kSide) << "each of the first three had nothing in front";
    const double p = visible_probability(8, 6, 3);
    EXPECT_NEAR(static_cast<double>(frame.log().path_count(kInsert) - before), n * p,
                4 * std::sqrt(n * p * (1 - p)));
}

// Insertion does not test the layers behind again: two layers of alpha 1/2 with 4 bits keep the far one in 5
// of 6 pixels near to far, and always far to near.
TEST(Order, FarLayerIsAlwaysKeptFarToNear) {
    constexpr int kSide = 256;
    for (const bool near_first : {true, false}) {
        TestFrame frame("slab:format=float32,layers=4,bits=4", test::header_of(kSide, kSide, 1, {0, 0, 1}),
                        6);
        for (const bool near : {near_first, !near_first}) {
            std::vector<Fragment> layer;
            for (int i = 0; i < kSide * kSide; ++i)
                layer.push_back(test::fragment_at(
                    i % kSide, i / kSide, near ? 0.25f : 0.75f, 0.5f,
                    near ? std::array<float, 3>{1, 0, 0} : std::array<float, 3>{0, 1, 0}, near ? 0 : 1));
            frame.draw(layer);
        }
        const auto image = frame.image();
        double kept = 0;
        for (std::size_t i = 0; i < image.size(); i += 3) {
            ASSERT_EQ(image[i], 0.5f);
            const bool far = image[i + 1] != 0;
            kept += far ? 1 : 0;
            ASSERT_EQ(image[i + 1], far ? 0.25f : 0.0f);
            ASSERT_EQ(image[i + 2], far ? 0.25f : 0.5f);
        }
        const double n = kSide * kSide;
        const double p = 5.0 / 6.0;
        EXPECT_NEAR(kept, near_first ? n * p : n, near_first ? 4 * std::sqrt(n * p * (1 - p)) : 0);
    }
}

// The seed, pixel and primitive decide, not the arrival: two runs agree, another seed does not.
TEST(Order, InsertionDependsOnTheSeed) {
    const auto count = [](std::uint64_t seed) {
        TestFrame frame("slab:layers=2,bits=4", test::header_of(16, 16), seed);
        for (std::uint32_t layer = 0; layer < 2; ++layer)
            for (int i = 0; i < 256; ++i)
                frame.draw_one(
                    test::fragment_at(i % 16, i / 16, layer == 0 ? 0.2f : 0.4f, 0.5f, {1, 1, 1}, layer));
        return frame.image();
    };
    EXPECT_EQ(count(1), count(1));
    EXPECT_NE(count(1), count(2));
}

// bits=inf: whatever the order of arrival, the nearest layers are kept, of equal depths the earlier ones, and
// they alone composite over the background.
TEST(KBuffer, KeepsTheNearestLayersExactly) {
    for (const int layers : {1, 3, 8}) {
        Random random(41);
        const TraceHeader header = test::opaque_header(9, 6, 1, random);
        const auto fragments = test::random_fragments(header, {.count = 1200}, random);
        TestFrame frame("slab:bits=inf,format=float32,layers=" + std::to_string(layers), header);
        EXPECT_FALSE(frame.declaration().random);
        frame.draw(fragments);
        std::vector<Fragment> nearest;
        for (int pixel = 0; pixel < header.width * header.height; ++pixel) {
            auto own = test::nearest_first(fragments, pixel % header.width, pixel / header.width);
            own.resize(std::min(own.size(), static_cast<std::size_t>(layers)));
            nearest.insert(nearest.end(), own.begin(), own.end());
        }
        EXPECT_LT(test::worst_error(frame, nearest), 1e-5) << layers << " layers";
        EXPECT_GT(frame.log().path_count(kBehindFullList), 100u);
    }
}

}  // namespace
}  // namespace ropsim
