// Stochastic shadow maps against the exact distribution of their masks: two layers, every pair of masks
// enumerated. Enderton et al. 2011, Fig. 5 shows naive, stratified and alpha-corrected shadows from noisy to
// clean; here are the numbers.
#include "rop/shadow/shadow_map.h"
#include "tests/rop/random_fragments.h"

#include <array>
#include <bit>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::fragment_at;
using test::TestFrame;

constexpr int kSamples = 8;
constexpr int kSide = 96;
constexpr double kTexels = kSide * kSide;
constexpr std::array<float, 2> kDepths = {0.25f, 0.5f};
constexpr std::array<double, 3> kLooked = {0.125, 0.375, 0.75};  // before, between, behind

struct Moments {
    double mean = 0;
    double square = 0;
    double variance() const { return square - mean * mean; }
};

// Probability of a mask of eight samples at alpha.
double coin_probability(unsigned mask, double alpha) {
    const int taken = std::popcount(mask);
    return std::pow(alpha, taken) * std::pow(1 - alpha, kSamples - taken);
}
// R is the floor or the ceiling of alpha S, then every mask of R samples is as likely as another.
double choose_probability(unsigned mask, double alpha) {
    const int taken = std::popcount(mask);
    const double wanted = alpha * kSamples;
    return std::max(0.0, 1 - std::abs(wanted - taken)) / test::binomial(kSamples, taken);
}

enum class Variant { kNaive, kStratified, kCorrected };

// What a look-up behind `layers` of the two layers gives for a pair of masks, by the paper's words.
double estimate(Variant variant, unsigned near, unsigned far, int layers, double total_alpha) {
    const unsigned in_front = layers == 0 ? 0 : layers == 1 ? near : near | far;
    const double drop = std::popcount(in_front) / static_cast<double>(kSamples);
    if (variant != Variant::kCorrected) return 1 - drop;
    const double whole_drop = std::popcount(near | far) / static_cast<double>(kSamples);
    return whole_drop == 0 ? 1 : 1 - total_alpha * drop / whole_drop;
}

double exact(std::array<double, 2> alpha, int layers) {
    return (layers > 0 ? 1 - alpha[0] : 1) * (layers > 1 ? 1 - alpha[1] : 1);
}

Moments enumerated(Variant variant, std::array<double, 2> alpha, int layers) {
    const double total_alpha = 1 - exact(alpha, 2);
    const auto probability = variant == Variant::kNaive ? coin_probability : choose_probability;
    Moments moments;
    for (unsigned near = 0; near < 1u << kSamples; ++near) {
        const double p = probability(near, alpha[0]);
        for (unsigned far = 0; p > 0 && far < 1u << kSamples; ++far) {
            const double value = estimate(variant, near, far, layers, total_alpha);
            moments.mean += p * probability(far, alpha[1]) * value;
            moments.square += p * probability(far, alpha[1]) * value * value;
        }
    }
    return moments;
}

// The technique's own maps of the same two layers in every texel.
StoredShadowMap drawn(Variant variant, std::array<double, 2> alpha) {
    const std::string masks = variant == Variant::kNaive ? "coin" : "choose";
    const std::string total = variant == Variant::kCorrected ? "on" : "off";
    TestFrame frame("shadow_map:samples=8,masks=" + masks + ",total_alpha=" + total,
                    test::header_of(kSide, kSide), 1);
    std::vector<Fragment> fragments;
    for (const std::size_t layer : {std::size_t{1}, std::size_t{0}})
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x)
                fragments.push_back(fragment_at(x, y, kDepths[layer], static_cast<float>(alpha[layer]),
                                                {1, 1, 1}, static_cast<std::uint32_t>(layer)));
    frame.draw(fragments);
    return stored_shadow_map(frame.declaration(), frame.stores(), frame.header());
}

Moments measured(const StoredShadowMap& map, double z) {
    Moments moments;
    for (int y = 0; y < map.height; ++y) {
        for (int x = 0; x < map.width; ++x) {
            const double value =
                map.corrected() ? corrected_visibility(map, x, y, z) : stochastic_visibility(map, x, y, z);
            moments.mean += value / kTexels;
            moments.square += value * value / kTexels;
        }
    }
    return moments;
}

