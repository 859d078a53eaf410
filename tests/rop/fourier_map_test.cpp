// Fourier opacity maps as transparency, against a reimplementation in double precision, the closed forms of
// their ringing, and the published byte counts.
#include "tests/rop/visibility_maps.h"
#include "tests/rop/worst_case_bytes.h"

#include <numbers>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using std::numbers::pi;
using test::absorbance;
using test::Layers;
using test::MapLayer;
using test::Random;
using test::TestFrame;

struct Series {
    int coefficients = 7;
    bool frame = false;
    bool clamp = true;
    double guard = 0;
};

double share(const Series& series, const Layers& layers, double z) {
    const double d = series.frame ? z : test::share_of(layers, z);
    return series.guard + (1 - 2 * series.guard) * d;
}

// Jansen and Bavoil's series of a sum of point masses, integrated from 0 to d, written as the sum over masses
// of what each contributes: A (d + sum of (sin 2 pi k (d - e) + sin 2 pi k e) / (pi k)).
double visibility(const Series& series, const Layers& layers, double z) {
    const double d = share(series, layers, z);
    double sum = 0;
    for (const MapLayer& l : layers) {
        const double e = share(series, layers, l.z);
        double part = d;
        for (int k = 1; k <= series.coefficients / 2; ++k)
            part += (std::sin(2 * pi * k * (d - e)) + std::sin(2 * pi * k * e)) / (pi * k);
        sum += absorbance(l.a) * part;
    }
    return std::exp(-(series.clamp ? std::max(sum, 0.0) : sum));
}

struct MapCase {
    const char* parameters;
    Series series;
    bool normalised = false;
};
constexpr std::array kCases = {
    MapCase{"", {}},
    MapCase{"coefficients=15", {15}},
    MapCase{"coefficients=1,bounds=frame", {1, true}},
    MapCase{"coefficients=5,bounds=frame,composite=normalised", {5, true}, true},
    MapCase{"coefficients=31,guard=0.125,composite=normalised", {31, false, true, 0.125}, true},
};

TEST(FourierMap, EqualsItsDefinition) {
    for (const int samples : {1, 4})
        for (const MapCase& setup : kCases)
            for (const char* memory : {"fixed", "variable"}) {
                auto scene = test::map_scene(31, samples);
                if (memory == std::string("variable") && samples > 1) {
                    scene.slopes.clear();
                    for (Fragment& f : scene.fragments)
                        f.z = std::bit_cast<float>(std::bit_cast<std::uint32_t>(f.z) & ~15u);
                }
                const auto expected = test::composited_by(
                    scene.header, scene.fragments, scene.slopes,
                    [&](const Layers& layers, double z) { return visibility(setup.series, layers, z); },
                    setup.normalised);
                const auto image = test::drawn_image(
                    "fourier_map:format=float32,memory=" + std::string(memory) + "," + setup.parameters,
                    scene);
                EXPECT_LT(test::worst_difference(image, expected), 5e-6)
                    << setup.parameters << " " << memory << " samples " << samples;
            }
}

TEST(FourierMap, TellsVisibilityAsItComposites) {
    auto scene = test::map_scene(32);
    for (Fragment& f : scene.fragments) f.a *= 0.1f;
    const auto layers = test::layers_of(scene.header, scene.fragments, {}, 0, 0, 0);
    std::vector<float> depths;
    for (int i = 0; i <= 50; ++i) depths.push_back(static_cast<float>(i) / 50);
    for (const char* memory : {"fixed", "variable"})
        for (MapCase setup : kCases)
            for (const bool clamp : {true, false}) {
                setup.series.clamp = clamp;
                TestFrame frame("fourier_map:format=float32,memory=" + std::string(memory) +
                                    (clamp ? "," : ",clamp=off,") + setup.parameters,
                                scene.header);
                frame.draw(scene.fragments);
                const auto values = test::visibility_at(frame, depths);
                for (std::size_t i = 0; i < depths.size(); ++i)
                    ASSERT_NEAR(values[i], visibility(setup.series, layers, depths[i]), 2e-5)
                        << setup.parameters << " " << memory << " at " << depths[i];
            }
}

