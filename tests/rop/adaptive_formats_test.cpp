// Adaptive transparency's nodes in fewer bits: each hazard of a format provoked, and what the operation does.
#include "tests/rop/random_fragments.h"
#include "tests/rop/worst_case_bytes.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

// Total transmittance of `layers` black layers in front of white.
double total_of(const std::string& keys, int layers, float alpha, std::uint64_t seed = 0) {
    Random random(21);
    std::vector<Fragment> fragments;
    for (int i = 0; i < layers; ++i)
        fragments.push_back(
            test::fragment_at(0, 0, random.real(0, 0.99), alpha, {0, 0, 0}, static_cast<std::uint32_t>(i)));
    TestFrame frame("adaptive:image_format=float32," + keys, test::header_of(1, 1, 1, {1, 1, 1}), seed);
    frame.draw(fragments);
    return frame.color()[0];
}

// Rounded to nearest, T (1 - alpha) goes back to T once T alpha is below half a step: at T = 1 below alpha =
// 1/510, later about 0.5/alpha of 255.
TEST(AdaptiveFormats, Unorm8ToNearestStalls) {
    EXPECT_EQ(total_of("transmittance_format=unorm8", 1000, 0.0019f), 1.0) << "never gets under way";
    EXPECT_NEAR(total_of("transmittance_format=unorm8", 2000, 0.01f), 50 / 255.0, 1e-6);
    EXPECT_NEAR(total_of("transmittance_format=unorm8", 2000, 0.005f), 100 / 255.0, 1e-6);
    EXPECT_LT(total_of("format=float32", 2000, 0.005f), 1e-4);
}

// Bits cut off, as Intel's one-pass AOIT stores transmittance: every insertion loses a step, and where T t
// is a whole step short of T it loses the next one too. 200 layers of .0018 leave .70.
TEST(AdaptiveFormats, Unorm8CutOffLosesAStepAnInsertion) {
    const double exact = std::pow(1 - 0.0018, 200);
    EXPECT_NEAR(exact, 0.6975, 1e-4);
    EXPECT_NEAR(total_of("transmittance_format=unorm8,transmittance_rounding=down", 200, 0.0018f),
                (255 - 200) / 255.0, 1e-6);
}

// The same in every form of the operation: a sum that outgrows binary16 stops at its end.
TEST(AdaptiveFormats, SumsOfBrightLayersStopInEveryForm) {
    std::vector<Fragment> fragments = {test::fragment_at(0, 0, 0.25f, 0.5f, {2e5f, 1000, 0}, 0),
                                       test::fragment_at(0, 0, 0.5f, 0.5f, {2e5f, 1000, 0}, 1),
                                       test::fragment_at(0, 0, 0.75f, 0.5f, {2e5f, 1000, 0}, 2)};
    for (const char* keys : {"nodes=4", "nodes=4,memory=shader", "nodes=4,equal_depth=behind",
                             "nodes=4,removal=overestimate", "nodes=4,composite=normalised"})
        for (const int samples : {1, 4}) {
            for (Fragment& f : fragments) f.coverage = static_cast<std::uint16_t>((1 << samples) - 1);
            TestFrame frame(std::string("adaptive:image_format=float32,") + keys,
                            test::header_of(1, 1, samples, {0, 0, 0}));
            frame.draw(fragments);
            const auto color = frame.color();
            EXPECT_NEAR(color[0], 65504, 64) << keys << " " << samples;
            EXPECT_NEAR(color[1], 1000 * 0.875, 1) << keys << " " << samples;
        }
}

// With a draw the mean is exact: over seeds, within 5 standard deviations of the mean of 400, each of which
// is at most half a step an insertion.
TEST(AdaptiveFormats, DitheredTransmittanceIsUnbiased) {
    for (const char* format : {"unorm8", "log8", "float16"}) {
        for (const auto& [layers, alpha] : {std::pair(200, 0.0018f), std::pair(100, 0.02f)}) {
            const double exact = std::pow(1 - static_cast<double>(alpha), layers);
            constexpr int kSeeds = 400;
            double mean = 0;
            double square = 0;
            for (int seed = 0; seed < kSeeds; ++seed) {
                const double total =
                    total_of(fmt::format("transmittance_format={},transmittance_rounding=dithered", format),
                             layers, alpha, static_cast<std::uint64_t>(seed));
                mean += total / kSeeds;
                square += total * total / kSeeds;
            }
            const double deviation = std::sqrt((square - mean * mean) / kSeeds);
            EXPECT_NEAR(mean, exact, 5 * deviation + 1e-6) << format << " " << alpha;
            EXPECT_LT(deviation, 0.02);
        }
    }
}

