// Error figures against closed forms, hand calculations and slow, direct transcriptions of the definitions.
#include "rop/image_metrics.h"

#include "base/error.h"
#include "rop/transcendental.h"
#include "tests/rop/synthetic_images.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::blend;
using test::Color;
using test::constant;
using test::filled;
using test::noise;

TEST(DeterministicPower, AgreesWithTheCLibrary) {
    for (int i = 1; i <= 4000; ++i) {
        const double x = i * 0.00037;
        for (const double y : {0.7, 1.0 / 3.0, 1.0 / 2.4, -2.5, 11.0})
            EXPECT_NEAR(deterministic_power(x, y) / std::pow(x, y), 1.0, 1e-13) << x << "^" << y;
    }
    EXPECT_EQ(deterministic_power(0.0, 0.5), 0.0);
    EXPECT_EQ(deterministic_power(0.0, 0.0), 1.0);
    EXPECT_EQ(deterministic_power(4.0, 0.5), 2.0);
}

TEST(ImageError, EqualImagesHaveNoError) {
    const Image image = noise(40, 30, 1);
    const ImageError error = image_error(image, image);
    EXPECT_EQ(error.rmse8, 0.0);
    EXPECT_TRUE(std::isinf(error.psnr_db));
    EXPECT_EQ(error.max_abs, 0.0);
    EXPECT_EQ(error.mean_signed8, 0.0);
    EXPECT_EQ(error.ssim, 1.0);
    EXPECT_EQ(error.flip, 0.0);
    EXPECT_TRUE(std::isnan(error.rmse8_covered));
}

TEST(ImageError, ConstantOffset) {
    const ImageError error =
        image_error(constant(20, 20, {.5f, .5f, .5f}), constant(20, 20, {.25f, .25f, .25f}));
    EXPECT_DOUBLE_EQ(error.rmse8, 63.75);
    EXPECT_DOUBLE_EQ(error.psnr_db, 20 * std::log10(4.0));
    EXPECT_DOUBLE_EQ(error.max_abs, .25);
    EXPECT_DOUBLE_EQ(error.mean_signed8, 63.75);
}

// One channel of one of eight pixels differs by 0.5: mean square (127.5^2)/(8*3).
TEST(ImageError, OnePixel) {
    Image image = constant(4, 2, {.25f, .25f, .25f});
    const Image reference = image;
    image.pixel(3, 1)[1] = -.25f + 1.0f;
    std::vector<std::uint8_t> covered(8, 0);
    covered[7] = covered[0] = 1;
    const ImageError error = image_error(image, reference, covered);
    EXPECT_DOUBLE_EQ(error.rmse8, 127.5 / std::sqrt(24.0));
    EXPECT_DOUBLE_EQ(error.rmse8_covered, 127.5 / std::sqrt(6.0));
    EXPECT_DOUBLE_EQ(error.mean_signed8, 127.5 / 24.0);
    EXPECT_DOUBLE_EQ(image_error(reference, image).mean_signed8, -127.5 / 24.0);
}

TEST(ImageError, EightBitFiguresClampAndTheLargestDifferenceDoesNot) {
    const ImageError error = image_error(constant(2, 2, {3.f, 1.f, -.5f}), constant(2, 2, {1.f, 1.f, 0.f}));
    EXPECT_EQ(error.rmse8, 0.0);
    EXPECT_EQ(error.max_abs, 2.0);
}

TEST(ImageError, ValuesThatAreNotFiniteAreFullErrors) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const Image reference = constant(1, 1, {1.f, 0.f, .5f});
    for (const float bad : {kInfinity, -kInfinity, std::numeric_limits<float>::quiet_NaN()}) {
        const ImageError error = image_error(constant(1, 1, {1.f, bad, .5f}), reference);
        EXPECT_DOUBLE_EQ(error.rmse8, 255.0 / std::sqrt(3.0)) << bad;
        EXPECT_TRUE(std::isinf(error.max_abs));
        EXPECT_DOUBLE_EQ(error.mean_signed8, bad < 0 ? -85.0 : 85.0);
        EXPECT_TRUE(std::isfinite(error.ssim));
        EXPECT_GT(error.flip, 0.3);
    }
}

