// Hybrid transparency: the k nearest fragments, and a tail by its closed form; what its 8 bytes hold, and
// what the published port makes of them.
#include "rop/nodes/weighted_tail.h"
#include "tests/rop/random_fragments.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

// The formula in double: the nearest `layers` composited, then sum(a c) / sum(a) * (1 - (1 - mean a)^n).
std::array<double, 3> by_definition(std::span<const Fragment> fragments, int x, int y, std::size_t layers,
                                    std::array<double, 3> background, bool factor) {
    const auto own = test::nearest_first(fragments, x, y);
    std::array<double, 3> color{};
    std::array<double, 3> tail{};
    double core = 1;
    double alpha = 0;
    double count = 0;
    for (std::size_t i = 0; i < own.size(); ++i) {
        const std::array<double, 3> c = {own[i].r, own[i].g, own[i].b};
        if (i < layers) {
            for (std::size_t k = 0; k < 3; ++k) color[k] += core * c[k];
            core *= 1.0 - static_cast<double>(own[i].a);
        } else {
            for (std::size_t k = 0; k < 3; ++k) tail[k] += c[k];
            alpha += own[i].a;
            count += 1;
        }
    }
    const double total = count > 0 ? 1 - std::pow(1 - alpha / count, count) : 0;
    const double scale = alpha > 0 ? (factor ? total : 1) / alpha : 1;
    for (std::size_t k = 0; k < 3; ++k) color[k] += core * (scale * tail[k] + (1 - total) * background[k]);
    return color;
}

TEST(Hybrid, EqualsItsDefinition) {
    Random random(81);
    const TraceHeader header = test::opaque_header(9, 6, 1, random);
    const auto fragments = test::random_fragments(header, {.count = 1500}, random);
    for (const bool factor : {true, false}) {
        for (const int layers : {1, 4, 8}) {
            TestFrame frame(
                fmt::format("hybrid:layers={},format=float32,tail_factor={}", layers, factor ? "on" : "off"),
                header);
            frame.draw(fragments);
            const auto image = frame.image();
            for (int pixel = 0; pixel < header.width * header.height; ++pixel) {
                const int x = pixel % header.width;
                const int y = pixel / header.width;
                const auto expected = by_definition(fragments, x, y, static_cast<std::size_t>(layers),
                                                    test::background_of(header, x, y), factor);
                for (std::size_t c = 0; c < 3; ++c)
                    ASSERT_NEAR(image[static_cast<std::size_t>(3 * pixel) + c], expected[c], 1e-5);
            }
        }
    }
}

// One fragment in the tail is composited as itself: exact with one layer more than the list has.
TEST(Hybrid, ExactWithOneFragmentInTheTail) {
    Random random(82);
    const TraceHeader header = test::opaque_header(9, 6, 1, random);
    auto fragments =
        test::random_fragments(header, {.count = 450, .distinct_depths = true, .most_in_a_pixel = 9}, random);
    const auto expect_exact = [&] {
        TestFrame frame("hybrid:layers=8,format=float32", header);
        frame.draw(fragments);
        EXPECT_LT(test::worst_error(frame, fragments), 1e-5);
        EXPECT_GT(frame.log().path_count(1) + frame.log().path_count(2), 20u) << "into the tail";
    };
    expect_exact();
    std::ranges::sort(fragments, {}, &Fragment::z);
    expect_exact();
    std::ranges::reverse(fragments);
    expect_exact();
}

// The packed tail adds whole numbers: order of arrival makes no difference at all, and layers in the tail are
// stored like those in the list.
TEST(Hybrid, PackedTailDoesNotDependOnOrder) {
    Random random(83);
    const TraceHeader header = test::opaque_header(9, 6, 1, random);
    auto fragments = test::random_fragments(header, {.count = 1500, .distinct_depths = true}, random);
    std::vector<std::vector<float>> images;
    for (int order = 0; order < 3; ++order) {
        TestFrame frame("hybrid:layers=3", header);
        frame.draw(fragments);
        images.push_back(frame.image());
        if (order == 0) std::ranges::sort(fragments, {}, &Fragment::z);
        if (order == 1) std::ranges::reverse(fragments);
    }
    EXPECT_EQ(images[0], images[1]);
    EXPECT_EQ(images[0], images[2]);
}

