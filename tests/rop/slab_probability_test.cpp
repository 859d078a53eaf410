// The probabilities of Wyman 2016 by counting masks: equation 1, the non-stratified one, their limit, and how
// often the operation inserts by them, with alphas and with masks.
#include "rop/nodes/insertion_probability.h"
#include "tests/rop/random_fragments.h"

#include <bit>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::TestFrame;

// Of all masks of t of b bits, those that are not inside a given mask of s bits.
double counted_stratified(int b, int s, int t) {
    const std::uint32_t covered = (1u << s) - 1;
    double seen = 0;
    double all = 0;
    for (std::uint32_t mask = 0; mask < 1u << b; ++mask) {
        if (std::popcount(mask) != t) continue;
        all += 1;
        seen += (mask & ~covered) != 0 ? 1 : 0;
    }
    return seen / all;
}

// The same where each bit is set by itself with probability t / b: all masks by their probability.
double counted_non_stratified(int b, int s, int t) {
    const std::uint32_t covered = (1u << s) - 1;
    const double p = static_cast<double>(t) / b;
    double seen = 0;
    for (std::uint32_t mask = 0; mask < 1u << b; ++mask)
        if ((mask & ~covered) != 0)
            seen += std::pow(p, std::popcount(mask)) * std::pow(1 - p, b - std::popcount(mask));
    return seen;
}

TEST(InsertionProbability, CountsOfAllMasks) {
    for (const int b : {1, 2, 3, 4, 7, 8, 12}) {
        const InsertionProbability stratified(b, CoverageBits::kStratified);
        const InsertionProbability independent(b, CoverageBits::kNonStratified);
        for (std::uint32_t s = 0; s <= static_cast<std::uint32_t>(b); ++s) {
            for (std::uint32_t t = 0; t <= static_cast<std::uint32_t>(b); ++t) {
                const int is = static_cast<int>(s);
                const int it = static_cast<int>(t);
                ASSERT_NEAR(stratified.at(s, t), counted_stratified(b, is, it), 1e-7)
                    << b << " " << s << " " << t;
                ASSERT_NEAR(independent.at(s, t), counted_non_stratified(b, is, it), 1e-7)
                    << b << " " << s << " " << t;
            }
        }
    }
}

struct Printed {
    int b;
    std::uint32_t s, t;
    double stratified, non_stratified;
};
constexpr Printed kPrinted[] = {{4, 2, 2, .83333, .75000},
                                {8, 4, 2, .78571, .68359},
                                {8, 6, 3, .64286, .60938},
                                {16, 12, 4, .72802, .68359},
                                {16, 8, 8, .99992, .99609}};

TEST(InsertionProbability, PrintedValues) {
    for (const Printed& v : kPrinted) {
        EXPECT_NEAR(InsertionProbability(v.b, CoverageBits::kStratified).at(v.s, v.t), v.stratified, 5.1e-6);
        EXPECT_NEAR(InsertionProbability(v.b, CoverageBits::kNonStratified).at(v.s, v.t), v.non_stratified,
                    5.1e-6);
    }
}

// "As we increase the number of coverage bits, P_b -> 1": as long as anything is uncovered and the fragment
// has a bit. Behind full coverage P is 0 for every b, and so is that of a fragment below half a bit.
TEST(InsertionProbability, LimitOfManyBits) {
    for (const auto& [b, expected] :
         {std::pair{10, .1}, std::pair{40, .355}, std::pair{160, .831}, std::pair{640, .9992}}) {
        const InsertionProbability p(b, CoverageBits::kStratified);
        const auto count = [&, b = b](double alpha) { return static_cast<std::uint32_t>(b * alpha + 0.5); };
        EXPECT_NEAR(p.at(count(.9), count(.1)), expected, 5e-4) << b;
        EXPECT_EQ(p.at(count(1), count(.1)), 0.0f) << b;
        EXPECT_EQ(p.at(count(.5), 0), 0.0f) << b;
        EXPECT_EQ(p.at(0, count(.1)), 1.0f) << b;
    }
}

// Of side * side pixels with a layer of alpha s / b, how many store a fragment of alpha t / b behind it.
double inserted(const std::string& options, int b, std::uint32_t s, std::uint32_t t, int side) {
    TestFrame frame(fmt::format("slab:format=float32,layers=4,bits={}{}", b, options),
                    test::header_of(side, side), 3);
    const auto insert = static_cast<std::size_t>(frame.declaration().path("insert"));
    std::array<std::uint64_t, 2> count{};
    for (std::uint32_t layer = 0; layer < 2; ++layer) {
        std::vector<Fragment> all;
        for (int i = 0; i < side * side; ++i)
            all.push_back(test::fragment_at(i % side, i / side, layer == 0 ? 0.25f : 0.75f,
                                            static_cast<float>(layer == 0 ? s : t) / static_cast<float>(b),
                                            {1, 1, 1}, layer));
        frame.draw(all);
        count[layer] = frame.log().path_count(insert);
    }
    // A coin mask of the layer in front can be empty.
    return static_cast<double>(count[1] - count[0]);
}

void expect_inserted(const std::string& options, int b, std::uint32_t s, std::uint32_t t, double p) {
    constexpr int kSide = 256;
    constexpr double kPixels = kSide * kSide;
    EXPECT_NEAR(inserted(options, b, s, t, kSide), kPixels * p,
                4.5 * std::sqrt(kPixels * p * (1 - p)) + (p > 0 && p < 1 ? 1 : 0))
        << options << " b " << b << " s " << s << " t " << t;
}

// Bits set by themselves may all be missing: the non-stratified equation discards a fragment that has nothing
// in front with probability ((b - t) / b)^b, and what is behind it then sees an empty list.
TEST(InsertionProbability, OfTheOperationWithAlphas) {
    for (const Printed& v : kPrinted) {
        const auto alone = [&](std::uint32_t t) {
            return 1 - std::pow(1 - static_cast<double>(t) / v.b, v.b);
        };
        const double p = counted_non_stratified(v.b, static_cast<int>(v.s), static_cast<int>(v.t));
        expect_inserted(",probability=non_stratified", v.b, v.s, v.t,
                        alone(v.s) * p + (1 - alone(v.s)) * alone(v.t));
    }
    expect_inserted("", 640, 576, 64, .99924);
    expect_inserted("", 160, 144, 16, .83072);
}

// Masks are drawn, not probabilities: they come out the same. Alphas that are a whole number of bits have
// exactly that many when stratified.
TEST(InsertionProbability, OfTheOperationWithMasks) {
    for (const Printed& v : kPrinted) expect_inserted(",coverage=discrete", v.b, v.s, v.t, v.stratified);
    for (std::uint32_t s = 0; s <= 4; ++s)
        for (std::uint32_t t = 0; t <= 4; ++t)
            expect_inserted(",coverage=discrete", 4, s, t,
                            counted_stratified(4, static_cast<int>(s), static_cast<int>(t)));
    // 40 bits lie in two words.
    expect_inserted(",coverage=discrete", 40, 36, 2, 1 - 36.0 * 35 / (40 * 39));
}

// Where both masks are independent coins the far one is hidden with probability (1 - a_near a... ) a bit:
// each bit is seen with probability (1 - s/b) t/b.
TEST(InsertionProbability, OfTheOperationWithCoins) {
    for (const Printed& v : kPrinted) {
        const double seen = (1 - static_cast<double>(v.s) / v.b) * v.t / v.b;
        expect_inserted(",coverage=discrete,probability=non_stratified", v.b, v.s, v.t,
                        1 - std::pow(1 - seen, v.b));
    }
}

}  // namespace
}  // namespace ropsim
