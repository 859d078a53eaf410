// Adaptive transparency over traces of several spatial samples (Salvi et al. 2011, sections 4.2 and 5.4).
#include "tests/rop/random_fragments.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

constexpr int kSide = 8;

std::vector<Fragment> covering_some(const TraceHeader& header, int most, Random& random) {
    test::FragmentOptions options;
    options.count = static_cast<std::size_t>(most * kSide * kSide * 3 / 4);
    options.distinct_depths = true;
    options.most_in_a_pixel = most;
    return test::random_fragments(header, options, random);
}

// Exact compositing of each sample by the fragments that cover it, and their mean.
std::array<double, 3> exact_mean(std::span<const Fragment> fragments, int x, int y, int samples,
                                 std::array<double, 3> background) {
    std::array<double, 3> mean{};
    for (int m = 0; m < samples; ++m) {
        std::vector<Fragment> own;
        for (const Fragment& f : fragments)
            if (((f.coverage >> m) & 1) != 0) own.push_back(f);
        const auto color = test::composited(own, x, y, background);
        for (std::size_t c = 0; c < 3; ++c) mean[c] += color[c] / samples;
    }
    return mean;
}
double worst_error(const std::string& technique, const TraceHeader& header,
                   std::span<const Fragment> fragments) {
    TestFrame frame(technique, header);
    frame.draw(fragments);
    const auto image = frame.image();
    double worst = 0;
    for (int pixel = 0; pixel < kSide * kSide; ++pixel) {
        const int x = pixel % kSide;
        const int y = pixel / kSide;
        const auto exact = exact_mean(fragments, x, y, header.samples, test::background_of(header, x, y));
        for (std::size_t c = 0; c < 3; ++c)
            worst = std::max(worst, std::abs(image[static_cast<std::size_t>(3 * pixel) + c] - exact[c]));
    }
    return worst;
}

// Each sample has a curve of the fragments that cover it: exact up to N of them, to the depth that the mask
// takes away.
TEST(AdaptiveSamples, VariableMemoryIsExactForEachSample) {
    for (const int samples : {2, 4, 8}) {
        Random random(41);
        const TraceHeader header = test::opaque_header(kSide, kSide, samples, random);
        const auto fragments = covering_some(header, 8, random);
        for (const char* composite : {"plain", "normalised"})
            EXPECT_LT(
                worst_error(fmt::format("adaptive:memory=variable,format=float32,composite={}", composite),
                            header, fragments),
                1e-4)
                << samples;
    }
    EXPECT_THROW(TestFrame::make("adaptive:memory=variable", test::header_of(1, 1, 16)), UserError);
    EXPECT_NO_THROW(TestFrame::make("adaptive", test::header_of(1, 1, 16)));
}

// One curve a pixel is exact where fragments cover all of it.
TEST(AdaptiveSamples, FixedMemoryIsExactForWholePixels) {
    Random random(42);
    const TraceHeader header = test::opaque_header(kSide, kSide, 4, random);
    auto fragments = covering_some(header, 8, random);
    for (Fragment& f : fragments) f.coverage = 0xF;
    for (const char* composite : {"plain", "normalised"})
        EXPECT_LT(
            worst_error(fmt::format("adaptive:format=float32,composite={}", composite), header, fragments),
            1e-5);
}

// Whatever covers what: black fragments in front of white show each sample's own total transmittance.
TEST(AdaptiveSamples, TotalTransmittanceIsExactForEachSample) {
    for (const int nodes : {2, 8}) {
        Random random(43);
        const TraceHeader header = test::header_of(kSide, kSide, 4, {1, 1, 1});
        auto fragments = covering_some(header, 24, random);
        for (Fragment& f : fragments) f.r = f.g = f.b = 0;
        EXPECT_LT(worst_error(fmt::format("adaptive:format=float32,nodes={}", nodes), header, fragments),
                  1e-5);
        EXPECT_LT(worst_error(fmt::format("adaptive:format=float32,nodes={},memory=variable", nodes), header,
                              fragments),
                  1e-4);
    }
}

// The shared curve, by hand. A red fragment covers half of the pixel with alpha .5: it enters with .25.
// Behind it a blue one covers the other half, which exact compositing would not attenuate: .75 of it is left.
// Where both cover the same half exact compositing leaves .5 of it. Over many fragments the two errors have
// opposite signs; entering with all of alpha would always err to the dark.
TEST(AdaptiveSamples, APartlyCoveringFragmentEntersWithItsShare) {
    Fragment red = test::fragment_at(0, 0, 0.25f, 0.5f, {1, 0, 0});
    Fragment blue = test::fragment_at(0, 0, 0.75f, 0.5f, {0, 0, 1});
    red.coverage = 0x3;
    const auto shade = [&](std::uint16_t coverage, const char* composite) {
        blue.coverage = coverage;
        TestFrame frame(fmt::format("adaptive:format=float32,composite={}", composite),
                        test::header_of(1, 1, 4, {0, 0, 0}));
        frame.draw(std::vector<Fragment>{red, blue});
        return frame.color();
    };
    EXPECT_EQ(shade(0xC, "plain"), (std::array<float, 3>{0.25f, 0, 0.1875f})) << "exact: .25 blue";
    EXPECT_EQ(shade(0x3, "plain"), (std::array<float, 3>{0.25f, 0, 0.1875f})) << "exact: .125 blue";
    // Normalised sample by sample: what one fragment alone covers is right.
    EXPECT_EQ(shade(0xC, "normalised"), (std::array<float, 3>{0.25f, 0, 0.25f}));
    const auto both = shade(0x3, "normalised");
    EXPECT_NEAR(both[0] + both[2], 0.375, 1e-6) << "total alpha of both";
}

}  // namespace
}  // namespace ropsim
