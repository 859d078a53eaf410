// Where McGuire and Mara 2017 says two things: which of them holds, each shown by what the other would do.
#include "rop/phenomenological/background_filter.h"
#include "tests/rop/phenomenological_scene.h"

#include <limits>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::material_of;
using test::perspective_screen;
using test::pixel_of;
using test::shader_of;
using test::TestFrame;

// The technique with these keys besides.
std::string with_keys(const std::string& keys = "") {
    return "phenomenological:image_format=float32" + keys;
}

// The filter by itself.
BackgroundFilter filter_of(const std::string& keys, const Screen& screen) {
    TechniqueSpec spec =
        parse_technique(keys.empty() ? "phenomenological" : "phenomenological:" + keys, "--technique");
    return {PhenomenologicalOptions(spec.parameters, screen), screen};
}

// One surface before the whole of a picture.
void cover(TestFrame& frame, float z, float alpha, const Material& material, int layers = 1) {
    std::vector<Fragment> fragments;
    for (int i = 0; i < layers; ++i)
        for (int y = 0; y < frame.header().height; ++y)
            for (int x = 0; x < frame.header().width; ++x)
                fragments.push_back(
                    test::fragment_at(x, y, z, alpha, {0, 0, 0}, static_cast<std::uint32_t>(i)));
    const std::vector<Material> materials(fragments.size(), material);
    frame.draw(fragments, {}, materials);
}

// Equation 2 hides what is behind an opaque surface; a third of it leaves two thirds, (2/3)^n behind n.
TEST(PhenomenologicalReadings, AThirdOfBetaShowsWhatIsBehindOpaqueSurfaces) {
    for (const int layers : {1, 2, 5}) {
        const TraceHeader white = test::with_materials(test::header_of(1, 1, 1, {1, 1, 1}));
        TestFrame product(with_keys(), white);
        TestFrame third("phenomenological:format=float32,beta=third", white);
        cover(product, 0.5f, 1, Material{}, layers);
        cover(third, 0.5f, 1, Material{}, layers);
        EXPECT_EQ(product.color()[0], 0.0f);
        EXPECT_NEAR(third.color()[0], std::pow(2.0 / 3, layers), 1e-6);
    }
}

// Equation 7 goes to 0 where the background touches the glass, with either k1, and for small gaps as the gap
// over k1. Of a hand two centimetres behind a pane one metre away 4.6 pixels of deviation are left with .5 m
// and 34 with the listing's .05: only the former is "sharp". Far behind they agree.
TEST(PhenomenologicalReadings, AHandOnTheGlassIsSharpWithHalfAMetre) {
    const Screen screen = perspective_screen(1920, 1080);
    const SurfaceShader text = shader_of("", screen), listing = shader_of("k1=0.05", screen);
    const float pane = test::depth_at(*screen.camera, 1);
    const auto behind = [&](const SurfaceShader& shader, double gap) {
        return shader.deviation(pane, test::depth_at(*screen.camera, 1 + gap), 0, 1);
    };
    const double full = 540 / std::tan(std::numbers::pi / 6) * 0.128;
    for (const double gap : {0.02, 0.1, 0.3, 2.0}) {
        EXPECT_NEAR(behind(text, gap), full * gap / (gap + 0.5), 0.02) << gap;
        EXPECT_NEAR(behind(listing, gap), full * gap / (gap + 0.05), 0.05) << gap;
        EXPECT_NEAR(behind(listing, gap) / behind(text, gap), (gap + 0.5) / (gap + 0.05), 0.01) << gap;
    }
    EXPECT_NEAR(behind(text, 0.02), 4.605, 0.01);
    EXPECT_NEAR(behind(listing, 0.02), 34.2, 0.1);
    EXPECT_EQ(behind(text, 0), 0.0f);
    EXPECT_EQ(behind(listing, 0), 0.0f);
}

