// The share in front of a depth from moments (rop/visibility/) against linear algebra in double precision and
// against what any distribution with those moments fulfils.
#include "rop/visibility/power_moments.h"
#include "rop/visibility/published_moments.h"
#include "rop/visibility/trigonometric_moments.h"
#include "tests/rop/double_moments.h"
#include "tests/rop/random_fragments.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Atom;
using test::Random;

constexpr double kDepthToTurns = 0.475;  // of z + 1: the wrapping zone is a twentieth of the circle

MomentBias unbiased(float overestimation) {
    MomentBias bias;
    bias.overestimation = overestimation;
    return bias;
}
// The paper's for float32.
MomentBias published_bias(int order, bool circle, float overestimation) {
    MomentBias bias = unbiased(overestimation);
    const auto at = static_cast<std::size_t>(order - 2);
    bias.weight = circle ? std::array<float, 3>{4e-7f, 8e-6f, 1.5e-5f}[at]
                         : std::array<float, 3>{5e-7f, 5e-6f, 5e-5f}[at];
    const std::array<std::array<float, 4>, 3> even = {
        {{0.375f, 0.375f}, {0.48f, 0.451f, 0.45f}, {0.75f, 0.676667f, 0.63f, 0.600303f}}};
    for (std::size_t k = 0; k < 4; ++k) bias.moments[2 * k + 1] = even[at][k];
    return bias;
}

std::vector<Atom> random_atoms(int count, Random& random) {
    std::vector<Atom> atoms;
    double sum = 0;
    for (int i = 0; i < count; ++i) {
        atoms.push_back({random.real(-1, 1), random.real(0.1, 1)});
        sum += atoms.back().weight;
    }
    for (Atom& atom : atoms) atom.weight /= sum;
    std::ranges::sort(atoms, {}, &Atom::place);
    return atoms;
}

template <int kOrder>
float power_share(const std::vector<Atom>& atoms, double z0, const MomentBias& bias) {
    const auto b = test::power_moments(atoms, kOrder);
    PowerMoments<kOrder, float> moments;
    for (std::size_t k = 0; k < moments.size(); ++k) moments[k] = static_cast<float>(b[k + 1]);
    return share_in_front<kOrder, float>(bias, moments, static_cast<float>(z0));
}

std::vector<Atom> on_circle(std::vector<Atom> atoms) {
    for (Atom& atom : atoms) atom.place = (atom.place + 1) * kDepthToTurns;
    return atoms;
}

template <int kOrder>
float circle_share(const std::vector<Atom>& atoms, double z0, const MomentBias& bias) {
    const auto b = test::circle_moments(on_circle(atoms), kOrder);
    TrigonometricMoments<kOrder, float> moments;
    for (std::size_t k = 0; k < moments.size(); ++k)
        moments[k] = {static_cast<float>(b[k + 1].real()), static_cast<float>(b[k + 1].imag())};
    return share_in_front<kOrder, float>(bias, moments, static_cast<float>(z0));
}

double in_front(const std::vector<Atom>& atoms, double z0, bool with_own) {
    double sum = 0;
    for (const Atom& atom : atoms)
        if (atom.place < z0 || (with_own && atom.place == z0)) sum += atom.weight;
    return sum;
}

// What counts as in front in the wrapping zone, by the paper's parameter of the circle: sin + cos there.
double ramp(double turns) {
    const auto parameter = [](double t) {
        return std::sin(6.283185307179586 * t) + std::cos(6.283185307179586 * t);
    };
    return (parameter(turns) - parameter(0.95)) / (1 - parameter(0.95));
}

template <int kOrder>
void expect_linear_algebra() {
    Random random(21);
    double worst_power = 0;
    double worst_circle = 0;
    int compared = 0;
    for (int i = 0; i < 60; ++i) {
        const auto atoms = random_atoms(random.integer(12, 20), random);
        const double z0 = random.real(-1, 1);
        const float over = random.real(0, 1);
        const auto support = test::power_support(test::power_moments(atoms, kOrder), kOrder, z0);
        const auto around = test::circle_support(test::circle_moments(on_circle(atoms), kOrder), kOrder,
                                                 (z0 + 1) * kDepthToTurns);
        if (support.empty() || around.empty()) continue;
        ++compared;
        double exact = over * support[0].weight;
        for (const Atom& point : support) exact += point.place < z0 ? point.weight : 0;
        worst_power = std::max(worst_power, std::abs(power_share<kOrder>(atoms, z0, unbiased(over)) - exact));
        exact = over * around[0].weight;
        for (std::size_t k = 1; k < around.size(); ++k) {
            const double factor = around[k].place < around[0].place ? 1.0
                                  : around[k].place > 0.95          ? ramp(around[k].place)
                                                                    : 0.0;
            exact += factor * around[k].weight;
        }
        worst_circle =
            std::max(worst_circle, std::abs(circle_share<kOrder>(atoms, z0, unbiased(over)) - exact));
    }
    EXPECT_GT(compared, 55);
    EXPECT_LT(worst_power, 2e-5) << kOrder;
    EXPECT_LT(worst_circle, 2e-5) << kOrder;
}
TEST(MomentReconstruction, EqualsLinearAlgebraInDouble) {
    expect_linear_algebra<2>();
    expect_linear_algebra<3>();
    expect_linear_algebra<4>();
}

