// Opacity references in number: coverage by several surfaces, its spread, and correlations between surfaces
// (Laine and Karras 2011, section 3 and Figs. 3 and 5). Eight samples a pixel, 65,536 pixels in a row.
#include "rop/sampling/mask_patterns.h"
#include "rop/sampling/opacity_reference.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

constexpr std::uint32_t kPixels = 65536;
constexpr std::uint32_t kSamples = 8;

std::uint32_t reference(OpacityHash hash, std::uint32_t index, std::uint32_t surface) {
    return opacity_reference<PlainDatapath>(hash, index, surface);
}

// Mean and standard deviation over the pixels of the share of samples that at least one of 8 surfaces covers.
struct Coverage {
    double mean = 0;
    double deviation = 0;
};
Coverage coverage_of_eight(OpacityHash hash, float alpha) {
    double sum = 0;
    double squares = 0;
    for (std::uint32_t pixel = 0; pixel < kPixels; ++pixel) {
        std::uint32_t covered = 0;
        for (std::uint32_t surface = 0; surface < 8; ++surface)
            for (std::uint32_t k = 0; k < kSamples; ++k)
                if (reference(hash, pixel * kSamples + k, surface) < alpha_threshold(alpha))
                    covered |= 1u << k;
        const double share = std::popcount(covered) / static_cast<double>(kSamples);
        sum += share;
        squares += share * share;
    }
    const double mean = sum / kPixels;
    return {mean, std::sqrt(squares / kPixels - mean * mean)};
}
double exact_coverage(float alpha) {
    return 1 - std::pow(1 - static_cast<double>(alpha), 8);
}

TEST(OpacityStatistics, HashesAreUnbiased) {
    for (const OpacityHash hash : {OpacityHash::kPaper, OpacityHash::kImproved})
        for (const float alpha : {0.1f, 0.3f, 0.5f}) {
            const Coverage measured = coverage_of_eight(hash, alpha);
            EXPECT_NEAR(measured.mean, exact_coverage(alpha), 4 * measured.deviation / std::sqrt(kPixels))
                << alpha;
        }
}

// "Each sample has almost constant opacity reference value regardless of surface": eight surfaces cover what
// one does, .1 and not .5695.
TEST(OpacityStatistics, RadicalInverseHidesSurfacesBehindEachOther) {
    EXPECT_NEAR(coverage_of_eight(OpacityHash::kRadicalInverse, 0.1f).mean, 0.1, 1e-4);
    EXPECT_NEAR(coverage_of_eight(OpacityHash::kRadicalInverse, 0.3f).mean, 0.3, 1e-4);
    EXPECT_EQ(coverage_of_eight(OpacityHash::kRadicalInverse, 0.5f).mean, 0.5);
}

// Figure 3b: the surfaces' spans of Sobol's sequence are correlated, here such that surfaces avoid each
// other: the sum of the alphas and no blending.
TEST(OpacityStatistics, SobolSurfacesAvoidEachOther) {
    EXPECT_NEAR(coverage_of_eight(OpacityHash::kSobol, 0.1f).mean, 0.8, 1e-4);
    EXPECT_EQ(coverage_of_eight(OpacityHash::kSobol, 0.3f).mean, 1.0);
}

// At alpha 1/2 a random Owen scramble leaves, by each surface, one sample of each of 4 pairs (indices 2i and
// 2i + 1) uncovered, pairs independent: a pair keeps an uncovered sample with probability q = 2^-7, and the
// spread is sqrt(4 q (1 - q)) / 8 = .0220. Fig. 4's factors do not let bit 1 of the index flip the highest
// bit, so that the pairs go two by two: sqrt(2 * 4 q (1 - q)) / 8 = .0311. (Independent subsets of 4 of 8:
// .0218.)
TEST(OpacityStatistics, SpreadOfEightSurfaces) {
    const double q = 0x1p-7;
    const double ideal = std::sqrt(4 * q * (1 - q)) / 8;
    const double paper = std::sqrt(8 * q * (1 - q)) / 8;
    EXPECT_NEAR(ideal, 0.0220, 5e-5);
    EXPECT_NEAR(paper, 0.0311, 5e-5);
    // Pixels with an uncovered pair are a Poisson number: the relative spread of the deviation is
    // 1 / (2 sqrt(that number)).
    const double improved_tolerance = 4 * ideal / (2 * std::sqrt(kPixels * 4 * q));
    const double paper_tolerance = 4 * paper / (2 * std::sqrt(kPixels * 2 * q));
    EXPECT_NEAR(coverage_of_eight(OpacityHash::kImproved, 0.5f).deviation, ideal, improved_tolerance);
    EXPECT_NEAR(coverage_of_eight(OpacityHash::kPaper, 0.5f).deviation, paper, paper_tolerance);
    EXPECT_LT(improved_tolerance + paper_tolerance, paper - ideal);
}

