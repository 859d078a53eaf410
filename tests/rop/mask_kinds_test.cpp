// Kinds of masks through the technique: dither (Enderton et al. 2011, section 3.1), the precomputed table
// (5), alpha to coverage as fixed hardware does it (3.5), blue noise (Wolfe et al. 2022).
#include "tests/rop/mask_outcomes.h"

namespace ropsim {
namespace {

using test::TestFrame;

constexpr glm::vec3 kBlack(0.0f);

// Samples taken in each pixel by one white layer over black, row by row.
std::vector<double> taken(const std::string& technique, float alpha, int samples, int side) {
    const auto image =
        test::image_of_layers(technique, {test::fragment_at(0, 0, 0.5f, alpha, {1, 1, 1})}, kBlack, side);
    std::vector<double> counts;
    for (std::size_t i = 0; i < image.size(); i += 3)
        counts.push_back(static_cast<double>(image[i]) * samples);
    return counts;
}

// 3.1: "R could be dithered across a tile": round(64 alpha S) samples in every tile, each pixel with
// floor(alpha S) or one more.
TEST(Dither, TilesHoldTheRoundedNumberOfSamples) {
    for (const char* masks : {"choose", "run"})
        for (const int samples : {1, 4, 8})
            for (const float alpha : {0.013f, 0.31f, 0.5f, 0.777f, 1.0f}) {
                const auto counts =
                    taken("stochastic:rounding=dither,format=float32,masks=" + std::string(masks) +
                              ",samples=" + std::to_string(samples),
                          alpha, samples, 16);
                const double exact = static_cast<double>(alpha) * samples;
                for (int tile = 0; tile < 4; ++tile) {
                    double sum = 0;
                    for (int i = 0; i < 64; ++i) {
                        const int x = tile % 2 * 8 + i % 8;
                        const int y = tile / 2 * 8 + i / 8;
                        const double n = counts[static_cast<std::size_t>(16 * y + x)];
                        ASSERT_GE(n, std::floor(exact) - 1e-4);
                        ASSERT_LE(n, std::floor(exact) + 1 + 1e-4);
                        sum += n;
                    }
                    EXPECT_NEAR(sum, std::round(64 * exact), 1e-3) << masks << " " << alpha;
                }
            }
    // At random a tile's sum spreads: the test above is not of any rounding.
    const auto random = taken("stochastic:format=float32", 0.31f, 8, 8);
    EXPECT_GT(std::abs(std::accumulate(random.begin(), random.end(), 0.0) - std::round(64 * 0.31 * 8)), 0.5);
}

// Section 5's 1,024 levels of alpha: alphas of one level select the same samples, those of the next level up
// a superset, somewhere a larger one; alpha below half a level selects none.
TEST(Table, QuantisesAlpha) {
    const auto masks = [](float alpha) {
        TestFrame frame("stochastic:masks=table,samples=64", test::header_of(64, 64), 5);
        frame.draw(test::everywhere(frame.header(), {test::fragment_at(0, 0, 0.5f, alpha, {1, 1, 1})}));
        std::vector<std::uint64_t> written;
        for (std::size_t i = 0; i < frame.log().records(); ++i)
            written.push_back(frame.log().record_access(i)[0].write);
        return written;
    };
    const auto level = [](double number) { return static_cast<float>(number / 1023); };
    const auto middle = masks(level(511));
    EXPECT_EQ(masks(level(510.51)), middle);
    EXPECT_EQ(masks(level(511.49)), middle);
    const auto above = masks(level(511.51));
    EXPECT_NE(above, middle);
    for (std::size_t i = 0; i < middle.size(); ++i) ASSERT_EQ(middle[i] & ~above[i], 0u);
    for (const std::uint64_t mask : masks(level(0.49))) ASSERT_EQ(mask, 0u);
    for (const std::uint64_t mask : masks(level(1022.51))) ASSERT_EQ(mask, ~0ull);
}

// The mean over pixels is that of the nearest level, not alpha's own: half a level off is seen at 65,536
// pixels of 64 samples.
TEST(Table, MeanIsTheLevelsAlpha) {
    const auto alpha = static_cast<float>(299.55 / 1023);
    const auto counts = taken("stochastic:masks=table,samples=64,format=float32", alpha, 64, 256);
    double mean = 0;
    for (const double n : counts) mean += n / static_cast<double>(counts.size());
    const double fraction = 300.0 / 1023 * 64 - std::floor(300.0 / 1023 * 64);
    const double error = std::sqrt(fraction * (1 - fraction) / 65536);
    EXPECT_NEAR(mean, 300.0 / 1023 * 64, 4 * error);
    EXPECT_GT(std::abs(mean - static_cast<double>(alpha) * 64), 4 * error);
}

// Section 3.5: the fixed masks of alpha to coverage are alike in both layers, which hide each other: alpha a
// in place of 1 - (1 - a)^2, in every pixel, and the farther of two equal layers vanishes.
TEST(AlphaToCoverage, EqualLayersHideEachOther) {
    const std::vector<Fragment> layers = {test::fragment_at(0, 0, 0.6f, 0.5f, {0, 1, 0}, 0),
                                          test::fragment_at(0, 0, 0.4f, 0.5f, {1, 0, 0}, 1)};
    for (const char* order : {"far first", "near first"}) {
        auto drawn = layers;
        if (order[0] == 'n') std::swap(drawn[0], drawn[1]);
        const auto image =
            test::image_of_layers("stochastic:masks=alpha_to_coverage,format=float32", drawn, {0, 0, 1}, 32);
        for (std::size_t i = 0; i < image.size(); i += 3) {
            ASSERT_EQ(image[i], 0.5f) << order;
            ASSERT_EQ(image[i + 1], 0.0f) << order;
            ASSERT_EQ(image[i + 2], 0.5f) << order;
        }
    }
    const auto blended = test::image_of_layers("stochastic:format=float32", layers, {0, 0, 1});
    EXPECT_NEAR(test::moments_of(blended, 1).mean, 0.25, 0.01);
}
// And the mean is not alpha but the nearest eighth.
TEST(AlphaToCoverage, RoundsAlpha) {
    for (const auto& [alpha, count] : {std::pair(0.30f, 2), {0.32f, 3}, {0.06f, 0}, {0.95f, 8}})
        for (const double n : taken("stochastic:masks=alpha_to_coverage,format=float32", alpha, 8, 16))
            ASSERT_EQ(n, count) << alpha;
}

// Blue noise keeps the mean: a tile of the pattern holds every rank, so that it spreads less than random
// masks do over a block of pixels.
TEST(BlueNoise, MeanIsAlphaAndBlocksSpreadLess) {
    const auto spread = [](const std::string& masks, float alpha) {
        const auto counts = taken("stochastic:format=float32,masks=" + masks, alpha, 8, 256);
        std::vector<std::pair<double, double>> blocks;
        for (int block = 0; block < 64 * 64; ++block) {
            double sum = 0;
            for (int i = 0; i < 16; ++i)
                sum +=
                    counts[static_cast<std::size_t>((block / 64 * 4 + i / 4) * 256 + block % 64 * 4 + i % 4)];
            blocks.emplace_back(sum / 128, 1.0 / 4096);
        }
        return test::moments_of(blocks);
    };
    for (const float alpha : {0.1f, 0.45f, 0.8f}) {
        const test::Moments blue = spread("blue_noise", alpha);
        const test::Moments coin = spread("coin", alpha);
        EXPECT_NEAR(blue.mean, alpha, 4 * coin.deviation() / 64);
        EXPECT_NEAR(coin.variance, static_cast<double>(alpha) * (1 - static_cast<double>(alpha)) / 128,
                    4 * std::sqrt(2.0 / 4096) * coin.variance);
        EXPECT_LT(blue.variance, 0.5 * coin.variance) << alpha;
    }
}

}  // namespace
}  // namespace ropsim