// Equations 6 and 7 weight D by alpha. By net coverage, as in Listing 1, frosted glass that absorbs nothing
// does not scatter.
TEST(PhenomenologicalReadings, ClearFrostedGlassScattersByAlphaOnly) {
    const TraceHeader header = test::single_bright_pixel(33, 16, 16);
    const Material frosted = material_of({1, 1, 1}, 0.5f);
    TestFrame alpha(with_keys(), header), net(with_keys(",diffusion_weight=net"), header);
    cover(alpha, 0.1f, 1, frosted);
    cover(net, 0.1f, 1, frosted);
    EXPECT_GT(test::word(alpha, 5, 5, 7), 0);
    EXPECT_EQ(test::word(net, 5, 5, 7), 0);
    const auto blurred = alpha.image(), sharp = net.image();
    EXPECT_EQ(pixel_of(sharp, 33, 16, 16), 1.0f);
    EXPECT_LT(pixel_of(blurred, 33, 16, 16), 0.5f);
    EXPECT_EQ(pixel_of(sharp, 33, 14, 16), 0.0f);
    EXPECT_GT(pixel_of(blurred, 33, 14, 16), 0.0f);
}

// Two Gaussians of 3 and 4 pixels convolved make one of 5, not of 7 as the prose of 4.3.1 and equation 6 have
// it: variances add.
TEST(PhenomenologicalReadings, VariancesAddInAConvolution) {
    constexpr int kReach = 60;
    const auto gaussian = [](double deviation) {
        std::vector<double> g;
        for (int i = -kReach; i <= kReach; ++i) g.push_back(std::exp(-i * i / (2 * deviation * deviation)));
        return g;
    };
    const auto a = gaussian(3), b = gaussian(4);
    double sum = 0, moment = 0;
    for (int i = -kReach; i <= kReach; ++i) {
        for (int j = -kReach; j <= kReach; ++j) {
            const double w =
                a[static_cast<std::size_t>(i + kReach)] * b[static_cast<std::size_t>(j + kReach)];
            sum += w;
            moment += w * (i + j) * (i + j);
        }
    }
    EXPECT_NEAR(std::sqrt(moment / sum), 5, 1e-6);

    // n equal layers: sqrt(n) times one's deviation, as stored; n times with deviation sums.
    const TraceHeader header = test::single_bright_pixel(8, 4, 4);
    const Material frosted = material_of({1, 1, 1}, 0.98f);
    const Screen screen = screen_of(header, 0);
    const double one = shader_of("", screen).deviation(0.1f, 0.75f, 0.98f, 1);
    for (const int n : {1, 4, 9}) {
        TestFrame variances("phenomenological:format=float32", header);
        TestFrame deviations("phenomenological:format=float32,diffusion_sum=deviation", header);
        cover(variances, 0.1f, 1, frosted, n);
        cover(deviations, 0.1f, 1, frosted, n);
        const auto shown = [&](TestFrame& frame, const char* keys) {
            return std::sqrt(filter_of(keys, screen).variance(test::word(frame, 4, 4, 7)));
        };
        EXPECT_NEAR(shown(variances, ""), std::sqrt(n) * one, 1e-5 * one);
        EXPECT_NEAR(shown(deviations, "diffusion_sum=deviation"), n * one, 1e-5 * one);
    }
}

TraceHeader ramp(int width, int height) {
    return test::pictured(width, height, 0.9999f, [=](int x, int y) -> std::array<float, 3> {
        return {static_cast<float>(x), static_cast<float>(y), 0};
    });
}
// Where in a ramp the pixel in the middle looks, from its own place.
glm::dvec2 shift(const std::string& technique, const TraceHeader& header, const Material& material) {
    TestFrame frame(technique, header);
    const int x = header.width / 2, y = header.height / 2;
    const Fragment f = test::fragment_at(x, y, test::depth_at(*header.camera, 4), 1, {0, 0, 0});
    frame.draw({&f, 1}, {}, {&material, 1});
    const auto c = frame.color(x, y);
    const double beta = test::word(frame, x, y, 4);
    return {c[0] / beta - x, c[1] / beta - y};
}

