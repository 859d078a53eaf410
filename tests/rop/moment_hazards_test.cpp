// Where sums of moments and wavelets go wrong: order of arrival, extreme fragments, thin media, emission,
// range of depth.
#include "tests/rop/random_fragments.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

// Sums of n terms, each rounded to 2^-24 of what it is: in two orders they differ by no more than 2 (n - 1)
// such roundings of the sum of magnitudes, and |z^k| <= 1.
TEST(MomentHazards, OrderChangesSumsByTheirRounding) {
    for (const char* technique : {"moment_based:moments=8", "moment_based:moments=8,basis=trigonometric"}) {
        Random random(33);
        std::vector<Fragment> fragments;
        double absorbance = 0;
        for (int i = 0; i < 60; ++i) {
            fragments.push_back(
                test::fragment_at(0, 0, random.real(0, 1), random.real(0.01, 0.9), {1, 1, 1}));
            absorbance -= std::log(1.0 - static_cast<double>(fragments.back().a));
        }
        TestFrame first(technique, test::header_of(1, 1));
        first.draw_pass(0, fragments);
        for (int round = 0; round < 20; ++round) {
            random.shuffle(fragments);
            TestFrame other(technique, test::header_of(1, 1));
            other.draw_pass(0, fragments);
            for (std::size_t w = 0; w < 9; ++w)
                ASSERT_NEAR(std::bit_cast<float>(other.words(0, 0)[w]),
                            std::bit_cast<float>(first.words(0, 0)[w]), 2 * 60 * 0x1p-24 * absorbance)
                    << technique << " word " << w;
        }
    }
}

// In 16 bits every fragment rounds what is stored by half a step, and what it rounds weighs less with each
// that follows.
TEST(MomentHazards, OrderChangesSixteenBitMomentsByHalfAStepAFragment) {
    Random random(34);
    constexpr int kLayers = 40;
    std::vector<Fragment> fragments;
    for (int i = 0; i < kLayers; ++i)
        fragments.push_back(test::fragment_at(0, 0, random.real(0, 1), random.real(0.01, 0.9), {1, 1, 1}));
    const char* technique = "moment_based:moments=8,moment_format=unorm16,optical_depth_format=float32";
    TestFrame first(technique, test::header_of(1, 1));
    first.draw_pass(0, fragments);
    double worst = 0;
    for (int round = 0; round < 50; ++round) {
        random.shuffle(fragments);
        TestFrame other(technique, test::header_of(1, 1));
        other.draw_pass(0, fragments);
        for (std::size_t w = 1; w < 9; ++w)
            worst = std::max(worst, std::abs(static_cast<double>(std::bit_cast<float>(other.words(0, 0)[w])) -
                                             std::bit_cast<float>(first.words(0, 0)[w])));
    }
    EXPECT_GT(worst * 65535, 1.5) << "they do depend on the order";
    EXPECT_LT(worst * 65535, kLayers + 1);
}

// Largest change of any channel in 1/255 over four shuffles, 12 fragments a pixel.
double image_change(const std::string& technique) {
    Random random(35);
    const TraceHeader header = test::header_of(24, 24);
    test::FragmentOptions options;
    options.count = std::size_t{24} * 24 * 12;
    auto fragments = test::random_fragments(header, options, random);
    TestFrame first(technique, header, 0, 1, false);
    first.draw(fragments);
    const auto image = first.image();
    double worst = 0;
    for (int round = 0; round < 4; ++round) {
        random.shuffle(fragments);
        TestFrame other(technique, header, 0, 1, false);
        other.draw(fragments);
        const auto again = other.image();
        for (std::size_t i = 0; i < image.size(); ++i)
            worst = std::max(worst, 255 * std::abs(static_cast<double>(again[i]) - image[i]));
    }
    return worst;
}
// What the reconstruction makes of that. Measured, with twice the room: it has no useful bound, since near a
// singular matrix it is discontinuous.
TEST(MomentHazards, OrderChangesTheImageLittle) {
    EXPECT_LT(image_change("moment_based:format=float32"), 0.06);
    EXPECT_LT(image_change("moment_based:format=float32,moments=6"), 0.32);
    EXPECT_LT(image_change("moment_based:format=float32,moments=8"), 0.12);
    EXPECT_LT(image_change("moment_based:format=float32,basis=trigonometric"), 0.14);
    EXPECT_LT(image_change("moment_based:format=float32,moments=8,basis=trigonometric"), 0.05);
    EXPECT_LT(image_change("moment_based:format=float32,moment_format=unorm16"), 1.0);
    EXPECT_LT(image_change("moment_based:format=float32,moment_format=unorm16,moments=8"), 1.0);
}

