// What the formats of phenomenological transparency's displacement and diffusion (McGuire and Mara 2017,
// Table 2) lose over many layers: codes of 1/127 and 1/255, each standing for 63 pixels, or 63 pixels
// squared.
#include "tests/rop/phenomenological_pixel.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using Pixel = test::TransparentPixel;

// Glass whose one layer of alpha 1 displaces the background sideways, and by how many pixels.
class Refractor {
 public:
    explicit Refractor(float tilt) {
        glass_.eta = 1.5f;
        const glm::vec3 normal = glm::normalize(glm::vec3(tilt, 0, 1));
        for (int c = 0; c < 3; ++c) glass_.normal[c] = normal[c];
        Pixel whole = Pixel::of_materials(",refraction_weight=alpha,delta_format=float32");
        whole.draw(kDepth, 1, {0, 0, 0}, glass_);
        pixels_ = 63 * whole.stored(test::kOffsetWord);
    }
    double sign() const { return pixels_ < 0 ? -1 : 1; }
    // Draws `layers` of `by` pixels each, and gives the target's displacement in pixels.
    double draw(Pixel& pixel, double by, int layers) const {
        EXPECT_LT(by, std::abs(pixels_));
        for (int n = 0; n < layers; ++n)
            pixel.draw(kDepth, static_cast<float>(by / std::abs(pixels_)), {0, 0, 0}, glass_);
        return sign() * 63 * pixel.stored(test::kOffsetWord);
    }

 private:
    static constexpr float kDepth = 0.5f;
    Material glass_;
    double pixels_;
};

// A code of RT2 is 63/127 of a pixel: Table 2's "roughly half a pixel". A layer adds whole codes: none below
// 1/254 of 63 pixels, .248, however many there are, and twice its displacement just above.
TEST(PhenomenologicalPrecision, ManySmallDisplacementsNeverAddOrDouble) {
    const Refractor glass(-0.8f);
    const auto after = [&](const std::string& format, double by, int layers) {
        Pixel pixel = Pixel::of_materials(",refraction_weight=alpha,delta_format=" + format);
        return glass.draw(pixel, by, layers);
    };
    const double code = 63.0 / 127;
    EXPECT_NEAR(code, 0.496, 5e-4);
    for (const double by : {0.1, 0.24, 0.247, 0.249, 0.3, 0.7, 0.8, 2.0, 5.0}) {
        const int layers = 10;
        EXPECT_NEAR(after("snorm8", by, layers), layers * code * std::floor(by / code + 0.5), 1e-4) << by;
        EXPECT_NEAR(after("float16", by, layers), layers * by, 0.01 * layers * by) << by;
    }
    EXPECT_EQ(after("snorm8", 0.247, 1000), 0);
    EXPECT_NEAR(after("float16", 0.05, 100), 5, 0.15);
    EXPECT_NEAR(after("snorm8", 0.249, 100) / 24.9, 2, 0.02);
}

// The sum stops at 63 pixels either way after every layer, not at the end: 40 + 40 - 40 is 23, and in another
// order 40. Nothing else in these targets depends on order by more than its rounding.
TEST(PhenomenologicalPrecision, DisplacementsSaturateOneByOne) {
    const Refractor right(-0.8f);
    const Refractor left(0.8f);
    ASSERT_NE(right.sign(), left.sign());
    const auto sum = [&](const std::string& format, std::initializer_list<const Refractor*> order) {
        Pixel pixel = Pixel::of_materials(",refraction_weight=alpha,delta_format=" + format);
        double pixels = 0;
        for (const Refractor* r : order) pixels = r->sign() * r->draw(pixel, 20, 2);
        return right.sign() * pixels;
    };
    const double code = 63.0 / 127;
    EXPECT_NEAR(sum("snorm8", {&right, &right}), 63, 1e-4);
    EXPECT_NEAR(sum("snorm8", {&right, &right, &left}), 63 - 40, code);
    EXPECT_NEAR(sum("snorm8", {&right, &left, &right}), 40, code);
    EXPECT_NEAR(sum("snorm8", {&right, &right, &left, &left}), 63 - 80, 2 * code);
    EXPECT_NEAR(sum("snorm8", {&left, &left, &right, &right}), 80 - 63, 2 * code);
    EXPECT_NEAR(sum("snorm8", {&left, &right, &left, &right}), 0, 1e-4);
    for (const auto order : {std::initializer_list<const Refractor*>{&right, &right, &left},
                             std::initializer_list<const Refractor*>{&right, &left, &right}})
        EXPECT_NEAR(sum("float16", order), 40, 0.1);
}

