// Stochastic transparency against the distributions it is defined by (Enderton et al. 2011), by enumeration,
// and its and Laine and Karras's means against the exact image.
#include "tests/rop/random_fragments.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

// Samples written by one fragment of alpha `a` in each pixel of a cleared side x side frame.
std::vector<std::uint64_t> written_masks(const std::string& technique, int side, float a,
                                         std::uint64_t seed = 1, int spatial_samples = 1,
                                         std::uint16_t coverage = 0xFFFF) {
    TestFrame frame(technique, test::header_of(side, side, spatial_samples), seed);
    std::vector<Fragment> fragments;
    for (int i = 0; i < side * side; ++i) {
        fragments.push_back(test::fragment_at(i % side, i / side, 0.5f, a, {1, 1, 1}));
        fragments.back().coverage = coverage;
    }
    frame.draw(fragments);
    std::vector<std::uint64_t> masks;
    for (std::size_t i = 0; i < frame.log().records(); ++i) {
        const SurfaceAccess* access = frame.log().record_access(i);
        EXPECT_EQ(access[0].write, access[1].write) << "depth and colour are written together";
        masks.push_back(access[1].write);
    }
    return masks;
}

// Chi-square over equally likely outcomes; `limit` is the mean of the distribution and 5 of its standard
// deviations (its upper tail beyond that is below 1e-5 for the degrees of freedom used here).
void expect_uniform(const std::map<std::uint64_t, int>& counts, std::size_t outcomes, std::size_t trials) {
    ASSERT_EQ(counts.size(), outcomes) << "outcomes that occur";
    const double expected = static_cast<double>(trials) / static_cast<double>(outcomes);
    double chi2 = 0;
    for (const auto& [mask, n] : counts) chi2 += (n - expected) * (n - expected) / expected;
    const double freedom = static_cast<double>(outcomes) - 1;
    EXPECT_LT(chi2, freedom + 5 * std::sqrt(2 * freedom) + 5);
}

// Section 3.1: R = floor(alpha S + xi). alpha = 0.45, S = 4: one sample with probability 0.2, two with 0.8.
TEST(Stochastic, NumberOfSamples) {
    const auto masks = written_masks("stochastic:samples=4", 256, 0.45f);
    std::array<int, 5> count{};
    for (const std::uint64_t mask : masks) ++count[static_cast<std::size_t>(std::popcount(mask))];
    EXPECT_EQ(count[0] + count[3] + count[4], 0);
    const double n = static_cast<double>(masks.size());
    EXPECT_NEAR(count[1] / n, 0.2, 4 * std::sqrt(0.2 * 0.8 / n));
}

TEST(Stochastic, AlphaOneTakesAllAndAlphaZeroNone) {
    for (const std::uint64_t mask : written_masks("stochastic:samples=8", 128, 1.0f)) ASSERT_EQ(mask, 0xFFu);
    TestFrame frame("stochastic:samples=8", test::header_of(1, 1));
    frame.draw_one(test::fragment_at(0, 0, 0.5f, 0.0f, {0, 0, 0}));
    EXPECT_EQ(frame.log().path_count(0), 1u) << "empty mask";
    EXPECT_EQ(frame.log().read_elements(0), 0u) << "an empty mask reads nothing";
}

// alpha = 1/2, S = 8: all 70 masks of 4 samples equally likely.
TEST(Stochastic, MasksAreUniform) {
    std::map<std::uint64_t, int> counts;
    const auto masks = written_masks("stochastic:samples=8", 256, 0.5f);
    for (const std::uint64_t mask : masks) {
        ASSERT_EQ(std::popcount(mask), 4);
        ++counts[mask];
    }
    expect_uniform(counts, 70, masks.size());
}

// Two spatial samples, the first covered: only stored samples 0, 2, 4, 6 can be taken, each pair of them
// equally often.
TEST(Stochastic, CoverageOfSpatialSamples) {
    std::map<std::uint64_t, int> counts;
    const auto masks = written_masks("stochastic:samples=8", 128, 0.5f, 1, 2, 0b01);
    for (const std::uint64_t mask : masks) {
        ASSERT_EQ(mask & 0b10101010u, 0u) << "a sample that is not covered";
        ASSERT_EQ(std::popcount(mask), 2);
        ++counts[mask];
    }
    expect_uniform(counts, 6, masks.size());
    for (const std::uint64_t mask : written_masks("stochastic:samples=8", 32, 1.0f, 1, 4, 0b1010))
        ASSERT_EQ(mask, 0b10101010u);
}