// Finite and not negative, whatever comes: alpha 0, 1, tiny; equal, extreme and neighbouring depths; bright
// colours; 500 layers.
TEST(MomentHazards, NothingMakesItInfinite) {
    for (const char* technique :
         {"moment_based", "moment_based:moments=6", "moment_based:moments=8", "moment_based:guard=published",
          "moment_based:guard=published,moments=6", "moment_based:guard=published,moments=8",
          "moment_based:moments=4,moment_format=unorm16", "moment_based:moments=8,moment_format=unorm16",
          "moment_based:basis=trigonometric",
          "moment_based:basis=trigonometric,moments=8,moment_format=unorm16", "wavelet", "wavelet:rank=5",
          "wavelet:rank=1,bounds=frame", "wavelet:format=float32"}) {
        Random random(37);
        const TraceHeader header = test::header_of(16, 16);
        std::vector<Fragment> fragments;
        for (int pixel = 0; pixel < 256; ++pixel) {
            const int layers = pixel == 0 ? 500 : random.integer(1, 12);
            const float base = random.real(0, 1);
            for (int i = 0; i < layers; ++i) {
                const float tiny = random.integer(0, 1) == 0 ? 1e-40f : random.real(0, 1e-4);
                const std::array<float, 5> alphas = {0.0f, 1.0f, tiny, random.real(0, 1), 1 - 0x1p-24f};
                const std::array<float, 5> depths = {0.0f, 1 - 0x1p-24f, base, std::nextafter(base, 1.0f),
                                                     random.real(0, 1)};
                const float bright = random.integer(0, 3) == 0 ? 60.0f : 1.0f;
                fragments.push_back(test::fragment_at(
                    pixel % 16, pixel / 16, depths[static_cast<std::size_t>(random.integer(0, 4))],
                    alphas[static_cast<std::size_t>(random.integer(0, 4))], {bright, 0.5f, 0}));
            }
        }
        TestFrame frame(technique, header, 0, 1, false);
        frame.draw(fragments);
        for (const float value : frame.image()) {
            ASSERT_TRUE(std::isfinite(value)) << technique;
            ASSERT_GE(value, 0.0f) << technique;
            ASSERT_LE(value, 61.0f) << technique;
        }
    }
}

std::array<float, 3> color_of(const std::string& technique, std::span<const Fragment> fragments,
                              float background) {
    TestFrame frame(technique, test::header_of(1, 1, 1, {background, background, background}));
    frame.draw(fragments);
    return frame.color();
}

// 1,000 layers of alpha 1e-4 hide 9.5%. The paper's 16-bit sum takes each for up to a fifth more or less.
TEST(MomentHazards, ThinMediaInASixteenBitSum) {
    std::vector<Fragment> fragments;
    Random random(38);
    for (int i = 0; i < 1000; ++i)
        fragments.push_back(test::fragment_at(0, 0, random.real(0, 1), 1e-4f, {0, 0, 0}));
    const double exact = std::pow(1 - 1e-4, 1000);  // 0.90483; an ulp of the image is 2^-11
    EXPECT_NEAR(color_of("moment_based", fragments, 1)[0], exact, 0x1p-11);
    const std::string quantised = "moment_based:moment_format=unorm16";
    EXPECT_NEAR(color_of(quantised, fragments, 1)[0], 0.8994, 0x1p-10);
    EXPECT_NEAR(color_of(quantised + ",optical_depth_format=float32", fragments, 1)[0], exact, 0x1p-11);
}

// The paper's shaders take a pixel of less absorbance than 0.001 for empty: a bright one goes dark.
TEST(MomentHazards, ThinAndBrightPixels) {
    const Fragment thin = test::fragment_at(0, 0, 0.5f, 9e-4f, {100, 0, 0});
    EXPECT_NEAR(color_of("moment_based", {&thin, 1}, 0)[0], 0.09, 1e-4);
    EXPECT_EQ(color_of("moment_based:guard=published", {&thin, 1}, 0)[0], 0.0f);
}

