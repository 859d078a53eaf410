// FLIP against a slow, direct transcription of its definition and the limits known from the paper.
#include "rop/flip.h"

#include "rop/image_metrics.h"
#include "tests/rop/synthetic_images.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::blend;
using test::Color;
using test::constant;
using test::filled;
using test::noise;

// FLIP transcribed from the paper with two-dimensional filters, the full opponent space and the C library.
struct SlowFlip {
    static constexpr double kPi = std::numbers::pi;
    static constexpr double kPpd = 67;
    using Vec = std::array<double, 3>;
    static Vec xyz(const Vec& c) {
        return {.4123865632529917 * c[0] + .35759149092062537 * c[1] + .18045049120356368 * c[2],
                .21263682167732384 * c[0] + .7151829818412507 * c[1] + .07218019648142547 * c[2],
                .019330620152483987 * c[0] + .11919716364020845 * c[1] + .9503725870054354 * c[2]};
    }
    static Vec rgb(const Vec& c) {
        return {3.2410032329763587 * c[0] - 1.5373989694887855 * c[1] - .4986158819963629 * c[2],
                -.9692242522025166 * c[0] + 1.875929983695176 * c[1] + .041554226340084724 * c[2],
                .055639419851975444 * c[0] - .20401120612390997 * c[1] + 1.0571489771875335 * c[2]};
    }
    static constexpr Vec kWhite{.9504285453771807, 1.0, 1.0889003707981277};
    static Vec hunt(const Vec& linear) {
        const Vec c = xyz(linear);
        Vec f{};
        for (std::size_t i = 0; i < 3; ++i) {
            const double t = c[i] / kWhite[i];
            f[i] = t > 216.0 / 24389.0 ? std::cbrt(t) : t * 841.0 / 108.0 + 4.0 / 29.0;
        }
        const double lightness = 116 * f[1] - 16;
        return {lightness, .01 * lightness * 500 * (f[0] - f[1]), .01 * lightness * 200 * (f[1] - f[2])};
    }
    static double hyab(const Vec& a, const Vec& b) {
        return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
    }
    static Vec opponent(const Image& image, int x, int y) {
        const float* p = image.pixel(std::clamp(x, 0, image.width - 1), std::clamp(y, 0, image.height - 1));
        const Vec c = xyz({p[0], p[1], p[2]});
        const double yy = c[1] / kWhite[1];
        return {116 * yy - 16, 500 * (c[0] / kWhite[0] - yy), 200 * (yy - c[2] / kWhite[2])};
    }
    static Vec perceived(const Image& image, int x, int y) {
        const double a1[3] = {1, 1, 34.1}, b1[3] = {.0047, .0053, .04}, a2[3] = {0, 0, 13.5},
                     b2[3] = {1e-5, 1e-5, .025};
        const int radius = static_cast<int>(std::ceil(3 * std::sqrt(.04 / (2 * kPi * kPi)) * kPpd));
        Vec sum{}, weight{};
        for (int dy = -radius; dy <= radius; ++dy)
            for (int dx = -radius; dx <= radius; ++dx) {
                const Vec c = opponent(image, x + dx, y + dy);
                const double d2 = (dx * dx + dy * dy) / (kPpd * kPpd);
                for (std::size_t i = 0; i < 3; ++i) {
                    const double g = a1[i] * std::sqrt(kPi / b1[i]) * std::exp(-kPi * kPi * d2 / b1[i]) +
                                     a2[i] * std::sqrt(kPi / b2[i]) * std::exp(-kPi * kPi * d2 / b2[i]);
                    sum[i] += g * c[i];
                    weight[i] += g;
                }
            }
        for (std::size_t i = 0; i < 3; ++i) sum[i] /= weight[i];
        const double yy = (sum[0] + 16) / 116;
        Vec linear = rgb({(sum[1] / 500 + yy) * kWhite[0], yy, (yy - sum[2] / 200) * kWhite[2]});
        for (double& v : linear) v = std::clamp(v, 0.0, 1.0);
        return hunt(linear);
    }
    // Lengths of the edge and the point response.
    static std::array<double, 2> features(const Image& image, int x, int y) {
        const double sd = .5 * .082 * kPpd;
        const int radius = static_cast<int>(std::ceil(3 * sd));
        double response[2][2] = {};
        for (int kind = 0; kind < 2; ++kind)
            for (int axis = 0; axis < 2; ++axis) {
                const auto kernel = [&](int dx, int dy) {
                    const double u = axis == 0 ? dx : dy;
                    const double g = std::exp(-(dx * dx + dy * dy) / (2 * sd * sd));
                    return kind == 0 ? -u * g : (u * u / (sd * sd) - 1) * g;
                };
                double up = 0, down = 0;
                for (int dy = -radius; dy <= radius; ++dy)
                    for (int dx = -radius; dx <= radius; ++dx)
                        (kernel(dx, dy) > 0 ? up : down) += std::abs(kernel(dx, dy));
                for (int dy = -radius; dy <= radius; ++dy)
                    for (int dx = -radius; dx <= radius; ++dx) {
                        const double k = kernel(dx, dy);
                        response[kind][axis] +=
                            k / (k > 0 ? up : down) * (opponent(image, x + dx, y + dy)[0] + 16) / 116;
                    }
            }
        return {std::hypot(response[0][0], response[0][1]), std::hypot(response[1][0], response[1][1])};
    }
    static double remap(double distance) {
        const double cmax = std::pow(hyab(hunt({0, 1, 0}), hunt({0, 0, 1})), .7);
        const double e = std::pow(distance, .7), knee = .4 * cmax;
        return e < knee ? .95 / knee * e : .95 + (e - knee) / (cmax - knee) * .05;
    }
    static double mean(const Image& a, const Image& b) {
        double total = 0;
        for (int y = 0; y < a.height; ++y)
            for (int x = 0; x < a.width; ++x) {
                const double color = remap(hyab(perceived(a, x, y), perceived(b, x, y)));
                const auto f = features(a, x, y), g = features(b, x, y);
                const double structure =
                    std::sqrt(std::max(std::abs(f[0] - g[0]), std::abs(f[1] - g[1])) / std::sqrt(2.0));
                total += std::pow(color, 1 - structure);
            }
        return total / (a.width * a.height);
    }
};

TEST(Flip, BlackAgainstWhite) {
    // Lightness 0 against 100, no chroma, no features: the published colour pipeline gives 0.9674.
    const double flip = image_error(constant(24, 24, {0, 0, 0}), constant(24, 24, {1, 1, 1})).flip;
    EXPECT_NEAR(flip, SlowFlip::remap(100.0), 2e-5);
    EXPECT_NEAR(flip, 0.9674, 1e-4);
}

TEST(Flip, GreenAgainstBlueIsTheLargest) {
    EXPECT_NEAR(image_error(constant(24, 24, {0, 1, 0}), constant(24, 24, {0, 0, 1})).flip, 1.0, 1e-6);
}

TEST(Flip, AgreesWithTheDefinition) {
    const Image a = noise(13, 11, 7);
    const Image edge = filled(13, 11, [](int x, int y) {
        return x + y / 3 < 7 ? Color{.1f, .2f, .7f} : Color{.9f, .6f, .2f};
    });
    const Image mixed = blend(a, edge, .7f);
    EXPECT_NEAR(image_error(a, edge).flip, SlowFlip::mean(a, edge), 2e-5);
    EXPECT_NEAR(image_error(mixed, edge).flip, SlowFlip::mean(mixed, edge), 2e-5);
}

}  // namespace
}  // namespace ropsim
