// Surface tracking through the technique (Laine and Karras 2011, sections 2 and 4, Figure 1): a surface drawn
// in parts has no noise at the edges between them.
#include "tests/rop/pixel_moments.h"
#include "traces/sample_positions.h"

namespace ropsim {
namespace {

constexpr int kSide = 128;
constexpr int kSpatial = 4;
constexpr int kSamples = 16;
constexpr float kAlpha = 0.7f;

// Figure 1, bottom: five bands of one surface. In each pixel the fragments of the bands that cover some of
// its samples.
std::vector<Fragment> banded_surface() {
    std::vector<Fragment> fragments;
    const auto positions = sample_positions(kSpatial);
    for (int i = 0; i < kSide * kSide; ++i) {
        std::array<std::uint16_t, 5> coverage{};
        const int row = i / kSide;
        for (std::size_t m = 0; m < kSpatial; ++m) {
            const float x = static_cast<float>(i % kSide) + positions[m].x();
            const float y = static_cast<float>(row) + positions[m].y();
            const int band = std::clamp(static_cast<int>((y - 0.37f * x + 50) / 35), 0, 4);
            coverage[static_cast<std::size_t>(band)] |= static_cast<std::uint16_t>(1u << m);
        }
        for (std::uint32_t band = 0; band < 5; ++band) {
            if (coverage[band] == 0) continue;
            Fragment f = test::fragment_at(i % kSide, i / kSide, 0.5f, kAlpha, {1, 1, 1}, band);
            f.coverage = coverage[band];
            fragments.push_back(f);
        }
    }
    return fragments;
}

// Numbers of samples that pixels inside bands and at their edges hold: mean squared distance from alpha's
// share, what independent parts would have, and the standard error of that.
struct Noise {
    double squared = 0;
    double of_parts = 0;
    double error = 0;
    int pixels = 0;
    int lowest = kSamples;
    int highest = 0;
};
struct Bands {
    Noise inside;
    Noise edge;
};
// Of a part of n samples floor(alpha n) or one more are taken.
test::Moments of_part(int n) {
    const double expected = static_cast<double>(kAlpha) * n;
    const double fraction = expected - std::floor(expected);
    return test::moments_of({{std::floor(expected), 1 - fraction}, {std::floor(expected) + 1, fraction}});
}
Bands noise_of(const std::string& technique) {
    const auto fragments = banded_surface();
    const TraceHeader header = test::header_of(kSide, kSide, kSpatial, {0, 0, 0});
    const auto image = test::image_of(technique + ",samples=16,format=float32", header, fragments, 3);
    std::vector<test::Moments> parts(std::size_t{kSide} * kSide);
    std::vector<int> count(parts.size(), 0);
    for (const Fragment& f : fragments) {
        const auto p = static_cast<std::size_t>(f.y * kSide + f.x);
        const test::Moments m = of_part(std::popcount(f.coverage) * kSamples / kSpatial);
        // Fourth moments of independent parts: cross terms count three times two.
        parts[p].fourth += m.fourth + 6 * parts[p].variance * m.variance;
        parts[p].variance += m.variance;
        ++count[p];
    }
    Bands bands;
    for (std::size_t p = 0; p < parts.size(); ++p) {
        Noise& noise = count[p] > 1 ? bands.edge : bands.inside;
        const double taken = 16 * static_cast<double>(image[3 * p]);
        noise.squared += std::pow(taken - static_cast<double>(kAlpha) * 16, 2);
        noise.of_parts += parts[p].variance;
        noise.error += parts[p].fourth - parts[p].variance * parts[p].variance;
        ++noise.pixels;
        noise.lowest = std::min(noise.lowest, static_cast<int>(std::lround(taken)));
        noise.highest = std::max(noise.highest, static_cast<int>(std::lround(taken)));
    }
    for (Noise* noise : {&bands.inside, &bands.edge}) {
        noise->squared /= noise->pixels;
        noise->of_parts /= noise->pixels;
        noise->error = std::sqrt(noise->error) / noise->pixels;
    }
    return bands;
}

// 0.7 x 16 = 11.2: every pixel takes 11 or 12, at edges as inside.
TEST(Tracking, EdgesHoldFloorOrCeilingOfTheShare) {
    for (const char* hash : {"paper", "improved"}) {
        const Bands bands = noise_of(std::string("laine_karras:hash=") + hash);
        EXPECT_GT(bands.edge.pixels, 250);
        for (const Noise& noise : {bands.inside, bands.edge}) {
            EXPECT_EQ(noise.lowest, 11);
            EXPECT_EQ(noise.highest, 12);
            EXPECT_NEAR(noise.squared, 0.16, 0.05);
        }
    }
}

// "Stratification is only achieved within each fragment, primitive edges have higher amount of noise": what
// stochastic transparency does, and this method without tracking.
TEST(Tracking, WithoutItEdgesAreNoisier) {
    for (const char* technique : {"stochastic:masks=choose", "laine_karras:tracking=false"}) {
        const Bands bands = noise_of(technique);
        EXPECT_NEAR(bands.inside.squared, 0.16, 4 * bands.inside.error) << technique;
        EXPECT_NEAR(bands.edge.squared, bands.edge.of_parts, 4 * bands.edge.error) << technique;
        EXPECT_GT(bands.edge.of_parts, 0.16 + 8 * bands.edge.error);
        EXPECT_LT(bands.edge.lowest, 11) << technique;
    }
}

// The two halves of a pixel, alpha 5/16: 5 samples always; by themselves 2 or 3 each, 4 to 6 together,
// variance 1/2.
TEST(Tracking, ASurfaceInTwoFragmentsIsStratified) {
    const TraceHeader header = test::header_of(kSide, kSide, kSpatial, {0, 0, 0});
    std::vector<Fragment> halves(2, test::fragment_at(0, 0, 0.5f, 5.0f / 16, {1, 1, 1}));
    halves[0].coverage = 0b0101;
    halves[1].coverage = 0b1010;
    halves[1].primitive = 1;
    const auto taken = [&](const std::string& tracking) {
        auto image = test::image_of("laine_karras:samples=16,format=float32,tracking=" + tracking, header,
                                    test::everywhere(header, halves), 3);
        for (float& v : image) v *= 16;
        return image;
    };
    for (const float n : taken("true")) ASSERT_EQ(n, 5.0f);
    test::expect_moments(taken("false"), 0, test::moments_of({{4, 0.25}, {5, 0.5}, {6, 0.25}}));
}

}  // namespace
}  // namespace ropsim