constexpr std::array<std::array<double, 2>, 3> kAlphas = {{{0.25, 0.5}, {0.3, 0.7}, {0.1, 0.85}}};

TEST(ShadowMapStatistics, OneLayerHasTheTextbookVariance) {
    for (const double alpha : {0.25, 0.3, 0.7, 0.95}) {
        const double fraction = alpha * kSamples - std::floor(alpha * kSamples);
        const Moments naive = enumerated(Variant::kNaive, {alpha, 0.5}, 1);
        const Moments stratified = enumerated(Variant::kStratified, {alpha, 0.5}, 1);
        EXPECT_NEAR(naive.mean, 1 - alpha, 1e-12);
        EXPECT_NEAR(stratified.mean, 1 - alpha, 1e-12);
        EXPECT_NEAR(naive.variance(), alpha * (1 - alpha) / kSamples, 1e-12);
        EXPECT_NEAR(stratified.variance(), fraction * (1 - fraction) / (kSamples * kSamples), 1e-12);
    }
}

TEST(ShadowMapStatistics, MapsAreDistributedAsTheirMasks) {
    for (const std::array<double, 2>& alpha : kAlphas) {
        for (const Variant variant : {Variant::kNaive, Variant::kStratified, Variant::kCorrected}) {
            const StoredShadowMap map = drawn(variant, alpha);
            for (int layers = 0; layers <= 2; ++layers) {
                const Moments expected = enumerated(variant, alpha, layers);
                const Moments got = measured(map, kLooked[static_cast<std::size_t>(layers)]);
                SCOPED_TRACE(fmt::format("variant {}, alphas {} {}, behind {}", static_cast<int>(variant),
                                         alpha[0], alpha[1], layers));
                // Five deviations of a mean over independent texels. Corrected maps store total alpha with 11
                // bits.
                const double slack = variant == Variant::kCorrected ? 0x1p-11 : 1e-6;
                const double variance = std::max(0.0, expected.variance());
                EXPECT_NEAR(got.mean, expected.mean, 5 * std::sqrt(variance / kTexels) + slack);
                // Values lie in [0, 1], so a squared deviation has variance at most the variance.
                EXPECT_NEAR(got.variance(), variance, 5 * std::sqrt(variance / kTexels) + slack);
            }
        }
    }
}

// Fig. 5: (a) naive is noisier than (b) stratified, and (c) corrected is best on average over the depths,
// though not at every one (section 3.6 says so itself).
TEST(ShadowMapStatistics, NoiseFallsFromNaiveToStratifiedToCorrected) {
    bool worse_somewhere = false;
    for (const std::array<double, 2>& alpha : kAlphas) {
        std::array<double, 3> error{};
        for (int layers = 1; layers <= 2; ++layers) {
            std::array<double, 3> here{};
            for (const Variant variant : {Variant::kNaive, Variant::kStratified, Variant::kCorrected}) {
                const Moments m = enumerated(variant, alpha, layers);
                const double bias = m.mean - exact(alpha, layers);
                here[static_cast<std::size_t>(variant)] = m.variance() + bias * bias;
            }
            EXPECT_GT(here[0], here[1]) << alpha[0] << ' ' << layers;
            worse_somewhere = worse_somewhere || here[2] > here[1];
            for (std::size_t v = 0; v < 3; ++v) error[v] += here[v];
        }
        EXPECT_GT(error[0], error[1]) << alpha[0];
        EXPECT_GT(error[1], error[2]) << alpha[0];
    }
    EXPECT_TRUE(worse_somewhere) << "between the layers, stratified samples of the near one are exact";
}

TEST(ShadowMapStatistics, OneSampleIsOneCoin) {
    TestFrame frame("shadow_map:samples=1", test::header_of(kSide, kSide), 3);
    std::vector<Fragment> fragments;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) fragments.push_back(fragment_at(x, y, 0.5f, 0.3f, {1, 1, 1}));
    frame.draw(fragments);
    const StoredShadowMap map = stored_shadow_map(frame.declaration(), frame.stores(), frame.header());
    const double taken = 1 - measured(map, 0.75).mean;
    EXPECT_NEAR(taken, 0.3, 5 * std::sqrt(0.3 * 0.7 / kTexels));
}

}  // namespace
}  // namespace ropsim