// Scattering layers of deviation `by` pixels each; the deviation that the target holds after `layers`.
double diffused(const std::string& parameters, double by, int layers) {
    const std::string scatters = ",background=infinite,k0=1" + parameters;
    const Material fog{.transmission = {0, 0, 0}, .collimation = 0};
    Pixel whole = Pixel::of_materials(",background=infinite,k0=1,format=float32");
    whole.draw(0.5f, 1, {0, 0, 0}, fog);
    const double pixels = 63 * std::sqrt(whole.stored(test::kDiffusionWord));
    EXPECT_LT(by, pixels);
    Pixel pixel = Pixel::of_materials(scatters);
    for (int n = 0; n < layers; ++n) pixel.draw(0.5f, static_cast<float>(by / pixels), {0, 0, 0}, fog);
    return 63 * std::sqrt(pixel.stored(test::kDiffusionWord));
}

// D is kept squared, so its 256 steps are far apart where it is small: 0, 3.95, 5.58, 6.83 pixels, and half a
// pixel ("roughly", Table 2) only from 15.6 on, where Listing 3's kernels end.
TEST(PhenomenologicalPrecision, DeviationsBelowFourPixelsAreFour) {
    const auto code = [](int n) { return 63 * std::sqrt(n / 255.0); };
    EXPECT_NEAR(code(1), 3.945, 5e-4);
    EXPECT_NEAR(code(2), 5.579, 5e-4);
    EXPECT_GT(code(16) - code(15), 0.5);
    EXPECT_LT(code(17) - code(16), 0.5);
    for (const double by : {0.01, 0.5, 2.7, 2.9, 4.0, 6.0, 9.0}) {
        const double codes = std::floor(255 * (by / 63) * (by / 63) + 0.5);
        EXPECT_NEAR(diffused("", by, 1), code(std::max(1, static_cast<int>(codes))), 1e-3) << by;
        EXPECT_NEAR(diffused(",underflow=round", by, 1), code(static_cast<int>(codes)), 1e-3) << by;
    }
    EXPECT_EQ(diffused(",underflow=round", 2.78, 100), 0);
    EXPECT_GT(diffused(",underflow=round", 2.80, 1), 3.9);
}

// The paper rounds up so that many faint layers do not vanish. n of them then have 63 sqrt(n / 255) pixels,
// whatever their own deviation: 17 are enough for the widest kernel of 16 pixels, and 255 for the end.
TEST(PhenomenologicalPrecision, FaintLayersOverDiffuse) {
    for (const int n : {1, 4, 17, 64, 255, 300}) {
        const double expected = 63 * std::sqrt(std::min(n, 255) / 255.0);
        EXPECT_NEAR(diffused("", 0.05, n), expected, 1e-3) << n;
        EXPECT_NEAR(diffused(",beta_format=float16", 0.05, n), 0.05 * std::sqrt(n), 0.02 * std::sqrt(n)) << n;
    }
    EXPECT_LT(diffused("", 0.05, 16), 16);
    EXPECT_GT(diffused("", 0.05, 17), 16);
    EXPECT_NEAR(0.05 * std::sqrt(255), 0.8, 2e-3);
    // Sixteen bits: steps of .246 pixels for the first, and 24 layers of 1 pixel are 4.9 pixels, not 19.3.
    EXPECT_NEAR(diffused(",beta_format=unorm16", 0.05, 255), 63 * std::sqrt(255.0 / 65535), 1e-3);
    EXPECT_NEAR(diffused(",beta_format=unorm16", 1, 24), std::sqrt(24), 0.1);
    EXPECT_NEAR(diffused("", 1, 24), 19.3, 0.05);
}

}  // namespace
}  // namespace ropsim