TEST(ImageError, RefusesWhatCannotBeCompared) {
    EXPECT_THROW(image_error(constant(2, 2, {}), constant(2, 3, {})), UserError);
    EXPECT_THROW(image_error(Image(2, 2, {"R", "G"}), constant(2, 2, {})), UserError);
}

TEST(ImageError, AllButTheSignIsSymmetric) {
    const ImageError ab = image_error(noise(33, 21, 1), noise(33, 21, 2));
    const ImageError ba = image_error(noise(33, 21, 2), noise(33, 21, 1));
    EXPECT_EQ(ab.rmse8, ba.rmse8);
    EXPECT_EQ(ab.ssim, ba.ssim);
    EXPECT_EQ(ab.flip, ba.flip);
    EXPECT_EQ(ab.mean_signed8, -ba.mean_signed8);
}

TEST(ImageError, GrowsWithTheDifference) {
    const Image a = noise(48, 40, 3), b = noise(48, 40, 4);
    ImageError last = image_error(a, a);
    for (const float t : {.1f, .3f, .6f, 1.f}) {
        const ImageError now = image_error(blend(a, b, t), a);
        EXPECT_GT(now.rmse8, last.rmse8);
        EXPECT_LT(now.psnr_db, last.psnr_db);
        EXPECT_LT(now.ssim, last.ssim);
        EXPECT_GT(now.flip, last.flip);
        last = now;
    }
}

double encoded(double v) {
    return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
}

// Flat images: only the luminance term of SSIM is left.
TEST(Ssim, FlatImages) {
    const double a = encoded(.25), b = encoded(.5);
    const double expected = (2 * a * b + 1e-4) / (a * a + b * b + 1e-4);
    EXPECT_NEAR(image_error(constant(16, 16, {.25f, .25f, .25f}), constant(16, 16, {.5f, .5f, .5f})).ssim,
                expected, 1e-10);
}

// The definition, window by window, with central moments instead of differences of raw ones.
double slow_ssim(const Image& a, const Image& b) {
    const auto luma = [](const Image& image, int x, int y) {
        const float* p = image.pixel(x, y);
        return .2126 * encoded(p[0]) + .7152 * encoded(p[1]) + .0722 * encoded(p[2]);
    };
    double total = 0;
    int windows = 0;
    for (int cy = 5; cy + 5 < a.height; ++cy) {
        for (int cx = 5; cx + 5 < a.width; ++cx, ++windows) {
            double w = 0, ma = 0, mb = 0, va = 0, vb = 0, cov = 0;
            const auto each = [&](const auto& visit) {
                for (int dy = -5; dy <= 5; ++dy)
                    for (int dx = -5; dx <= 5; ++dx)
                        visit(std::exp(-(dx * dx + dy * dy) / 4.5), luma(a, cx + dx, cy + dy),
                              luma(b, cx + dx, cy + dy));
            };
            each([&](double g, double p, double q) { w += g, ma += g * p, mb += g * q; });
            ma /= w, mb /= w;
            each([&](double g, double p, double q) {
                va += g / w * (p - ma) * (p - ma), vb += g / w * (q - mb) * (q - mb),
                    cov += g / w * (p - ma) * (q - mb);
            });
            total +=
                (2 * ma * mb + 1e-4) * (2 * cov + 9e-4) / ((ma * ma + mb * mb + 1e-4) * (va + vb + 9e-4));
        }
    }
    return total / windows;
}

TEST(Ssim, AgreesWithTheDefinition) {
    const Image a = noise(21, 17, 5), b = blend(a, noise(21, 17, 6), .4f);
    EXPECT_NEAR(image_error(b, a).ssim, slow_ssim(b, a), 1e-10);
}

}  // namespace
}  // namespace ropsim