// The series converges to the absorbance of the fragments in front: the mean square of what it leaves out is
// that of the terms left out, known for one mass A at e = 1/2: sum over k > p of (A / (pi k))^2 / 2, its
// constant part 0.
TEST(FourierMap, MoreCoefficientsConvergeToTheAbsorbance) {
    constexpr float kAlpha = 0.75f;
    const double a = absorbance(kAlpha);
    constexpr int kPlaces = 4000;
    std::vector<float> depths;
    for (int i = 0; i < kPlaces; ++i) depths.push_back((static_cast<float>(i) + 0.5f) / kPlaces);
    double before = 1e9;
    for (const int coefficients : {1, 3, 7, 15, 31}) {
        TestFrame frame(
            "fourier_map:format=float32,bounds=frame,clamp=off,coefficients=" + std::to_string(coefficients),
            test::header_of(1, 1));
        frame.draw_one(test::fragment_at(0, 0, 0.5f, kAlpha, {1, 1, 1}));
        const auto values = test::visibility_at(frame, depths);
        double square = 0;
        for (int i = 0; i < kPlaces; ++i) {
            const double exact = depths[static_cast<std::size_t>(i)] > 0.5f ? a : 0;
            square += std::pow(-std::log(values[static_cast<std::size_t>(i)]) - exact, 2) / kPlaces;
        }
        double left_out = pi * pi / 6;
        for (int k = 1; k <= coefficients / 2; ++k) left_out -= 1.0 / (k * k);
        left_out *= a * a / (2 * pi * pi);
        EXPECT_NEAR(square, left_out, 1e-3 * left_out + 1e-6) << coefficients;
        EXPECT_LT(square, 0.6 * before);
        before = square;
    }
}

// Ringing on one thin layer in the middle, closed form: with p pairs absorbance is least at 1 / (2 p + 1) in
// front of it, by x - sum of sin(2 pi k / (2 p + 1)) / (pi k) times the layer's, x the depth there. A layer
// of alpha 0.9 makes what is in front 24% too bright, an opaque one (absorbance 11.5) 2.9 times; more pairs
// do not help (Gibbs). The layer dims itself by half of its absorbance.
TEST(FourierMap, RingingOfAThinLayer) {
    for (const int coefficients : {7, 15, 31}) {
        const int p = coefficients / 2;
        const double x = 0.5 - 1.0 / (2 * p + 1);
        double least = x;
        for (int k = 1; k <= p; ++k) least -= std::sin(2 * pi * k / (2 * p + 1)) / (pi * k);
        EXPECT_NEAR(least, -0.09, 0.004);
        for (const float alpha : {0.5f, 0.9f, 1.0f}) {
            const double a = absorbance(alpha);
            for (const bool clamp : {false, true}) {
                TestFrame frame("fourier_map:format=float32,bounds=frame,coefficients=" +
                                    std::to_string(coefficients) + (clamp ? "" : ",clamp=off"),
                                test::header_of(1, 1));
                frame.draw_one(test::fragment_at(0, 0, 0.5f, alpha, {1, 1, 1}));
                const auto v = test::visibility_at(frame, std::array{static_cast<float>(x), 0.5f, 1.0f});
                EXPECT_NEAR(v[0], clamp ? 1.0 : std::exp(-least * a), 2e-5);
                EXPECT_NEAR(v[1], std::exp(-a / 2), 2e-5);
                EXPECT_NEAR(v[2], std::exp(-a), 2e-5);
            }
        }
    }
    TestFrame thin("fourier_map:format=float32,bounds=frame,clamp=off", test::header_of(1, 1));
    thin.draw_one(test::fragment_at(0, 0, 0.5f, 0.9f, {1, 1, 1}));
    EXPECT_NEAR(test::visibility_at(thin, std::array{0.5f - 1.0f / 7})[0], 1.2386, 1e-4);
}

// Two layers at the ends of their bounds: the nearest is seen whole, but the furthest, at the end of the
// period, under all absorbance, its own included. Scaled to the total alpha, equal colours come out exact.
TEST(FourierMap, TheFurthestFragmentDimsItself) {
    const std::vector<std::array<float, 2>> pair = {{0.25f, 0.5f}, {0.75f, 0.5f}};
    for (const char* memory : {"fixed", "variable"}) {
        const std::string technique = "fourier_map:format=float32,memory=" + std::string(memory);
        EXPECT_NEAR(test::white_image(technique, pair), 0.5 + 0.5 * 0.25, 1e-5) << "0.75 is exact";
        EXPECT_NEAR(test::white_image(technique + ",composite=normalised", pair), 0.75, 1e-5);
        // Without extent all are at the start: nothing dims anything.
        const std::vector<std::array<float, 2>> coplanar = {{0.5f, 0.5f}, {0.5f, 0.5f}};
        EXPECT_EQ(test::white_image(technique, coplanar), 1.0f);
        EXPECT_EQ(test::white_image(technique, std::span(coplanar).first(1)), 0.5f);
        TestFrame empty(technique, test::header_of(1, 1));
        EXPECT_EQ(test::visibility_at(empty, std::array{0.0f, 0.5f, 1.0f}), (std::vector<float>{1, 1, 1}));
    }
}

