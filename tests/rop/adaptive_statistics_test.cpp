// How far adaptive transparency is from exact over random layers: what its rules of removal cost and what
// normalisation gives back. Every pixel is a draw of its own; depths are uniform, arrival is random.
#include "tests/rop/random_fragments.h"
#include "tests/rop/slow_curve.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

constexpr int kSide = 24;
constexpr int kPixels = kSide * kSide;

struct Layers {
    int count;
    float alpha;
    std::array<float, 2> levels;  // each channel of each fragment's straight colour is uniform in between
};
constexpr Layers kColoured32 = {32, 0.15f, {0, 1}};
constexpr Layers kWhite32 = {32, 0.15f, {1, 1}};
constexpr Layers kColoured200 = {200, 0.01f, {0, 1}};
constexpr Layers kWhite200 = {200, 0.01f, {1, 1}};

// By pixel: pixel p's are fragments p * count onwards.
std::vector<Fragment> random_layers(const Layers& layers, Random& random) {
    std::vector<Fragment> fragments;
    const auto level = [&] { return random.real(layers.levels[0], layers.levels[1]); };
    for (int pixel = 0; pixel < kPixels; ++pixel)
        for (int i = 0; i < layers.count; ++i) {
            // Draws one after the other: compilers differ in the order of a call's arguments.
            const std::array<float, 3> color{level(), level(), level()};
            const float z = random.real(0, 1);
            fragments.push_back(test::fragment_at(pixel % kSide, pixel / kSide, z, layers.alpha, color));
        }
    return fragments;
}

std::vector<float> image_of(const std::string& keys, std::span<const Fragment> fragments, float background) {
    TestFrame frame("adaptive:format=float32," + keys,
                    test::header_of(kSide, kSide, 1, {background, background, background}), 0, 1u << 20,
                    false);
    frame.draw(fragments);
    return frame.image();
}

// Of an image against exact compositing over black, in 1/255: of a pixel's error, which is the mean of its
// channels' and of their squares.
struct Error {
    double mean = 0;
    double square = 0;
    double mean_deviation = 0;  // of `mean` and `square`, if it were done again
    double square_deviation = 0;
};
Error error_of(const std::string& keys, const Layers& layers, std::span<const Fragment> fragments) {
    const std::vector<float> image = image_of(keys, fragments, 0);
    std::vector<double> means;
    std::vector<double> squares;
    for (int pixel = 0; pixel < kPixels; ++pixel) {
        const auto own = fragments.subspan(static_cast<std::size_t>(pixel * layers.count),
                                           static_cast<std::size_t>(layers.count));
        const auto exact = test::composited(own, pixel % kSide, pixel / kSide, {0, 0, 0});
        means.push_back(0);
        squares.push_back(0);
        for (std::size_t c = 0; c < 3; ++c) {
            const double got = image[static_cast<std::size_t>(3 * pixel) + c];
            means.back() += 255 * (got - exact[c]) / 3;
            squares.back() += std::pow(255 * (got - exact[c]), 2) / 3;
        }
    }
    const auto moments = [](const std::vector<double>& values, double& mean, double& deviation) {
        double variance = 0;
        for (const double v : values) mean += v / kPixels;
        for (const double v : values) variance += (v - mean) * (v - mean) / (kPixels - 1);
        deviation = std::sqrt(variance / kPixels);
    };
    Error error;
    moments(means, error.mean, error.mean_deviation);
    moments(squares, error.square, error.square_deviation);
    return error;
}

// Expected: of 30 times as many pixels, to two decimals.
struct Expected {
    const char* keys;
    const Layers* layers;
    double mean;
    double rms;
};
void expect_errors(std::span<const Expected> table) {
    for (const Expected& e : table) {
        Random random(1);
        const Error got = error_of(e.keys, *e.layers, random_layers(*e.layers, random));
        // Five standard deviations of both estimates, and of the last decimal half.
        const double sigmas = 5 * std::sqrt(1 + 1 / 30.0);
        EXPECT_NEAR(got.mean, e.mean, sigmas * got.mean_deviation + 0.005) << e.keys;
        EXPECT_NEAR(got.square, e.rms * e.rms, sigmas * got.square_deviation + 0.01 * e.rms + 1e-5) << e.keys;
    }
}

// Underestimation is dark: weights sum to less than total alpha. Allowing the last node to go is better than
// DXAOIT's rule at 8 nodes, and worse at 16, where its half protected in front pays; over many faint layers
// that half costs twice the darkness at any number of nodes.
TEST(AdaptiveStatistics, UnderestimationIsDark) {
    static constexpr Expected kTable[] = {
        {"nodes=4", &kColoured32, -40.91, 41.90},
        {"nodes=8", &kColoured32, -18.05, 18.52},
        {"nodes=8", &kWhite32, -36.06, 36.38},
        {"nodes=8,candidates=protect_furthest", &kColoured32, -21.03, 21.56},
        {"nodes=8,candidates=protect_front_half", &kColoured32, -22.72, 23.25},
        {"nodes=16", &kColoured32, -5.20, 5.51},
        {"nodes=16,candidates=protect_front_half", &kColoured32, -4.59, 4.72},
        {"nodes=8", &kWhite200, -27.05, 27.12},
        {"nodes=8,candidates=protect_front_half", &kWhite200, -50.99, 51.26},
        {"nodes=16", &kColoured200, -6.63, 6.65},
        {"nodes=16,candidates=protect_front_half", &kColoured200, -12.34, 12.41}};
    expect_errors(kTable);
}