// The same pixel, primitive and seed draw the same mask; another of any of them is another draw.
TEST(Stochastic, MasksDependOnSeedPixelDrawAndPrimitiveAlone) {
    const auto mask_of = [](std::uint64_t seed, int x, std::uint16_t draw, std::uint32_t primitive, float z) {
        TestFrame frame("stochastic:samples=32", test::header_of(8, 1), seed);
        Fragment f = test::fragment_at(x, 0, z, 0.5f, {1, 1, 1}, primitive);
        f.draw = draw;
        frame.draw_one(f);
        return frame.log().record_access(0)[1].write;
    };
    const std::uint64_t mask = mask_of(1, 2, 3, 4, 0.5f);
    EXPECT_EQ(mask_of(1, 2, 3, 4, 0.25f), mask);
    EXPECT_NE(mask_of(2, 2, 3, 4, 0.5f), mask);
    EXPECT_NE(mask_of(1, 3, 3, 4, 0.5f), mask);
    EXPECT_NE(mask_of(1, 2, 4, 4, 0.5f), mask);
    EXPECT_NE(mask_of(1, 2, 3, 5, 0.5f), mask);
}

TEST(Stochastic, OfEqualDepthsTheFirstArrivalStays) {
    TestFrame frame("stochastic:samples=8", test::header_of(1, 1));
    frame.draw_one(test::fragment_at(0, 0, 0.5f, 1, {1, 0, 0}, 0));
    frame.draw_one(test::fragment_at(0, 0, 0.5f, 1, {0, 1, 0}, 1));
    frame.draw_one(test::fragment_at(0, 0, 0.6f, 1, {0, 0, 1}, 2));
    EXPECT_EQ(frame.color(), (std::array<float, 3>{1, 0, 0}));
    frame.draw_one(test::fragment_at(0, 0, 0.4f, 1, {0, 0, 1}, 3));
    EXPECT_EQ(frame.color(), (std::array<float, 3>{0, 0, 1}));
}

class Unbiased : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Techniques, Unbiased,
                         testing::Values("stochastic:samples=4,format=float32",
                                         "stochastic:samples=8,format=float32",
                                         "laine_karras:samples=8,format=float32",
                                         "laine_karras:samples=16,format=float32"),
                         [](const auto& setup) {
                             std::string name = setup.param.substr(0, setup.param.find(','));
                             std::ranges::replace_if(
                                 name, [](char c) { return c == ':' || c == '='; }, '_');
                             return name;
                         });

// The mean over seeds is the exact image: over all pixels within 4 standard errors, and single pixels outside
// 2 standard errors as often as a normal distribution says, up to 4 standard deviations of that binomial
// count.
TEST_P(Unbiased, MeanOverSeedsIsTheExactImage) {
    constexpr int kSide = 16;
    constexpr int kSeeds = 600;
    Random random(21);
    const TraceHeader header = test::opaque_header(kSide, kSide, 1, random);
    test::FragmentOptions options;
    options.count = std::size_t{256} * 6;
    options.distinct_depths = true;
    options.extremes = false;
    const auto fragments = test::random_fragments(header, options, random);
    std::vector<double> sum(std::size_t{3} * kSide * kSide, 0.0);
    std::vector<double> square(sum.size(), 0.0);
    for (int seed = 1; seed <= kSeeds; ++seed) {
        TestFrame frame(GetParam(), header, static_cast<std::uint64_t>(seed));
        frame.draw(fragments);
        const auto image = frame.image();
        for (std::size_t i = 0; i < image.size(); ++i) {
            sum[i] += image[i];
            square[i] += static_cast<double>(image[i]) * image[i];
        }
    }
    for (std::size_t c = 0; c < 3; ++c) {
        double error = 0;
        double variance = 0;
        int outside = 0;
        int random_pixels = 0;
        for (int p = 0; p < kSide * kSide; ++p) {
            const std::size_t i = static_cast<std::size_t>(3 * p) + c;
            const double mean = sum[i] / kSeeds;
            const double exact = test::composited(fragments, p % kSide, p / kSide,
                                                  test::background_of(header, p % kSide, p / kSide))[c];
            const double of_mean = std::max(0.0, square[i] / kSeeds - mean * mean) / (kSeeds - 1);
            error += mean - exact;
            variance += of_mean;
            if (of_mean < 1e-12) {
                EXPECT_NEAR(mean, exact, 1e-5) << "no fragment, no noise";
                continue;
            }
            ++random_pixels;
            if (std::abs(mean - exact) > 2 * std::sqrt(of_mean)) ++outside;
            EXPECT_LT(std::abs(mean - exact), 5 * std::sqrt(of_mean)) << "pixel " << p;
        }
        EXPECT_LT(std::abs(error), 4 * std::sqrt(variance)) << "channel " << c;
        constexpr double kShare = 0.0455;  // of a normal distribution beyond 2 standard deviations
        EXPECT_GT(random_pixels, 200);
        EXPECT_NEAR(outside, kShare * random_pixels, 4 * std::sqrt(kShare * (1 - kShare) * random_pixels));
    }
}

}  // namespace
}  // namespace ropsim