// A series of the paper's size between fixed bounds, two passes, and the one of table 1 of Salvi et al.,
// whose row of 144 bytes read leaves out the bounds that the passes for map and colour read.
TEST(FourierMap, Bytes) {
    EXPECT_EQ(test::storage_bits("fourier_map:bounds=frame"), 192);
    const auto paper = test::worst_case_bytes("fourier_map:bounds=frame");
    EXPECT_EQ(paper.read, 40u);
    EXPECT_EQ(paper.write, 24u);
    EXPECT_EQ(TestFrame::make("fourier_map:bounds=frame", test::header_of(1, 1))->declaration().passes.size(),
              2u);
    const std::string table1 = "fourier_map:coefficients=15,coefficients_format=float32";
    EXPECT_EQ(test::storage_bits(table1), 640);
    EXPECT_EQ(test::storage_bits(table1, 4), 4 * 640);
    const auto worst = test::worst_case_bytes(table1);
    EXPECT_EQ(worst.read, 144u + 2 * 8);
    EXPECT_EQ(worst.write, 80u);
    EXPECT_EQ(TestFrame::make(table1, test::header_of(1, 1))->declaration().passes.size(), 3u);
}

// Coefficients in two orders differ by at most 2 (n - 1) u times the sum of magnitudes, 2 A each; the
// look-up's factors sum to at most d / 2 + (1 + 2) / (2 pi k) over k; e^-x of x >= 0 moves no more than x.
TEST(FourierMap, AnyOrderUpToRounding) {
    auto scene = test::map_scene(33);
    const auto first = test::drawn_image("fourier_map:format=float32", scene);
    struct Pixel {
        int count = 0;
        double color = 0, absorbed = 0;
    };
    std::map<int, Pixel> pixels;
    for (const Fragment& f : scene.fragments) {
        Pixel& p = pixels[f.y * scene.header.width + f.x];
        ++p.count;
        p.color += std::max({f.r, f.g, f.b});
        p.absorbed += 2 * absorbance(f.a);
    }
    const double factors = 0.5 + (1 + 0.5 + 1.0 / 3) * 3 / (2 * pi);
    Random random(34);
    for (int round = 0; round < 5; ++round) {
        random.shuffle(scene.fragments);
        const auto image = test::drawn_image("fourier_map:format=float32", scene);
        for (std::size_t i = 0; i < image.size(); ++i) {
            const Pixel& p = pixels[static_cast<int>(i / 3)];
            // The look-up itself rounds its seven terms, twice each and in the sum.
            const double visible = (2.0 * p.count + 2 * 6) * p.absorbed * factors;
            const double bound = 0x1p-24 * (visible * p.color + 2 * p.count * p.color + 4 * p.count);
            ASSERT_NEAR(image[i], first[i], bound);
        }
    }
}

// Binary16 sums of thousands of opaque fragments, 23 each, stop at its largest number: nothing is lost to
// infinity less infinity.
TEST(FourierMap, SumsThatAFormatCannotHold) {
    std::vector<Fragment> fragments;
    Random random(35);
    for (int i = 0; i < 6000; ++i)
        fragments.push_back(test::fragment_at(0, 0, random.real(0, 1), 1, {60000, 1, 0}));
    for (const char* parameters : {"", "clamp=off", "bounds=frame,clamp=off,composite=normalised"}) {
        TestFrame frame(std::string("fourier_map:") + parameters, test::header_of(1, 1));
        frame.draw(fragments);
        EXPECT_EQ(test::stored_word(frame, "coefficients", 0), 65504.0f);
        for (const float channel : frame.color()) {
            EXPECT_TRUE(std::isfinite(channel)) << parameters;
            EXPECT_GE(channel, 0.0f);
        }
    }
}

TEST(FourierMap, RefusesAnEvenNumberOfCoefficients) {
    EXPECT_THROW(TestFrame::make("fourier_map:coefficients=8", test::header_of(1, 1)), UserError);
    EXPECT_NO_THROW(TestFrame::make("fourier_map:coefficients=9", test::header_of(1, 1)));
}

}  // namespace
}  // namespace ropsim
