// What phenomenological transparency lays over the background: self-modulation, overflow, and what a resolve
// reads. McGuire and Mara 2017, section 5.0.4 and Listing 3.
#include "tests/rop/phenomenological_scene.h"

#include <limits>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::fill;
using test::pixel_of;
using test::Random;
using test::TargetField;
using test::Targets;
using test::TestFrame;

// The technique with these keys besides.
std::string with_keys(const std::string& keys = "") {
    return "phenomenological:format=float32" + keys;
}
constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Equation 14 and Listing 3, which keeps beta from 0 in the numerator too: an opaque surface would lose half
// of its light.
TEST(PhenomenologicalSelfModulation, IsEquation14WithTheListingsFloor) {
    Random random(14);
    TargetField field(16, 16, random);
    for (Targets& t : field.targets) {
        t.net = random.real(0.1, 8);
        for (std::size_t c = 0; c < 3; ++c) {
            t.color[c] = random.real(0, 8);
            t.beta[c] = random.real(0.01, 0.99);
        }
    }
    const auto with = field.resolved(with_keys()),
               without = field.resolved(with_keys(",self_modulation=off"));
    for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < 16; ++x) {
            const Targets& t = field.at(x, y);
            const double most = std::max({t.beta[0], t.beta[1], t.beta[2]});
            for (std::size_t c = 0; c < 3; ++c) {
                const double behind = t.beta[c] * field.behind(x, y)[c];
                const double mean = t.color[c] / double{t.net};
                const double modulated = mean * (0.5 + t.beta[c] / (2 * std::max(most, 1e-3)));
                const int i = static_cast<int>(c);
                const double rest = 1.0 - t.beta[c];
                ASSERT_NEAR(pixel_of(with, 16, x, y, i), behind + rest * modulated, 1e-4);
                ASSERT_NEAR(pixel_of(without, 16, x, y, i), behind + rest * mean, 1e-4);
            }
        }
    }
    TargetField opaque(1, 1, random);
    opaque.targets[0] = {{1.5f, 3, 0.75f}, 3, {0, 0, 0}, 0, 0, 0};
    const auto image = opaque.resolved(with_keys());
    EXPECT_FLOAT_EQ(image[0], 0.5f);  // equation 14 as printed: .25
    EXPECT_FLOAT_EQ(image[1], 1.0f);
    EXPECT_FLOAT_EQ(image[2], 0.25f);
    // Below epsilon one channel no longer modulates the others: beta of .0005, 0, 0 counts as .001 thrice.
    opaque.targets[0].beta = {0.0005f, 0, 0};
    EXPECT_NEAR(opaque.resolved(with_keys())[1], 1.0, 1e-6);
    // Above it does: half of what is reflected where beta is red alone.
    opaque.targets[0].beta = {0.5f, 0, 0};
    EXPECT_NEAR(opaque.resolved(with_keys())[1], 0.5 + 0.001, 1e-6);
}

// Listing 3: an infinite A_a gives way to the largest colour, an infinite colour to white.
TEST(PhenomenologicalOverflow, IsReplacedAsListing3Says) {
    Random random(15);
    TargetField field(1, 1, random);
    const std::string plain = with_keys(",self_modulation=off");
    const auto expect = [&](const Targets& t, std::array<double, 3> surface) {
        field.targets[0] = t;
        const auto image = field.resolved(plain);
        for (std::size_t c = 0; c < 3; ++c) {
            const double exact = t.beta[c] * field.behind(0, 0)[c] + (1.0 - t.beta[c]) * surface[c];
            EXPECT_NEAR(image[c], exact, 1e-6) << c;
        }
    };
    const std::array<float, 3> beta = {0.25f, 0.5f, 0};
    expect({{10, 40, 20}, kInfinity, beta, 0, 0, 0}, {0.25, 1, 0.5});
    expect({{10, kInfinity, 20}, 40, beta, 0, 0, 0}, {1, 1, 1});
    expect({{kInfinity, kInfinity, kInfinity}, kInfinity, beta, 0, 0, 0}, {1, 1, 1});
    expect({{0, 0, 0}, kInfinity, beta, 0, 0, 0}, {0, 0, 0});
    // Nothing there, but a little absorbed: no division by 0.
    expect({{0, 0, 0}, 0, beta, 0, 0, 0}, {0, 0, 0});
}

