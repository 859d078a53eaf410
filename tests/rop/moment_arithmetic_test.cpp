// What reconstruction from moments is made of: quantisation, roots of polynomials, angles.
#include "rop/visibility/moment_quantisation.h"
#include "rop/visibility/real_roots.h"
#include "tests/rop/random_fragments.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;

// Stored numbers use [0, 1] and no more, and come back.
template <int kOrder>
void expect_quantiser() {
    const MomentQuantiser quantiser(kOrder);
    for (int i = 0; i <= 400; ++i) {
        const double z = -1 + i / 200.0;
        PowerMoments<kOrder, float> b;
        for (std::size_t k = 0; k < b.size(); ++k)
            b[k] = static_cast<float>(std::pow(z, static_cast<double>(k + 1)));
        auto stored = quantiser.mapped<kOrder, float>(b);
        for (std::size_t k = 0; k < b.size(); ++k) {
            stored[k] += quantiser.offset()[k];
            ASSERT_GE(stored[k], -2e-5f) << kOrder << " moment " << k + 1 << " at " << z;
            ASSERT_LE(stored[k], 1 + 2e-5f) << kOrder << " moment " << k + 1 << " at " << z;
        }
        const auto back = quantiser.restored<kOrder, float>(stored);
        for (std::size_t k = 0; k < b.size(); ++k) ASSERT_NEAR(back[k], b[k], 3e-5) << kOrder << " " << k;
    }
}
TEST(MomentQuantiser, UsesTheRangeAndComesBack) {
    expect_quantiser<2>();
    expect_quantiser<3>();
    expect_quantiser<4>();
}

// Roots apart from each other, of either sign, one of them up to 300 times larger: each to a part in 10^3 of
// itself and of its distance to the next.
TEST(RealRoots, OfPolynomialsWithOneLargeRoot) {
    Random random(26);
    for (int i = 0; i < 3000; ++i) {
        std::array<double, 4> r = {random.real(-2.2, -1.8), random.real(-0.6, -0.4), random.real(0.8, 1.2),
                                   random.real(2.5, 3.5)};
        const std::size_t large = i % 2 == 0 ? 0 : 3;
        if (i % 3 == 0) r[large] *= 100;
        const auto expect_roots = [&](auto found, std::size_t first) {
            std::ranges::sort(found);
            for (std::size_t k = 0; k < found.size(); ++k)
                ASSERT_NEAR(found[k], r[first + k], 1e-3 * std::abs(r[first + k])) << i;
        };
        const auto f = [](double x) { return static_cast<float>(x); };
        expect_roots(quadratic_roots<float>(f(-r[0] - r[1]), f(r[0] * r[1])), 0);
        expect_roots(quadratic_roots<float>(f(-r[2] - r[3]), f(r[2] * r[3])), 2);
        expect_roots(cubic_roots<float>(f(-r[1] - r[2] - r[3]), f(r[1] * r[2] + r[1] * r[3] + r[2] * r[3]),
                                        f(-r[1] * r[2] * r[3])),
                     1);
        const double s = r[0] + r[1];
        const double p = r[0] * r[1];
        const double t = r[2] + r[3];
        const double q = r[2] * r[3];
        expect_roots(quartic_roots<float>(f(-s - t), f(p + q + s * t), f(-p * t - q * s), f(p * q)), 0);
    }
}

TEST(Transcendental, AnglesAndThirdsOfThem) {
    for (int i = 0; i <= 2000; ++i) {
        const float x = static_cast<float>(i - 1000) / 1000;
        EXPECT_NEAR(third_angle_cosine(x), std::cos(std::acos(static_cast<double>(x)) / 3), 6e-8) << x;
        for (const float y : {-2.0f, -1.0f, -0.25f, -1e-20f, 1e-20f, 0.3f, 1.0f, 7.0f})
            EXPECT_NEAR(angle(y, x),
                        std::atan2(static_cast<double>(y), static_cast<double>(x)) / 6.283185307179586, 4e-8)
                << x << " " << y;
    }
    EXPECT_EQ(angle(0, 0), 0.0f);
    EXPECT_EQ(angle(0, -1), 0.5f);
    EXPECT_TRUE(std::isnan(angle(std::numeric_limits<float>::quiet_NaN(), 1)));
}

}  // namespace
}  // namespace ropsim
