// Rounding of the datapath's key chains against bounds that are stated before it is measured: the product of
// transmittances, the area metric of visibility curves, the quotient of falling factorials, the recurrence of
// moments. u is half an ulp: 2^-24 of float32, 2^-11 of binary16; gamma(n) = n u / (1 - n u) bounds the
// relative error of n roundings one after the other (Higham 2002, section 3.1).
#include "rop/nodes/curve_removal.h"
#include "rop/nodes/insertion_probability.h"
#include "rop/single_pixel.h"
#include "rop/visibility/power_moments.h"
#include "tests/rop/random_fragments.h"

#include <cmath>

#include <gtest/gtest.h>

namespace ropsim {

// A float, what it would be without rounding, and a bound on the difference that is carried along: every
// operation adds its operands' bounds and half an ulp of its result.
struct Tracked {
    float value = 0;
    double exact = 0;
    double bound = 0;

    Tracked() = default;
    explicit Tracked(float v) : value(v), exact(static_cast<double>(v)) {}
    Tracked(float v, double e, double operands)
        : value(v), exact(e), bound(operands + 0x1p-24 * std::abs(static_cast<double>(v)) + 0x1p-149) {}
    double size() const { return std::abs(static_cast<double>(value)); }
};
inline Tracked operator+(const Tracked& a, const Tracked& b) {
    return {a.value + b.value, a.exact + b.exact, a.bound + b.bound};
}
inline Tracked operator-(const Tracked& a, const Tracked& b) {
    return {a.value - b.value, a.exact - b.exact, a.bound + b.bound};
}
inline Tracked operator*(const Tracked& a, const Tracked& b) {
    return {a.value * b.value, a.exact * b.exact,
            a.size() * b.bound + b.size() * a.bound + a.bound * b.bound};
}
inline Tracked operator/(const Tracked& a, const Tracked& b) {
    const double least = b.size() - b.bound;  // of the divisor; below 0 nothing is known
    const double quotient = a.size() / b.size();
    return {a.value / b.value, a.exact / b.exact,
            least > 0 ? (a.bound + quotient * b.bound) / least : std::numeric_limits<double>::infinity()};
}
inline bool operator<(const Tracked& a, const Tracked& b) {
    return a.value < b.value;
}
// A choice that goes either way within the bound may give either operand.
inline Tracked select(bool condition, const Tracked& a, const Tracked& b) {
    return condition ? a : b;
}
inline Tracked chosen(const Tracked& a, const Tracked& b, bool first, bool first_exact) {
    Tracked result = first ? a : b;
    result.exact = first_exact ? a.exact : b.exact;
    result.bound = std::max(a.bound, b.bound);
    return result;
}
inline Tracked maximum(const Tracked& a, const Tracked& b) {
    return chosen(a, b, !(a.value < b.value), !(a.exact < b.exact));
}
inline Tracked minimum(const Tracked& a, const Tracked& b) {
    return chosen(a, b, a.value < b.value, a.exact < b.exact);
}

namespace {

using test::Random;

double gamma(double n, double u) {
    return n * u / (1 - n * u);
}

// Black fragments before white: the colour is the product of transmittances.
PixelScene black_before_white(const std::vector<float>& alphas) {
    PixelScene scene;
    scene.background = glm::vec3(1.0f);
    for (std::size_t i = 0; i < alphas.size(); ++i)
        scene.fragments.push_back({0.5f, 0, 0, 0, alphas[i], 0, 0, static_cast<std::uint32_t>(i), 1, 0});
    return scene;
}
long double product_of(const std::vector<float>& alphas) {
    long double product = 1;
    for (const float a : alphas) product *= 1 - static_cast<long double>(a);
    return product;
}
// Alphas of n layers that leave at least a millionth in all.
std::vector<float> alphas_of(int layers, Random& random) {
    std::vector<float> alphas;
    for (int i = 0; i < layers; ++i) alphas.push_back(random.real(0, std::min(0.9, 14.0 / layers)));
    return alphas;
}

// A layer is a subtraction and a product, 2 n roundings in all; the first product, by 1, is exact.
TEST(ErrorBounds, ProductOfTransmittances) {
    Random random(1);
    TraceHeader header;
    const auto technique = make_single_pixel("alpha_blend:format=float32", header, 0);
    double closest = 0;
    for (const int layers : {1, 2, 10, 100, 1000, 10'000, 100'000}) {
        for (int round = 0; round < (layers > 1000 ? 2 : 50); ++round) {
            const std::vector<float> alphas = alphas_of(layers, random);
            const auto exact = static_cast<double>(product_of(alphas));
            const double error = std::abs(technique->run(black_before_white(alphas))[0] - exact) / exact;
            const double bound = gamma(2.0 * layers - 1, 0x1p-24);
            ASSERT_LE(error, bound) << layers << " layers";
            closest = std::max(closest, error / bound);
        }
    }
    EXPECT_GT(closest, 0.05) << "a bound that nothing comes near says nothing";
    // The worst case: every rounding to the same side. 1 - a rounds by nearly u where a is just above 2^-25.
    const std::vector<float> alphas(10'000, 0x1.04p-25f);
    const auto exact = static_cast<double>(product_of(alphas));
    const double error = std::abs(technique->run(black_before_white(alphas))[0] - exact) / exact;
    EXPECT_LE(error, gamma(2.0 * 10'000 - 1, 0x1p-24));
    EXPECT_GT(error, 0.2 * gamma(2.0 * 10'000 - 1, 0x1p-24));
}

// In binary16 the store rounds as well, by 2^-11 of what is stored or by half of the least number, 2^-25.
TEST(ErrorBounds, ProductOfTransmittancesInBinary16) {
    Random random(2);
    TraceHeader header;
    const auto technique = make_single_pixel("alpha_blend:format=float32,color_format=float16", header, 0);
    for (const int layers : {1, 2, 10, 100, 400}) {
        for (int round = 0; round < 50; ++round) {
            const std::vector<float> alphas = alphas_of(layers, random);
            const auto exact = static_cast<double>(product_of(alphas));
            const double error = std::abs(technique->run(black_before_white(alphas))[0] - exact);
            const double bound = exact * gamma(layers, 0x1p-11 + 2 * 0x1p-24) + layers * 0x1p-25;
            ASSERT_LE(error, bound) << layers << " layers";
        }
    }
}

// Two differences and a product: 3 roundings. So the node that goes has an area within (1 + g) / (1 - g) of
// the least, g = gamma(3).
TEST(ErrorBounds, AreaMetric) {
    Random random(3);
    CurveRules rules;
    const double g = gamma(3, 0x1p-24);
    int not_the_least = 0;
    for (int round = 0; round < 20'000; ++round) {
        Curve<PlainDatapath> curve;
        std::vector<double> areas;
        float z = random.real(0, 0.1);
        float t = 1;
        // Adversarial curves: areas that are equal but for their rounding.
        const bool even = round % 2 == 0;
        for (std::size_t k = 0; k <= 8; ++k) {
            z += even ? 0.1f : random.real(1e-6, 0.1);
            t *= even ? 0.9f : random.real(0.5, 1);
            if (even) t = 1.0f - 0.1f * static_cast<float>(k + 1) + random.real(-1e-7, 1e-7);
            curve.depth[k] = z;
            curve.transmittance[k] = t;
        }
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t k = 1; k <= 8; ++k) {
            areas.push_back((static_cast<double>(curve.transmittance[k - 1]) - curve.transmittance[k]) *
                            (static_cast<double>(curve.depth[k]) - curve.depth[k - 1]));
            least = std::min(least, areas.back());
        }
        const std::uint32_t code = least_error<PlainDatapath>(curve, rules).code;
        ASSERT_EQ(code % 2, 0u);
        const double area = areas[code / 2 - 1];
        ASSERT_LE(area, least * (1 + g) / (1 - g)) << "round " << round;
        not_the_least += area > least ? 1 : 0;
    }
    EXPECT_GT(not_the_least, 0) << "no rounding ever decided: the inputs are too tame";
}

// In double precision: t factors of three roundings each, then one difference and the table's own rounding.
// Held against the same number as another product, (b - t)_m / (b)_m with m = b - s.
TEST(ErrorBounds, FallingFactorial) {
    for (const int bits : {1, 7, 16, 64, 256, 1024}) {
        const InsertionProbability table(bits, CoverageBits::kStratified);
        const int step = bits > 64 ? 13 : 1;
        double closest = 0;
        for (int s = 0; s <= bits; s += step)
            for (int t = 0; t <= bits; t += step) {
                long double hidden = 1;
                for (int j = 0; j < bits - s; ++j)
                    hidden *= static_cast<long double>(bits - t - j) / static_cast<long double>(bits - j);
                if (t > s) hidden = 0;
                const auto exact = static_cast<double>(1 - hidden);
                const double error = std::abs(static_cast<double>(table.at(static_cast<std::uint32_t>(s),
                                                                           static_cast<std::uint32_t>(t))) -
                                              exact);
                const double bound = exact * 0x1p-24 + gamma(3.0 * t + 1, 0x1p-53);
                ASSERT_LE(error, bound) << s << " and " << t << " of " << bits;
                closest = std::max(closest, bound == 0 ? 0 : error / bound);
            }
        if (bits > 1) {
            EXPECT_GT(closest, 0.4) << bits;
        }
    }
}

// Chebyshev's algorithm, which stands for Cholesky's factors of the Hankel matrix: its norms are the squares
// of their diagonal's quotients. The bound is carried along, operation by operation.
template <int kOrder>
void recurrence_stays_in_bounds(double spread, double least_known) {
    Random random(4 + kOrder);
    int known = 0;
    constexpr int kRounds = 3000;
    for (int round = 0; round < kRounds; ++round) {
        // Moments of a few points, rounded to float32: these are the exact inputs.
        std::array<double, std::size_t{2} * kOrder> sums{};
        double all = 0;
        const int points = random.integer(kOrder + 1, 12);
        const double center = random.real(-0.5, 0.5);
        for (int i = 0; i < points; ++i) {
            const double weight = random.real(0.01, 1);
            const double z = center + random.real(-spread, spread);
            all += weight;
            double power = weight;
            for (double& sum : sums) sum += power *= z;
        }
        PowerMoments<kOrder, Tracked> moments;
        for (std::size_t i = 0; i < moments.size(); ++i)
            moments[i] = Tracked(static_cast<float>(sums[i] / all));
        const auto r = detail::recurrence_of<kOrder, Tracked>(moments);
        for (std::size_t k = 1; k <= kOrder; ++k) {
            const Tracked& norm = r.norm[k];
            // Behind a norm that may be noise the operation goes by other rules than exact arithmetic does.
            if (!(norm.bound < 0.25 * norm.size())) break;
            ASSERT_LE(std::abs(static_cast<double>(norm.value) - norm.exact), norm.bound) << "norm " << k;
            known += k == kOrder ? 1 : 0;
        }
    }
    EXPECT_GE(known, least_known * kRounds) << "order " << kOrder << ", spread " << spread;
}
TEST(ErrorBounds, MomentRecurrence) {
    recurrence_stays_in_bounds<2>(0.5, 0.9);
    recurrence_stays_in_bounds<3>(0.5, 0.5);
    recurrence_stays_in_bounds<4>(0.5, 0.05);
    // Close points: little is known, and what is holds.
    recurrence_stays_in_bounds<2>(0.02, 0);
    recurrence_stays_in_bounds<3>(0.02, 0);
}

}  // namespace
}  // namespace ropsim