// Glass that lets everything through still bends: Listing 3 leaves where beta is 1.
TEST(PhenomenologicalReadings, ClearGlassRefracts) {
    const TraceHeader header = ramp(256, 192);
    const Material clear = material_of({1, 1, 1}, 1, 1.5f, glm::normalize(glm::vec3(0.3f, 0.2f, 1)));
    EXPECT_GT(glm::length(shift(with_keys(",refraction_weight=alpha"), header, clear)), 6);
    EXPECT_EQ(shift(with_keys(",refraction_weight=alpha,early_out=beta"), header, clear), glm::dvec2(0));
    // By net coverage, Listing 1's weight, such glass moves nothing whatever the resolve does.
    EXPECT_EQ(shift(with_keys(), header, clear), glm::dvec2(0));
}

// "As exact as previous methods for a single transmissive surface" (4.3.2): only by alpha. By net coverage,
// as "weighted by coverage and opacity" and Listing 1 have it, glass that lets nine tenths through bends a
// tenth.
TEST(PhenomenologicalReadings, ASingleSurfaceIsDisplacedExactlyByAlphaOnly) {
    const TraceHeader header = ramp(256, 192);
    const Material glass = material_of({0.9f, 0.9f, 0.9f}, 1, 1.5f, glm::normalize(glm::vec3(0.3f, 0.2f, 1)));
    const glm::dvec2 exact = shader_of("", screen_of(header, 0))
                                 .displacement(128, 96, test::depth_at(*header.camera, 4),
                                               glm::normalize(glm::vec3(0.3f, 0.2f, 1)), 1.5f);
    const glm::dvec2 alpha = shift("phenomenological:format=float32,refraction_weight=alpha", header, glass);
    const glm::dvec2 net = shift("phenomenological:format=float32", header, glass);
    EXPECT_NEAR(alpha.x, exact.x, 1e-3);
    EXPECT_NEAR(alpha.y, exact.y, 1e-3);
    EXPECT_NEAR(net.x, 0.1 * exact.x, 1e-3);
    EXPECT_NEAR(net.y, 0.1 * exact.y, 1e-3);
    // Layers add up (Listing 1), which is no average of theirs (4.3.2).
    const Fragment f = test::fragment_at(128, 96, test::depth_at(*header.camera, 4), 1, {0, 0, 0});
    TestFrame twice("phenomenological:format=float32", header);
    twice.draw(std::vector{f, f}, {}, std::vector{glass, glass});
    EXPECT_NEAR(63 * test::word(twice, 128, 96, 8), 0.2 * exact.x, 1e-4);
}

// Table 2 encodes 63 pixels as 1. Listing 3 reads 1 as .375 of the screen, in each direction its own, and as
// 200 pixels of deviation.
TEST(PhenomenologicalReadings, WhatIsEncodedBy63IsDecodedBy63) {
    const TraceHeader header = ramp(640, 480);
    const Screen screen = screen_of(header, 0);
    for (const glm::vec3 tilt : {glm::vec3(0.1f, 0.05f, 1), glm::vec3(-0.15f, 0.2f, 1)}) {
        const Material glass = material_of({1, 1, 1}, 1, 1.5f, glm::normalize(tilt));
        const glm::dvec2 exact =
            shader_of("", screen)
                .displacement(320, 240, test::depth_at(*header.camera, 4), glm::normalize(tilt), 1.5f);
        ASSERT_LT(glm::length(exact), 63);
        const glm::dvec2 table = shift(with_keys(",refraction_weight=alpha"), header, glass);
        const double half_code = 63.0 / 254;
        EXPECT_NEAR(table.x, exact.x, half_code + 1e-3);
        EXPECT_NEAR(table.y, exact.y, half_code + 1e-3);
        const glm::dvec2 listing =
            shift(with_keys(",refraction_weight=alpha,decoding=listing"), header, glass);
        EXPECT_NEAR(listing.x, table.x * 0.375 * 640 / 63, 1e-3);  // 3.8 times too far
        EXPECT_NEAR(listing.y, table.y * 0.375 * 480 / 63, 1e-3);  // 2.9: not even in one direction
    }
    const float stored = 10.0f * 10 / (63 * 63);
    EXPECT_NEAR(std::sqrt(filter_of("", screen).variance(stored)), 10, 1e-5);
    EXPECT_NEAR(std::sqrt(filter_of("decoding=listing", screen).variance(stored)), 10 * 200 / 63.0, 1e-4);
}

