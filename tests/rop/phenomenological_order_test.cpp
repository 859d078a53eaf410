// Phenomenological transparency under permutations of its surfaces: sums and products, so the same image up
// to what each format rounds away on the way, which is bounded here target by target. (Displacements that
// leave their format's range are another matter: phenomenological_precision_test.cpp.)
#include "tests/rop/random_fragments.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

constexpr int kSide = 8;
constexpr int kPermutations = 6;
constexpr double kUnit32 = 0x1p-24;  // what rounding to binary32 changes, relative to the result
constexpr double kUnit16 = 0x1p-11;  // and to binary16
constexpr double kCode = 1.0 / 255;

// Surfaces over one small image, `count` in each pixel.
struct Stack {
    TraceHeader header;
    std::vector<Fragment> fragments;
    std::vector<Material> materials;
};
Stack stack_of(int count, float most_alpha, Random& random) {
    Stack s{test::with_materials(test::header_of(kSide, kSide)), {}, {}};
    s.materials =
        test::random_materials(static_cast<std::size_t>(count) * std::size_t{kSide} * kSide, random);
    for (int i = 0; i < count; ++i)
        for (int p = 0; p < kSide * kSide; ++p) {
            // Draws one after the other: compilers differ in the order of a call's arguments.
            const std::array<float, 3> color{random.real(0, 1), random.real(0, 1), random.real(0, 1)};
            const float alpha = random.real(0.01, most_alpha);
            const float z = random.real(0.2, 0.99);
            s.fragments.push_back(test::fragment_at(p % kSide, p / kSide, z, alpha, color));
        }
    return s;
}
void permute(Stack& s, Random& random) {
    std::vector<std::size_t> order(s.fragments.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    random.shuffle(order);
    const Stack before = s;
    for (std::size_t i = 0; i < order.size(); ++i) {
        s.fragments[i] = before.fragments[order[i]];
        s.materials[i] = before.materials[order[i]];
    }
}

struct Drawn {
    std::vector<float> image;
    std::vector<std::array<float, 10>> state;  // RT0, RT1, RT2 of each pixel
};
Drawn drawn(const std::string& parameters, const Stack& s) {
    TestFrame frame("phenomenological:image_format=float32" + parameters, s.header);
    frame.draw(s.fragments, {}, s.materials);
    Drawn result;
    for (int p = 0; p < kSide * kSide; ++p) {
        const auto words = frame.words(p % kSide, p / kSide);
        std::ranges::transform(words.first(10), result.state.emplace_back().begin(),
                               [](std::uint32_t w) { return std::bit_cast<float>(w); });
    }
    result.image = frame.image();
    return result;
}

// What rounding eight bits of beta can have changed by the end of one order: half a code at each layer,
// dimmed by the layers after it.
double beta_rounding(const Stack& s, int pixel, std::size_t channel) {
    double bound = 0;
    for (std::size_t i = 0; i < s.fragments.size(); ++i) {
        const Fragment& f = s.fragments[i];
        if (f.x != pixel % kSide || f.y != pixel / kSide) continue;
        bound = bound * (1 - f.a * (1 - s.materials[i].transmission[channel])) + 0.5 * kCode;
    }
    return bound;
}

// Differences of two orders' images, in 8-bit steps.
struct Differences {
    double worst = 0;
    double root_mean_square = 0;
};
Differences differences(const std::string& parameters, Stack s, Random& random) {
    const Drawn first = drawn(parameters, s);
    Differences result;
    for (int permutation = 0; permutation < kPermutations; ++permutation) {
        permute(s, random);
        const Drawn other = drawn(parameters, s);
        for (std::size_t i = 0; i < first.image.size(); ++i) {
            const double d = 255 * std::abs(static_cast<double>(first.image[i]) - other.image[i]);
            result.worst = std::max(result.worst, d);
            result.root_mean_square += d * d;
        }
    }
    const auto values = static_cast<double>(first.image.size()) * kPermutations;
    result.root_mean_square = std::sqrt(result.root_mean_square / values);
    return result;
}

// In float32 each of n additions or multiplications rounds by 2^-24 of its result at most; of addends of one
// sign no partial sum is larger than the whole.
TEST(PhenomenologicalOrder, Float32KeepsItsBounds) {
    Random random(611);
    for (const int n : {2, 12, 64}) {
        Stack s = stack_of(n, 0.6f, random);
        const Drawn first = drawn(",format=float32", s);
        for (int permutation = 0; permutation < kPermutations; ++permutation) {
            permute(s, random);
            const Drawn other = drawn(",format=float32", s);
            for (std::size_t p = 0; p < first.state.size(); ++p) {
                const auto& a = first.state[p];
                const auto& b = other.state[p];
                for (std::size_t w = 0; w < 8; ++w)
                    ASSERT_NEAR(a[w], b[w], 2 * n * kUnit32 * a[w] * 1.001) << n << " word " << w;
                // Displacements cancel: bounded by their magnitudes, of less than 8 pixels each here.
                for (std::size_t w = 8; w < 10; ++w) ASSERT_NEAR(a[w], b[w], 2 * n * kUnit32 * n * 8 / 63.0);
            }
        }
    }
}

// The same of the image, where displacement and blur do not choose pixels: of n layers, sums differ by
// 2 (n - 1) roundings, their quotient by twice that and its own, beta and 1 - beta by 2 n. That is 3e-5 for
// 64 layers at worst; what comes out stays within 1e-6.
TEST(PhenomenologicalOrder, Float32ImagesAgreeToAMillionth) {
    Random random(612);
    for (const int n : {2, 12, 64}) {
        Stack s = stack_of(n, 0.6f, random);
        std::ranges::fill(s.materials, Material{});
        const Differences d = differences(",format=float32", s, random);
        EXPECT_LE(d.worst / 255, (8 * n + 24) * kUnit32);
        EXPECT_LE(d.worst / 255, 1e-6);
    }
}

// As printed. Where a target holds whole codes of a fixed point, an addend becomes codes by itself: D^2 and
// delta are the same in all orders, to the bit. A of binary16 differs by n roundings of its sum, beta by half
// a code at each layer, dimmed by those that follow.
TEST(PhenomenologicalOrder, PaperFormatsKeepTheirBounds) {
    Random random(613);
    for (const int n : {2, 12, 64})
        for (const float most : {0.6f, 0.05f}) {
            Stack s = stack_of(n, most, random);
            const Stack before = s;
            const Drawn first = drawn("", s);
            double most_codes = 0;
            for (int permutation = 0; permutation < kPermutations; ++permutation) {
                permute(s, random);
                const Drawn other = drawn("", s);
                for (int p = 0; p < kSide * kSide; ++p) {
                    const auto& a = first.state[static_cast<std::size_t>(p)];
                    const auto& b = other.state[static_cast<std::size_t>(p)];
                    for (std::size_t w = 0; w < 4; ++w) ASSERT_NEAR(a[w], b[w], 2 * n * kUnit16 * a[w] * 1.1);
                    for (std::size_t c = 0; c < 3; ++c) {
                        const double bound = beta_rounding(before, p, c) + beta_rounding(s, p, c);
                        ASSERT_NEAR(a[4 + c], b[4 + c], bound + 1e-5);
                        most_codes = std::max(most_codes, std::abs(a[4 + c] - b[4 + c]) / kCode);
                    }
                    for (std::size_t w = 7; w < 10; ++w) ASSERT_EQ(a[w], b[w]) << w;
                }
            }
            EXPECT_GT(most_codes, 0.5) << "as if nothing were rounded";
            EXPECT_LT(most_codes, 8);
        }
}

// What is seen of it, over 12 layers that transmit in colour: 1.3 8-bit steps at most of beta's rounding, 80
// once self-modulation divides the last codes of beta by one another, and half a step with sixteen bits of
// beta.
TEST(PhenomenologicalOrder, SelfModulationAmplifiesBetasRounding) {
    Random random(614);
    const Stack s = stack_of(12, 0.6f, random);
    const std::string still = ",refraction=off,diffusion=off";
    const Differences off = differences(still + ",self_modulation=off", s, random);
    const Differences on = differences(still, s, random);
    const Differences wide = differences(still + ",beta_format=unorm16", s, random);
    EXPECT_LT(off.worst, 1.5);
    EXPECT_LT(off.root_mean_square, 0.3);
    EXPECT_NEAR(on.worst, 80, 10);
    EXPECT_NEAR(on.root_mean_square, 10, 2);
    EXPECT_LT(wide.worst, 0.6);
}

// Two white panes, red through one at .74 and the other at .0098: 255 * .0098 is 2 codes and .74 of that 1;
// the other way round it is 189 codes and 2. Green and blue have 1 either way. So white is white, or a
// quarter darker in green and blue.
TEST(PhenomenologicalOrder, TwoPanesOfTwoHues) {
    Stack s{test::with_materials(test::header_of(kSide, kSide, 1, {0, 0, 0})), {}, std::vector<Material>(2)};
    for (std::size_t c = 0; c < 3; ++c) {
        s.materials[0].transmission[c] = c == 0 ? 0.0098f : 0.004f;
        s.materials[1].transmission[c] = 0.74f;
    }
    s.fragments.assign(2, test::fragment_at(0, 0, 0.5f, 1, {1, 1, 1}));
    const auto shown = [&](const std::string& parameters) { return drawn(parameters, s).image; };
    const auto first = shown("");
    const auto first_plain = shown(",self_modulation=off");
    const auto first_wide = shown(",beta_format=float32");
    std::swap(s.materials[0], s.materials[1]);
    const auto second = shown("");
    const auto second_wide = shown(",beta_format=float32");
    for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(first[c], first_plain[c], 1e-3);
        EXPECT_NEAR(second[c], first[c] * (c == 0 ? 1 : 0.75), 0.01);
        EXPECT_NEAR(second_wide[c], first_wide[c], 1e-3);
    }
}

}  // namespace
}  // namespace ropsim