// With the fragment's own point behind and in front, the share bounds that of every distribution with these
// moments; here of the one they come from.
template <int kOrder>
void expect_bounds() {
    Random random(22);
    double worst = 0;
    double sum = 0;
    for (int i = 0; i < 3000; ++i) {
        const auto atoms = random_atoms(random.integer(1, 20), random);
        const bool own = random.integer(0, 1) == 0;
        const double z0 =
            own ? atoms[static_cast<std::size_t>(random.integer(0, static_cast<int>(atoms.size()) - 1))].place
                : static_cast<double>(random.real(-1, 1));
        for (const double excess :
             {power_share<kOrder>(atoms, z0, unbiased(0)) - in_front(atoms, z0, false),
              in_front(atoms, z0, true) - power_share<kOrder>(atoms, z0, unbiased(1))}) {
            worst = std::max(worst, excess);
            sum += std::pow(std::max(excess, 0.0), 2);
        }
    }
    EXPECT_LT(worst, 0.06) << kOrder;
    EXPECT_LT(std::sqrt(sum / 6000), 2e-3) << kOrder;
}
TEST(MomentReconstruction, BoundsTheDistributionItComesFrom) {
    expect_bounds<2>();
    expect_bounds<3>();
    expect_bounds<4>();
}

// As many distinct depths as half the power moments, or as the complex ones: no other distribution has these
// moments, so every step of the transmittance is there. What differs is the bias, without which float32
// moments would not say how many depths there are: without it the largest error is 0.5.
template <int kOrder>
void expect_exact_steps(bool circle, double worst_allowed) {
    Random random(23);
    double worst = 0;
    double sum = 0;
    int count = 0;
    const auto compare = [&](const std::vector<Atom>& atoms, double z, float over, double exact) {
        const MomentBias bias = published_bias(kOrder, circle, over);
        const float got = circle ? circle_share<kOrder>(atoms, z, bias) : power_share<kOrder>(atoms, z, bias);
        worst = std::max(worst, std::abs(got - exact));
        sum += std::pow(got - exact, 2);
        ++count;
    };
    for (int i = 0; i < 1500; ++i) {
        std::vector<Atom> atoms = random_atoms(random.integer(1, kOrder), random);
        const auto n = static_cast<double>(atoms.size());
        for (std::size_t k = 0; k < atoms.size(); ++k)
            atoms[k].place =
                static_cast<float>(-0.9 + 1.8 * (static_cast<double>(k) + random.real(0.15, 0.85)) / n);
        for (std::size_t k = 0; k < atoms.size(); ++k) {
            const double z = atoms[k].place;
            const double middle = 0.5 * (z + (k + 1 < atoms.size() ? atoms[k + 1].place : 1.0));
            compare(atoms, z, 0, in_front(atoms, z, false));
            compare(atoms, z, 1, in_front(atoms, z, true));
            compare(atoms, middle, 0.5f, in_front(atoms, middle, true));
        }
    }
    EXPECT_LT(worst, worst_allowed) << kOrder << (circle ? " circle" : " power");
    EXPECT_LT(std::sqrt(sum / count), 2e-3) << kOrder << (circle ? " circle" : " power");
}
TEST(MomentReconstruction, AsManyDepthsAsTheOrderAreExact) {
    expect_exact_steps<2>(false, 1e-3);
    expect_exact_steps<3>(false, 0.03);
    expect_exact_steps<4>(false, 0.08);
    expect_exact_steps<2>(true, 0.15);
    expect_exact_steps<3>(true, 0.02);
    expect_exact_steps<4>(true, 0.01);
}

// Whatever is stored, even what are the moments of nothing.
template <int kOrder>
void expect_always_a_share() {
    Random random(24);
    const auto any = [&] {
        switch (random.integer(0, 5)) {
            case 0:
                return static_cast<float>(random.integer(-1, 1));
            case 1:
                return random.real(-1e-6, 1e-6);
            case 2:
                return random.real(-4, 4);
            default:
                return random.real(-1, 1);
        }
    };
    for (int i = 0; i < 40000; ++i) {
        PowerMoments<kOrder, float> moments;
        for (float& b : moments) b = any();
        TrigonometricMoments<kOrder, float> circle;
        for (auto& b : circle) b = {any(), any()};
        const float z = random.real(-1, 1);
        for (const float s : {share_in_front<kOrder, float>(unbiased(0.25f), moments, z),
                              share_in_front<kOrder, float>(unbiased(0.25f), circle, z)}) {
            ASSERT_GE(s, 0.0f);
            ASSERT_LE(s, 1.0f + 0x1p-22f);
        }
    }
}
TEST(MomentReconstruction, AnyNumbersGiveAShare) {
    expect_always_a_share<2>();
    expect_always_a_share<3>();
    expect_always_a_share<4>();
}

// The paper's arithmetic and the mended one agree where neither is near a singular matrix.
template <int kOrder>
void expect_published() {
    Random random(25);
    MomentBias bias = unbiased(0.25f);
    double worst = 0;
    for (int i = 0; i < 500; ++i) {
        const auto atoms = random_atoms(random.integer(12, 20), random);
        const auto b = test::power_moments(atoms, kOrder);
        PowerMoments<kOrder, float> moments;
        for (std::size_t k = 0; k < moments.size(); ++k) moments[k] = static_cast<float>(b[k + 1]);
        const float z = random.real(-1, 1);
        const float published = published::transmittance<kOrder, float>(bias, 2.0f, moments, z);
        worst = std::max(
            worst, static_cast<double>(std::abs(
                       published - exponential(-2.0f * share_in_front<kOrder, float>(bias, moments, z)))));
    }
    EXPECT_LT(worst, 1e-4) << kOrder;
}
TEST(MomentReconstruction, PublishedArithmeticAgreesAwayFromSingularMatrices) {
    expect_published<2>();
    expect_published<3>();
    expect_published<4>();
}

}  // namespace
}  // namespace ropsim