// Scaled to total alpha the mean is right, layers of one colour are exact, and RMS falls to a fourth or
// fifth.
TEST(AdaptiveStatistics, NormalisationGivesTheLightBack) {
    static constexpr Expected kTable[] = {
        {"nodes=4,composite=normalised", &kColoured32, -0.03, 8.07},
        {"nodes=8,composite=normalised", &kColoured32, -0.03, 3.48},
        {"nodes=8,candidates=protect_front_half,composite=normalised", &kColoured32, -0.02, 5.20},
        {"nodes=16,composite=normalised", &kColoured32, -0.01, 1.33},
        {"nodes=16,candidates=protect_front_half,composite=normalised", &kColoured32, -0.01, 1.14},
        {"nodes=8,composite=normalised", &kWhite200, 0, 0}};
    expect_errors(kTable);
}

// Overestimation is as bright as underestimation is dark, and a little worse; choosing node by node keeps
// both from adding up.
TEST(AdaptiveStatistics, OverestimationIsBrightAndTheChoiceInBetween) {
    static constexpr Expected kTable[] = {
        {"nodes=4,removal=overestimate", &kColoured32, 51.21, 52.41},
        {"nodes=8,removal=overestimate", &kColoured32, 21.10, 21.68},
        {"nodes=8,removal=overestimate,candidates=protect_furthest", &kColoured32, 24.99, 25.61},
        {"nodes=4,removal=node_by_node", &kColoured32, -6.49, 14.71},
        {"nodes=8,removal=node_by_node", &kColoured32, -6.68, 8.64},
        {"nodes=16,removal=node_by_node", &kColoured32, -3.04, 3.61},
        {"nodes=8,removal=node_by_node", &kColoured200, -0.12, 1.52}};
    expect_errors(kTable);
}

// Mean over pixels of how far the images of six orders of arrival lie apart, in 1/255. "Negligible
// sensitivity ... when using more than ~8 nodes" (section 5.1) holds from about 16; node by node it is worse.
TEST(AdaptiveStatistics, OrderOfArrival) {
    struct Spread {
        const char* keys;
        Layers layers;
        double low, high;
    };
    static constexpr Spread kTable[] = {
        {"nodes=4", {32, 0.15f, {0, 1}}, 11.0, 13.0},
        {"nodes=8", {32, 0.15f, {0, 1}}, 4.2, 5.0},
        {"nodes=8", {100, 0.05f, {0, 1}}, 5.5, 6.5},
        {"nodes=8", {100, 0.15f, {0, 1}}, 8.2, 9.6},
        {"nodes=16", {32, 0.15f, {0, 1}}, 0.9, 1.3},
        {"nodes=16", {100, 0.15f, {0, 1}}, 2.3, 3.1},
        {"nodes=8,removal=node_by_node", {32, 0.15f, {0, 1}}, 11.0, 13.0},
        {"nodes=8,composite=normalised", {32, 0.15f, {0, 1}}, 3.2, 3.9},
    };
    for (const Spread& expected : kTable) {
        Random random(7);
        auto fragments = random_layers(expected.layers, random);
        std::vector<std::vector<float>> images;
        for (int order = 0; order < 6; ++order) {
            images.push_back(image_of(expected.keys, fragments, 0));
            random.shuffle(fragments);
        }
        double spread = 0;
        for (std::size_t i = 0; i < images[0].size(); ++i) {
            float low = images[0][i];
            float high = low;
            for (const auto& image : images) {
                low = std::min(low, image[i]);
                high = std::max(high, image[i]);
            }
            spread += 255 * static_cast<double>(high - low) / static_cast<double>(images[0].size());
        }
        EXPECT_GT(spread, expected.low) << expected.keys << " " << expected.layers.count;
        EXPECT_LT(spread, expected.high) << expected.keys << " " << expected.layers.count;
    }
}

// What overestimation adds to total transmittance: little where the last node's area ends at the far plane,
// half of full scale and more where its error is taken to be equation 7's, as printed for both ways.
TEST(AdaptiveStatistics, OverestimationLetsMoreThrough) {
    struct Row {
        std::size_t nodes;
        Layers layers;
        double mean, mean_as_printed;  // of 300 pixels
    };
    static constexpr Row kTable[] = {{4, {32, 0.15f, {0, 0}}, 0.025, 0.105},
                                     {8, {32, 0.15f, {0, 0}}, 0.0118, 0.0276},
                                     {4, {200, 0.01f, {0, 0}}, 0.058, 0.226},
                                     {8, {200, 0.01f, {0, 0}}, 0.0288, 0.0917}};
    for (const Row& row : kTable) {
        Random random(8);
        const auto fragments = random_layers(row.layers, random);
        const double exact = std::pow(1.0 - static_cast<double>(row.layers.alpha), row.layers.count);
        const auto image = image_of(fmt::format("nodes={},removal=overestimate", row.nodes), fragments, 1);
        double mean = 0;
        for (const float v : image) mean += (v - exact) / static_cast<double>(image.size());
        EXPECT_NEAR(mean, row.mean, 0.12 * row.mean) << row.nodes << " of " << row.layers.count;
        double printed = 0;
        double worst = 0;
        for (int pixel = 0; pixel < kPixels; ++pixel) {
            test::SlowCurve curve;
            curve.most_nodes = row.nodes;
            curve.removal = "overestimate";
            curve.equation_7_for_both = true;
            for (int i = 0; i < row.layers.count; ++i)
                curve.insert(fragments[static_cast<std::size_t>(pixel * row.layers.count + i)].z,
                             1.0f - row.layers.alpha);
            printed += (curve.nodes.back().t - exact) / kPixels;
            worst = std::max(worst, curve.nodes.back().t - exact);
        }
        EXPECT_NEAR(printed, row.mean_as_printed, 0.12 * row.mean_as_printed) << row.nodes;
        if (row.nodes == 4) {
            EXPECT_GT(worst, 0.45) << row.layers.count;
        }
    }
}

}  // namespace
}  // namespace ropsim