// "(1/63) factors give roughly 1/2-pixel precision on refraction and diffusion" (Table 2): a code of delta is
// .496 pixels. D^2 has eight bits: the least D is 3.9 pixels, 12.5 as Listing 3 decodes it, which caps D at
// 16: between nothing and all there is one step.
TEST(PhenomenologicalReadings, HalfAPixelOfPrecisionHoldsForRefractionOnly) {
    const Screen screen = perspective_screen(1920, 1080);
    const auto below_the_cap = [&](const char* keys) {
        std::set<float> deviations;
        for (int code = 1; code <= 255; ++code)
            deviations.insert(std::min(
                16.0f,
                std::sqrt(filter_of(keys, screen)
                              .variance(stored_value(Format::kUnorm8, static_cast<float>(code) / 255)))));
        return deviations;
    };
    const auto table = below_the_cap(""), listing = below_the_cap("decoding=listing");
    EXPECT_NEAR(*table.begin(), 63 / std::sqrt(255.0), 1e-4);     // 3.945
    EXPECT_NEAR(*listing.begin(), 200 / std::sqrt(255.0), 1e-4);  // 12.52
    EXPECT_EQ(table.size(), 17u);                                 // codes 1 to 16, and the cap
    EXPECT_EQ(listing.size(), 2u);
    // Neighbouring deviations are half a pixel apart at the cap, 15.8 and 15.3, and farther below it.
    EXPECT_NEAR(*std::prev(table.end(), 2) - *std::prev(table.end(), 3), 0.5, 0.01);
    EXPECT_NEAR(*std::next(table.begin()) - *table.begin(), 1.634, 1e-3);
}

// The text's mask, min(D, D') <= |offset|, takes what is farther than D and leaves out the middle; the
// listing's is the opposite.
TEST(PhenomenologicalReadings, TheListingsMaskGathersTheDisk) {
    constexpr int kSize = 33;
    const double d = 5;
    int text = 0, listing = 0;
    for (int y = -16; y <= 16; ++y) {
        for (int x = -16; x <= 16; ++x) {
            text += d <= std::hypot(x, y) ? 1 : 0;
            listing += std::hypot(x, y) <= d ? 1 : 0;
        }
    }
    EXPECT_EQ(listing, 81);  // Gauss's circle
    EXPECT_EQ(text, kSize * kSize - 69);
    // "A single pixel when D = 0": the text's mask would take all of them.
    TestFrame frame("phenomenological:format=float32,gather=exact", test::single_bright_pixel(kSize, 16, 16));
    test::Targets t;
    t.diffusion = static_cast<float>(d * d / (63 * 63) * 1.0001);
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) test::fill(frame, x, y, t);
    const auto image = frame.image();
    int reached = 0;
    for (std::size_t i = 0; i < image.size(); i += 3) reached += image[i] > 0 ? 1 : 0;
    EXPECT_EQ(reached, listing);
    EXPECT_GT(pixel_of(image, kSize, 16, 16), 0);
}

// A target of eight signed bits clamps each surface's displacement before it adds it: two that move the
// background 100 pixels apart cancel, whatever the order.
TEST(PhenomenologicalReadings, DisplacementsAreClampedBeforeTheyAreAdded) {
    const TraceHeader header = ramp(256, 192);
    const auto steep = [](float x) {
        return material_of({0, 0, 0}, 1, 2.5f, glm::normalize(glm::vec3(x, 0, 0.3f)));
    };
    const Fragment f = test::fragment_at(128, 96, test::depth_at(*header.camera, 1), 1, {0, 0, 0});
    TestFrame frame("phenomenological", header), exact("phenomenological:format=float32", header);
    exact.draw(std::vector{f}, {}, std::vector{steep(1)});
    ASSERT_LT(test::word(exact, 128, 96, 8), -1.2f);
    frame.draw(std::vector{f, f, f}, {},
               std::vector{material_of({0, 0, 0}, 1, 1.5f, {-0.2f, 0, 0.98f}), steep(-1), steep(1)});
    EXPECT_EQ(test::word(frame, 128, 96, 8), 0.0f);
}

}  // namespace
}  // namespace ropsim