double correlation(OpacityHash hash, std::uint32_t first, std::uint32_t second) {
    double sum = 0;
    for (std::uint32_t i = 0; i < kPixels * kSamples; ++i)
        sum += (reference(hash, i, first) * 0x1p-32 - 0.5) * (reference(hash, i, second) * 0x1p-32 - 0.5);
    return 12 * sum / (kPixels * kSamples);  // 1/12: the variance of a uniform number
}

// Independent numbers would have correlations of spread .0014 here; the structure left in the hashes gives up
// to .0074 with the paper's factors, .0019 with the improved ones.
TEST(OpacityStatistics, SurfacesAreUncorrelated) {
    double largest_of_sobol = 0;
    for (std::uint32_t surface = 1; surface <= 8; ++surface) {
        EXPECT_LT(std::abs(correlation(OpacityHash::kPaper, 0, surface)), 0.01) << surface;
        EXPECT_LT(std::abs(correlation(OpacityHash::kImproved, 0, surface)), 0.0055) << surface;
        EXPECT_GT(correlation(OpacityHash::kRadicalInverse, 0, surface), 0.9999) << surface;
        largest_of_sobol = std::max(largest_of_sobol, std::abs(correlation(OpacityHash::kSobol, 0, surface)));
    }
    EXPECT_GT(largest_of_sobol, 0.8);
}

// Both of two surfaces of alpha 1/2 cover a sample in a quarter of the cases.
TEST(OpacityStatistics, PairsOfSurfacesCoverAQuarter) {
    for (const OpacityHash hash : {OpacityHash::kPaper, OpacityHash::kImproved})
        for (std::uint32_t a = 0; a < 16; ++a)
            for (std::uint32_t b = 0; b < a; ++b) {
                std::uint32_t both = 0;
                for (std::uint32_t i = 0; i < kPixels; ++i)
                    both += ((reference(hash, i, a) | reference(hash, i, b)) >> 31) ^ 1u;
                EXPECT_NEAR(both / static_cast<double>(kPixels), 0.25, 0.01) << a << " " << b;
            }
}

// Figure 5a: two layers of alpha 1/2, 16 samples, nothing but the hash between them. The nearer covers 8 in
// every pixel, the farther 4 on average and anything from 0 to 8: of 8 pairs of samples half at random, a
// spread of sqrt(8) / 2 = 1.41 for a random Owen scramble, and of 4 fours, 2, with Fig. 4's factors.
TEST(OpacityStatistics, TwoLayersWithoutSorting) {
    const double ideal = std::sqrt(8.0) / 2;
    for (const auto& [hash, spread] :
         {std::pair(OpacityHash::kPaper, 2.0), std::pair(OpacityHash::kImproved, ideal)}) {
        double sum = 0;
        double squares = 0;
        for (std::uint32_t pixel = 0; pixel < kPixels; ++pixel) {
            int near = 0;
            int far = 0;
            for (std::uint32_t k = 0; k < 16; ++k) {
                const bool covered = reference(hash, pixel * 16 + k, 0) >> 31 == 0;
                near += covered ? 1 : 0;
                far += !covered && reference(hash, pixel * 16 + k, 1) >> 31 == 0 ? 1 : 0;
            }
            ASSERT_EQ(near, 8);
            sum += far;
            squares += far * far;
        }
        const double mean = sum / kPixels;
        EXPECT_NEAR(mean, 4, 0.03);
        EXPECT_NEAR(std::sqrt(squares / kPixels - mean * mean), spread, 0.03);
    }
}

}  // namespace
}  // namespace ropsim