// Three fragments a pixel, two layers, colours and alphas uniform in [0, 1]. The port's first resolve adds
// the tail's mean colour unscaled: its error is T c (1 - a), T the transmittance of the two in front, so its
// mean square is (1/9) (1/3) (1/3): 255 / 9 = 28.33 of 255. With the factor only 8 bits' rounding is left.
TEST(Hybrid, MissingFactorOfThePublishedResolve) {
    constexpr int kSide = 128;
    const TraceHeader header = test::header_of(kSide, kSide, 1, {0, 0, 0});
    Random random(84);
    std::vector<Fragment> fragments;
    for (int i = 0; i < 3 * kSide * kSide; ++i)
        fragments.push_back(test::fragment_at(
            i / 3 % kSide, i / 3 / kSide, random.real(0, 1), random.real(0, 1),
            {random.real(0, 1), random.real(0, 1), random.real(0, 1)}, static_cast<std::uint32_t>(i % 3)));
    const auto squares = [&](const std::string& factor) {
        TestFrame frame("hybrid:layers=2,tail_factor=" + factor, header, 0, 1, false);
        frame.draw(fragments);
        const auto image = frame.image();
        std::vector<double> pixels;
        for (int i = 0; i < kSide * kSide; ++i) {
            const auto exact =
                test::composited(std::span(fragments).subspan(static_cast<std::size_t>(3 * i), 3), i % kSide,
                                 i / kSide, {0, 0, 0});
            double sum = 0;
            for (std::size_t c = 0; c < 3; ++c)
                sum += std::pow(image[static_cast<std::size_t>(3 * i) + c] - exact[c], 2) / 3;
            pixels.push_back(sum);
        }
        return pixels;
    };
    const auto mean_of = [](const std::vector<double>& values) {
        return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
    };
    const auto off = squares("off");
    const double mean = mean_of(off);
    double variance = 0;
    for (const double v : off) variance += (v - mean) * (v - mean) / static_cast<double>(off.size());
    EXPECT_NEAR(mean, 1.0 / 81, 4 * std::sqrt(variance) / kSide);
    EXPECT_LT(255 * std::sqrt(mean_of(squares("on"))), 0.5);
}

// Six white opaque fragments behind a list of one: the colour sum is 5, more than 10 bits hold in steps of
// 1/255. Saturated it is 1023/255, wrapped 251/255: the tail is white by 4/5, or by 1/5.
TEST(Hybrid, ColourSumsAboveTheirRange) {
    const auto color = [](const std::string& format, float white) {
        TestFrame frame("hybrid:layers=1,image_format=float32,tail_format=" + format,
                        test::header_of(1, 1, 1, {0, 0, 0}));
        frame.draw_one(test::fragment_at(0, 0, 0.1f, 0.0f, {0, 0, 0}));
        for (std::uint32_t i = 0; i < 5; ++i)
            frame.draw_one(test::fragment_at(0, 0, 0.5f, 1.0f, {white, white, white}, i));
        return frame.color()[0];
    };
    EXPECT_FLOAT_EQ(color("float32", 1), 1.0f);
    EXPECT_FLOAT_EQ(color("packed", 1), 1023.0f / 255 / 5);
    EXPECT_FLOAT_EQ(color("packed_wrapping", 1), 251.0f / 255 / 5);
    // Within the range all agree.
    for (const char* format : {"float32", "packed", "packed_wrapping"})
        EXPECT_NEAR(color(format, 0.8f), 0.8f, 1e-6) << format;
}