// Constant relative steps: to nearest an alpha below half a step never shows at any transmittance, which
// UNORM8 does only near 1. A larger one goes down to the last value above 0 and stays there: the step to 0 is
// as large as that value, so only an alpha of 1/2 takes it.
TEST(AdaptiveFormats, Log8StallsAtSmallAlphaEverywhere) {
    EXPECT_EQ(total_of("transmittance_format=log8", 1000, 0.0105f), 1.0);
    EXPECT_NEAR(total_of("transmittance_format=log8", 1000, 0.0115f), std::exp2(-254 / 32.0), 1e-6);
    EXPECT_NEAR(total_of("transmittance_format=log8", 1000, 0.49f), std::exp2(-254 / 32.0), 1e-6);
    EXPECT_EQ(total_of("transmittance_format=log8", 1000, 0.51f), 0.0);
    EXPECT_EQ(total_of("transmittance_format=unorm16", 1000, 1e-6f), 1.0) << "16 bits stall too, later";
}

// Whatever is kept in how few bits, the curve falls, depths rise, and a fragment alone at its depth is not
// hidden by its own node, which rounding could put in front of it.
TEST(AdaptiveFormats, TheCurveFallsAndNoFragmentHidesItself) {
    for (const char* depth : {"float32", "unorm24", "unorm16", "float16"}) {
        for (const char* transmittance :
             {"float16", "unorm16", "unorm8", "log8", "unorm8,transmittance_rounding=down",
              "unorm8,transmittance_rounding=dithered", "log8,transmittance_rounding=dithered"}) {
            const std::string keys = fmt::format(
                "adaptive:nodes=6,image_format=float32,color_format=float32,depth_format={},"
                "transmittance_format={}",
                depth, transmittance);
            Random random(22);
            for (int pixel = 0; pixel < 20; ++pixel) {
                TestFrame frame(keys, test::header_of(1, 1), static_cast<std::uint64_t>(pixel));
                for (int i = 0; i < 20; ++i) {
                    const Fragment f = test::fragment_at(0, 0, random.real(0.5, 1), random.real(0, 0.3),
                                                         {1, 1, 1}, static_cast<std::uint32_t>(i));
                    frame.draw_pass(0, {&f, 1});
                    const auto words = frame.words(0, 0);
                    for (std::size_t j = 1; j < 6; ++j) {
                        ASSERT_LE(std::bit_cast<float>(words[j - 1]), std::bit_cast<float>(words[j])) << keys;
                        ASSERT_GE(std::bit_cast<float>(words[6 + j - 1]), std::bit_cast<float>(words[6 + j]))
                            << keys;
                    }
                }
                TestFrame one(keys, test::header_of(1, 1, 1, {0, 0, 0}));
                one.draw_one(test::fragment_at(0, 0, random.real(0, 1), 0.5f, {1, 1, 1}));
                ASSERT_EQ(one.color()[0], 0.5f) << keys;
            }
        }
    }
}

// UNORM depths give their last code to unused nodes: a fragment at the far plane takes the code before, and a
// full list does not take it for one of them and drop its transmittance.
TEST(AdaptiveFormats, AFragmentAtTheFarPlaneCounts) {
    for (const char* depth : {"float32", "unorm24", "unorm16", "float16", "unorm8"}) {
        std::vector<Fragment> fragments;
        for (int i = 0; i < 4; ++i)
            fragments.push_back(test::fragment_at(0, 0, 0.125f * static_cast<float>(i), 0.5f, {0, 0, 0}));
        fragments.push_back(test::fragment_at(0, 0, 1.0f, 0.5f, {0, 0, 0}));
        TestFrame frame(fmt::format("adaptive:nodes=4,depth_format={}", depth),
                        test::header_of(1, 1, 1, {1, 1, 1}));
        frame.draw(fragments);
        EXPECT_EQ(frame.color()[0], 0.03125f) << depth;
        EXPECT_EQ(frame.log().path_count(1), 1u) << depth << ": full";
    }
}

// Sixteen bits hold 65535 depths: fragments that a wall apart in nature share a code see each other as
// coplanar, and with the paper's rule their weights sum to more than total alpha. The merging rule keeps the
// sum of a pair right.
TEST(AdaptiveFormats, SixteenBitDepthsMakeFragmentsCoplanar) {
    const std::vector<Fragment> pair = {test::fragment_at(0, 0, 0.5f, 0.5f, {1, 1, 1}),
                                        test::fragment_at(0, 0, 0.500001f, 0.5f, {1, 1, 1})};
    const auto shade = [&](const char* keys) {
        TestFrame frame(fmt::format("adaptive:{}", keys), test::header_of(1, 1, 1, {0, 0, 0}));
        frame.draw(pair);
        return frame.color()[0];
    };
    EXPECT_EQ(shade("depth_format=float32"), 0.75f);
    EXPECT_EQ(shade("depth_format=unorm24"), 0.75f);
    EXPECT_EQ(shade("depth_format=unorm16"), 1.0f);
    EXPECT_EQ(shade("depth_format=unorm16,equal_depth=merge"), 0.75f);
    EXPECT_EQ(shade("depth_format=unorm16,composite=normalised"), 0.75f);
}