// Colour without alpha is scaled with the rest to the total alpha: in front of an opaque layer, whose own
// quarter of absorbance counts against it, by e^(10 / 4) = 12. A wavelet takes a fragment's own step out.
TEST(MomentHazards, EmissionInFrontOfAnOpaqueLayer) {
    Fragment glow = test::fragment_at(0, 0, 0.2f, 0, {0, 0, 0});
    glow.r = 0.1f;
    const std::vector<Fragment> pair = {glow, test::fragment_at(0, 0, 0.5f, 1, {0, 1, 0})};
    EXPECT_NEAR(color_of("moment_based:format=float32", pair, 0)[0], 0.1 * std::exp(2.5), 1e-3);
    EXPECT_NEAR(color_of("moment_based:format=float32,absorbance_limit=3", pair, 0)[0], 0.1 * std::exp(0.75),
                1e-3);
    EXPECT_NEAR(color_of("wavelet:format=float32", pair, 0)[0], 0.1, 1e-5);
}

// Depths that fill a twentieth of the range leave higher moments below the bias; planes around them bring
// them back.
TEST(MomentHazards, RangeOfDepthMatters) {
    Random random(39);
    TraceHeader header = test::header_of(16, 16);
    header.camera = Camera{};
    header.camera->near_plane = 1;
    header.camera->far_plane = 100;
    std::vector<Fragment> fragments;
    for (int pixel = 0; pixel < 256; ++pixel)
        for (int i = 0; i < 8; ++i) {
            const double distance = random.real(10, 13);
            fragments.push_back(test::fragment_at(
                pixel % 16, pixel / 16, static_cast<float>((1 - 1 / distance) / (1 - 1 / 100.0)), 0.3f,
                {random.real(0, 1), random.real(0, 1), random.real(0, 1)}));
        }
    const auto error = [&](const std::string& keys) {
        TestFrame frame("moment_based:format=float32,moments=8" + keys, header, 0, 1, false);
        frame.draw(fragments);
        return test::worst_error(frame, fragments);
    };
    EXPECT_LT(error(",near=10,far=13"), 0.6 * error(""));
}

// Dozens of nearly opaque fragments hide one another from the moments: every transmittance underflows. What
// is left is a mean of their colours, and not black or infinite.
TEST(MomentHazards, NearlyOpaqueFragmentsByTheDozenKeepAColour) {
    for (const char* technique :
         {"moment_based:moments=4", "moment_based:moments=4,format=float32", "moment_based:moments=6",
          "moment_based:moments=8,format=float32", "moment_based:moments=4,basis=trigonometric",
          "moment_based:moments=6,moment_format=unorm16"}) {
        Random random(36);
        for (int round = 0; round < 50; ++round) {
            std::vector<Fragment> fragments;
            const float center = random.real(0.1, 0.9);
            for (int i = 0; i < 64; ++i)
                fragments.push_back(test::fragment_at(0, 0, center + random.real(0, 1e-4),
                                                      random.real(0.9999, 1), {0.5f, 0.75f, 1}));
            TestFrame frame(technique, test::header_of(1, 1), 0, 1, false);
            frame.draw(fragments);
            const auto image = frame.image();
            EXPECT_NEAR(image[0], 0.5f, 0.02) << technique;
            EXPECT_NEAR(image[1], 0.75f, 0.02) << technique;
            EXPECT_NEAR(image[2], 1.0f, 0.02) << technique;
        }
    }
}

// The least transmittance must not let what is hidden shine through: 300 of them at 2^-20 are 2/255 of what
// the fragment in front keeps here; ten times as much at 1e-5.
TEST(MomentHazards, HundredsOfHiddenFragmentsStayHidden) {
    Random random(40);
    std::vector<Fragment> fragments;
    for (int i = 0; i < 300; ++i)
        fragments.push_back(test::fragment_at(0, 0, random.real(0.5, 0.9), 1, {1, 1, 1}));
    fragments.push_back(test::fragment_at(0, 0, 0.1f, 1, {0, 0, 0}));
    for (const char* technique : {"moment_based:moments=4", "moment_based:moments=4,format=float32"}) {
        const auto color = color_of(technique, fragments, 0);
        const auto own = color_of(std::string(technique) + ",guard=published", fragments, 0);
        EXPECT_NEAR(color[0], own[0], 3.0f / 255) << technique;
    }
}

}  // namespace
}  // namespace ropsim