// 70,000 fragments: counts of 16 bits stop, or start again; alphas below half a step add nothing to the sum.
TEST(Hybrid, CountsAndAlphasAboveTheirRange) {
    const auto image = [](const std::string& format, float alpha) {
        TestFrame frame("hybrid:layers=1,image_format=float32,tail_format=" + format,
                        test::header_of(1, 1, 1, {0, 0, 1}), 0, 1, false);
        std::vector<Fragment> many(70000, test::fragment_at(0, 0, 0.5f, alpha, {1, 0, 0}));
        many[0].z = 0.1f;
        frame.draw(many);
        return frame.color();
    };
    for (const char* format : {"packed", "packed_wrapping", "float16", "float32"}) {
        for (const float alpha : {0.0f, 0.001f, 0.5f, 1.0f}) {
            const auto c = image(format, alpha);
            for (const float v : c) {
                ASSERT_TRUE(std::isfinite(v)) << format << " " << alpha;
                ASSERT_GE(v, 0.0f);
                ASSERT_LE(v, 1.0f + 1e-6f);
            }
        }
    }
    // 8 bits lose alphas below 1/510 altogether: the background is as bright as without any of the 70,000.
    EXPECT_EQ(image("packed", 0.001f)[2], 1.0f);
    EXPECT_LT(image("packed", 1.0f)[2], 1e-3f);
}

// 1 - (1 - mean)^n against long double: to a few rounding errors, from the thinnest mean to whole ones.
TEST(Hybrid, CombinedAlpha) {
    for (const float n : {0.0f, 1.0f, 2.0f, 5.0f, 100.0f, 65535.0f}) {
        EXPECT_EQ(combined_alpha<PlainDatapath>(0.0f, n), 0.0f);
        EXPECT_EQ(combined_alpha<PlainDatapath>(1.0f, n), n > 0 ? 1.0f : 0.0f);
        for (float mean = 1e-7f; mean < 1; mean *= 1.37f) {
            const long double exact =
                -std::expm1(static_cast<long double>(n) * std::log1p(-static_cast<long double>(mean)));
            // Above the series' range 1 - mean is rounded by up to 2^-25, of a logarithm of at least 1/64.
            const double tolerance = 4e-6 * static_cast<double>(exact);
            ASSERT_NEAR(combined_alpha<PlainDatapath>(mean, n), static_cast<double>(exact), tolerance)
                << mean << " " << n;
        }
    }
}

// Fragments of no alpha add their light wherever they are.
TEST(Hybrid, GlowingTail) {
    TestFrame frame("hybrid:layers=1,format=float32", test::header_of(1, 1, 1, {0, 0, 0.5f}));
    Fragment glow = test::fragment_at(0, 0, 0.5f, 0, {0, 0, 0});
    glow.r = 0.125f;
    frame.draw_one(test::fragment_at(0, 0, 0.1f, 0.5f, {0, 1, 0}));
    frame.draw_one(glow);
    frame.draw_one(glow);
    EXPECT_EQ(frame.color(), (std::array<float, 3>{0.125f, 0.5f, 0.25f}));
}

// In the list vis is the product in front; behind a full one every fragment of the tail has the same weight,
// so that alphas times visibilities add up to the total alpha.
TEST(Hybrid, Visibility) {
    TestFrame frame("hybrid:layers=2,format=float32", test::header_of(1, 1));
    const std::array<float, 5> alpha = {0.5f, 0.25f, 0.4f, 0.7f, 0.1f};
    for (std::uint32_t i = 0; i < 5; ++i)
        frame.draw_one(test::fragment_at(0, 0, 0.1f + 0.1f * static_cast<float>(i), alpha[i], {1, 1, 1}, i));
    const std::array<float, 5> depths = {0.05f, 0.15f, 0.25f, 0.35f, 0.9f};
    std::array<float, 5> values{};
    frame.operation().visibility(frame.store(), 0, 0, depths, values);
    EXPECT_EQ(values[0], 1.0f);
    EXPECT_EQ(values[1], 0.5f);
    EXPECT_EQ(values[2], values[4]);
    EXPECT_EQ(values[3], values[4]);
    EXPECT_NEAR(values[4] * (0.4 + 0.7 + 0.1), 0.375 * (1 - std::pow(0.6, 3)), 1e-6);
}

}  // namespace
}  // namespace ropsim