TEST(AdaptiveFormats, BitsOfAPixel) {
    EXPECT_EQ(test::storage_bits("adaptive"), 8 * 64 + 64);
    EXPECT_EQ(test::storage_bits("adaptive:depth_format=unorm24,transmittance_format=unorm8"), 8 * 32 + 64);
    EXPECT_EQ(test::storage_bits("adaptive:depth_format=unorm16,transmittance_format=log8"), 8 * 24 + 64);
    EXPECT_EQ(test::storage_bits("adaptive:depth_format=unorm16,transmittance_format=float16"), 8 * 32 + 64);
    EXPECT_EQ(test::storage_bits("adaptive:composite=normalised"), 8 * 64 + 64) << "the fourth channel";
    EXPECT_EQ(test::storage_bits("adaptive:composite=normalised", 4), 8 * 64 + 4 * 80);
}

// Where float32 keeps transmittance as computed, a rule of rounding would say nothing.
TEST(AdaptiveFormats, RoundingNeedsSomethingToRound) {
    const auto header = test::header_of(1, 1);
    EXPECT_THROW(TestFrame::make("adaptive:transmittance_rounding=down", header), UserError);
    EXPECT_THROW(TestFrame::make("adaptive:memory=variable,transmittance_format=unorm8", header), UserError);
    EXPECT_THROW(TestFrame::make("adaptive:memory=variable,layout=planar", header), UserError);
    EXPECT_FALSE(TestFrame::make("adaptive:transmittance_format=unorm8", header)->declaration().random);
    EXPECT_TRUE(
        TestFrame::make("adaptive:transmittance_format=unorm8,transmittance_rounding=dithered", header)
            ->declaration()
            .random);
}

// Normalisation divides by a sum of weights that may be nothing: no fragment, alpha of 0, alpha so small
// that the weight is none as stored, light without alpha. And it trusts total alpha: where 8 bits have
// stalled at transmittance 1, it takes the layers away.
TEST(AdaptiveNormalised, OfNothingIsNothing) {
    const auto color_of = [](const char* keys, std::span<const Fragment> fragments) {
        TestFrame frame(fmt::format("adaptive:composite=normalised,{}", keys),
                        test::header_of(1, 1, 1, {0.25f, 0.5f, 0.125f}));
        frame.draw(fragments);
        return frame.color();
    };
    const std::array<float, 3> background = {0.25f, 0.5f, 0.125f};
    for (const char* memory : {"memory=fixed", "memory=variable", "format=float32"}) {
        EXPECT_EQ(color_of(memory, {}), background);
        const std::vector<Fragment> clear = {test::fragment_at(0, 0, 0.5f, 0, {1, 1, 1})};
        EXPECT_EQ(color_of(memory, clear), background);
        Fragment light = clear[0];
        light.r = 2;
        const std::vector<Fragment> glowing = {light};
        if (std::string(memory) != "memory=variable") {  // its lists keep UNORM8
            EXPECT_EQ(color_of(memory, glowing)[0], 2.25f) << "added as it is";
        }
        for (const float alpha : {1e-12f, 1e-7f, 1e-4f}) {
            std::vector<Fragment> thin(50, test::fragment_at(0, 0, 0.5f, alpha, {1, 1, 1}));
            for (std::size_t i = 0; i < thin.size(); ++i) thin[i].z = 0.01f * static_cast<float>(i);
            for (std::size_t c = 0; c < 3; ++c)
                EXPECT_NEAR(color_of(memory, thin)[c], background[c], 0.01) << memory << " " << alpha;
        }
    }
    std::vector<Fragment> fog(100, test::fragment_at(0, 0, 0.5f, 0.0019f, {1, 1, 1}));
    for (std::size_t i = 0; i < fog.size(); ++i) fog[i].z = 0.001f * static_cast<float>(i);
    EXPECT_EQ(color_of("transmittance_format=unorm8", fog), background) << "the fog is gone";
    EXPECT_NEAR(color_of("format=float32", fog)[0], 1 - 0.75 * std::pow(1 - 0.0019, 100), 1e-5);
}

}  // namespace
}  // namespace ropsim
