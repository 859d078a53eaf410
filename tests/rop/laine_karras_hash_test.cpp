// Opacity references through the technique: what Laine and Karras 2011, section 3, say of sequences and of
// the order of pixels.
#include "tests/rop/pixel_moments.h"

namespace ropsim {
namespace {

constexpr int kSide = 256;

std::vector<float> white_layers(const std::string& parameters, int layers, float alpha) {
    std::vector<Fragment> drawn;
    for (int i = 0; i < layers; ++i)
        drawn.push_back(test::fragment_at(0, 0, 0.9f - 0.05f * static_cast<float>(i), alpha, {1, 1, 1},
                                          static_cast<std::uint32_t>(i)));
    return test::image_of_layers("laine_karras:format=float32," + parameters, drawn, glm::vec3(0.0f), kSide,
                                 0);
}

// Figure 3: 8 white surfaces of alpha 0.1, 8 samples. The exact coverage is .5695. The plain radical inverse
// gives "almost constant" references whatever the surface, so that the surfaces hide each other: 0.1. Sobol's
// second dimension leaves "significant correlations": here surfaces avoid each other, 0.8.
TEST(Sequence, EightSurfacesOfATenth) {
    const double exact = 1 - std::pow(0.9, 8);
    EXPECT_NEAR(exact, 0.5695, 5e-5);
    const auto mean = [](const std::string& stages, const char* hash) {
        return test::moments_of(white_layers(stages + "hash=" + hash, 8, 0.1f), 0);
    };
    // As in the figure, nothing but the sequence.
    EXPECT_NEAR(mean("compaction=false,", "radical_inverse").mean, 0.1, 1e-4);
    EXPECT_NEAR(mean("compaction=false,", "sobol").mean, 0.8, 1e-4);
    // Compaction and sorting, which the sequences then pass through, do not mend them: far surfaces first,
    // the radical inverse still has 0.1, and Sobol's is exact by chance at 0.1 and not at 0.3 (.9424).
    EXPECT_NEAR(mean("", "radical_inverse").mean, 0.1, 1e-4);
    EXPECT_NEAR(test::moments_of(white_layers("hash=sobol", 8, 0.3f), 0).mean, 0.9641, 1e-3);
    for (const char* stages : {"compaction=false,", "sort=false,", ""})
        for (const char* hash : {"paper", "improved"}) {
            const test::Moments m = mean(stages, hash);
            EXPECT_NEAR(m.mean, exact, 4 * m.deviation() / kSide) << stages << hash;
        }
}

// The bits of pixels go on where those of samples end (3.1): blocks of pixels hold their share to a sample,
// of the Hilbert curve and of Morton's, where random masks spread.
TEST(PixelOrder, BlocksOfPixelsAreStratified) {
    const auto worst = [](const std::vector<float>& image, int block, float alpha) {
        double most = 0;
        for (int by = 0; by < kSide; by += block)
            for (int bx = 0; bx < kSide; bx += block) {
                double sum = 0;
                for (int i = 0; i < block * block; ++i)
                    sum +=
                        8 *
                        static_cast<double>(
                            image[static_cast<std::size_t>(3 * ((by + i / block) * kSide + bx + i % block))]);
                most = std::max(most, std::abs(sum - static_cast<double>(alpha) * 8 * block * block));
            }
        return most;
    };
    for (const float alpha : {0.1f, 0.61f})
        for (const int block : {2, 4, 16}) {
            for (const char* index : {"hilbert", "morton"})
                EXPECT_LE(worst(white_layers(std::string("index=") + index, 1, alpha), block, alpha), 1.0)
                    << index << block;
            const auto random = test::image_of_layers("stochastic:format=float32",
                                                      {test::fragment_at(0, 0, 0.5f, alpha, {1, 1, 1})},
                                                      glm::vec3(0.0f), kSide);
            EXPECT_GT(worst(random, block, alpha), 1.2) << block;
        }
}

// Mean of the rows of even y less that of the others.
double row_difference(const std::vector<float>& image) {
    double difference = 0;
    for (std::size_t i = 0; i < image.size(); i += 3)
        difference += (i / 3 / kSide % 2 == 0 ? 2 : -2) * static_cast<double>(image[i]) / (kSide * kSide);
    return difference;
}

// 3.1: with Morton's order "pixels with even y coordinate have a different expected value than pixels with
// odd y coordinate". That is so of the radical inverse: alpha .1, 8 samples, 0.8 of them to take. The sample
// of the lowest reference has the fraction x0 / 2 + y0 / 4 + ... of its eighth from the pixel's bits, and is
// taken below .8: always where y is even, .6 of the time where it is odd, a difference of .4 / 8. Hilbert's
// curve has none. Neither has Morton's with the scramble, whose flips differ from block to block: the
// sentence describes the sequence before it.
TEST(PixelOrder, MortonsRowsDifferWithoutScrambling) {
    EXPECT_NEAR(row_difference(white_layers("index=morton,hash=radical_inverse", 1, 0.1f)), 0.05, 1e-4);
    EXPECT_NEAR(row_difference(white_layers("index=hilbert,hash=radical_inverse", 1, 0.1f)), 0, 0.002);
    for (const char* hash : {"paper", "improved"})
        for (const char* index : {"morton", "hilbert"})
            for (const int layers : {1, 3}) {
                const auto image =
                    white_layers(std::string("index=") + index + ",hash=" + hash, layers, 0.1f);
                EXPECT_NEAR(row_difference(image), 0, 4 * 2 * test::moments_of(image, 0).deviation() / kSide)
                    << index << hash << layers;
            }
}

}  // namespace
}  // namespace ropsim