// 64 layers of light that binary16 cannot add up.
TEST(PhenomenologicalOverflow, SaturatesWhereAsked) {
    std::vector<Fragment> fragments;
    for (std::uint32_t i = 0; i < 64; ++i)
        fragments.push_back(test::fragment_at(0, 0, 0.1f, 0.9f, {800, 80, 8}, i));
    TestFrame replaced("phenomenological", test::with_materials(test::header_of(1, 1)));
    TestFrame saturated("phenomenological:overflow=saturate", test::with_materials(test::header_of(1, 1)));
    replaced.draw(fragments);
    saturated.draw(fragments);
    EXPECT_EQ(test::word(replaced, 0, 0, 0), kInfinity);
    EXPECT_EQ(test::word(saturated, 0, 0, 0), 65504.0f);
    EXPECT_EQ(replaced.color()[1], 1.0f);
    const float net = test::word(saturated, 0, 0, 3), green = test::word(saturated, 0, 0, 1);
    EXPECT_NEAR(saturated.color()[0], 65504.0 / net, 0.02);
    EXPECT_NEAR(saturated.color()[1], green / net, 0.1);
}

// What a resolve reads: two surfaces of its own pixel, RT0 where something is seen, D of every tap in the
// disk, the opaque layer where a tap counts, and four of its pixels where it is displaced.
TEST(PhenomenologicalReads, AreThoseOfTheKernel) {
    constexpr int kSize = 24;
    const auto counts = [&](const Targets& middle, const Targets& others, const std::string& keys) {
        TestFrame frame(with_keys(keys), test::single_bright_pixel(kSize, 0, 0));
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x) fill(frame, x, y, x == 12 && y == 12 ? middle : others);
        frame.image();
        const Declaration& d = frame.declaration();
        EXPECT_EQ(d.surfaces[1].name, "beta");
        return std::array<std::uint64_t, 4>{frame.log().read_elements(0), frame.log().read_elements(1),
                                            frame.log().read_elements(2), frame.log().backgrounds()};
    };
    constexpr std::uint64_t kAll = std::uint64_t{kSize} * kSize;
    using Counts = std::array<std::uint64_t, 4>;
    EXPECT_EQ(counts({}, {}, ""), (Counts{0, kAll, kAll, kAll}));
    Targets moved;
    moved.x = 0.1f;
    EXPECT_EQ(counts(moved, {}, ""), (Counts{1, kAll, kAll, kAll - 1 + 4}));
    Targets clear;
    clear.beta = {0.5f, 1, 1};
    EXPECT_EQ(counts(clear, {}, ""), (Counts{1, kAll, kAll, kAll}));
    // D = 6.5: of the lattice two pixels apart 37 lie within 3.25 steps (Gauss's circle problem), of all
    // pixels 137 within 6.5. Around nothing diffuses: one counts.
    Targets blurred;
    blurred.diffusion = 6.5f * 6.5f / (63 * 63);
    EXPECT_EQ(counts(blurred, {}, ""), (Counts{1, kAll + 37, kAll, kAll}));
    EXPECT_EQ(counts(blurred, {}, ",gather=exact"), (Counts{1, kAll + 137, kAll, kAll}));
    // Neighbours that reach three pixels count where they are within that: 9 of the lattice, 29 of all. Each
    // of them looks at as many, and all count.
    Targets narrow;
    narrow.diffusion = 3.1f * 3.1f / (63 * 63);
    const std::uint64_t others = kAll - 1;
    EXPECT_EQ(counts(blurred, narrow, ""), (Counts{kAll, kAll + 37 + others * 9, kAll, 9 + others * 9}));
    EXPECT_EQ(counts(blurred, narrow, ",gather=exact"),
              (Counts{kAll, kAll + 137 + others * 29, kAll, 29 + others * 29}));
}

// A pixel on a sample of the small targets takes nothing of the next one, even if that has overflowed.
TEST(PhenomenologicalOverflow, OfTheNextSampleStaysThere) {
    const TraceHeader header = test::with_materials(test::header_of(8, 8));
    TestFrame frame("phenomenological:low_resolution=2,low_draws=all,upsample=bilinear", header);
    const std::vector<Fragment> fragments{test::fragment_at(0, 0, 0.1f, 1, {0.5f, 0.5f, 0.5f}),
                                          test::fragment_at(1, 0, 0.1f, 1, {60000, 60000, 60000})};
    frame.draw_pass(0, fragments);
    ASSERT_TRUE(
        std::isinf(frame.declaration().surfaces[3].name == "low_accumulated"
                       ? std::bit_cast<float>(frame.words(
                             1, 0)[static_cast<std::size_t>(frame.declaration().surfaces[3].first_word)])
                       : 0.0f));
    frame.image_pass(2);
    EXPECT_TRUE(std::isfinite(test::word(frame, 1, 1, 0)));
    EXPECT_FALSE(std::isfinite(test::word(frame, 2, 1, 0)));  // half way
}

}  // namespace
}  // namespace ropsim
