// How far the techniques that merge layers are from exact, on layers in random order.
#include "tests/rop/layer_lists.h"

#include <gtest/gtest.h>

namespace ropsim {
namespace {

using test::Random;
using test::TestFrame;

// 20 layers of random colour, depth and order of arrival, eight layers kept, errors in 1/255. In float32 the
// figures are those of an independent simulation (1.99, .84, .01, .24). Eight bits cost the rest, measured
// here on 100 x 100 pixels: transmittances of .9 and .7 lie half way between two steps and all round up, so
// that the image is too bright; .4 is a step.
TEST(MergingError, OfTwentyRandomLayers) {
    constexpr int kSide = 70;
    struct Row {
        float alpha;  // 0: random
        double rms8;
        double paper_rms8;
        double paper_mean8;
    };
    for (const Row& row : {Row{.1f, 1.99, 2.900, 1.957}, Row{.3f, .84, 1.269, .851}, Row{.6f, .01, .316, 0},
                           Row{0, .24, .508, 0}}) {
        Random random(206);
        const auto fragments = test::random_layers(
            kSide, 20, random, [&] { return row.alpha > 0 ? row.alpha : random.real(0, 1); });
        const auto figures = [&](const char* technique) {
            TestFrame frame(technique, test::header_of(kSide, kSide), 0, 1, false);
            frame.draw(fragments);
            return test::error_figures(frame, fragments);
        };
        const auto exact = figures("mlab:format=float32");
        EXPECT_NEAR(exact.rms8, row.rms8, 4 * exact.rms8_deviation + 0.005) << row.alpha;
        EXPECT_NEAR(exact.mean8, 0, 5 * exact.rms8 / kSide) << row.alpha;
        const auto paper = figures("mlab:image_format=float32");
        EXPECT_NEAR(paper.rms8, row.paper_rms8, 5 * paper.rms8_deviation) << row.alpha;
        EXPECT_NEAR(paper.mean8, row.paper_mean8, 5 * paper.rms8 / kSide) << row.alpha;
    }
}

// Of the rules, merging where visibility changes least errs least for random arrival, by more than half with
// eight layers; looking at depth alone, or at opacity alone, is worse than merging the last two. The rule
// that the published code carries out under the name of the opposite one is the worst of all.
TEST(MergingError, LeastErrorBeatsTheTail) {
    Random random(208);
    const auto fragments = test::random_layers(40, 32, random, [&] { return random.real(0.02, 0.3); });
    const auto rms8 = [&](const std::string& rule, int layers) {
        TestFrame frame("mlab:format=float32,merge=" + rule + ",layers=" + std::to_string(layers),
                        test::header_of(40, 40), 0, 1, false);
        frame.draw(fragments);
        return test::error_figures(frame, fragments).rms8;
    };
    EXPECT_LT(rms8("least_error", 8), 0.5 * rms8("tail", 8));
    EXPECT_LT(rms8("least_error", 4), 0.6 * rms8("tail", 4));
    EXPECT_LT(rms8("tail", 8), rms8("closest", 8));
    EXPECT_LT(rms8("closest", 8), rms8("opacity", 8));
    EXPECT_LT(rms8("opacity", 8), rms8("transmittance", 8));
}

// What a fragment adds and what it hides stay in proportion whatever is merged: white layers over white are
// white, where adaptive transparency, which drops visibility and not colour, darkens. All that AOIT loses is
// lost by truncation.
TEST(MergingError, WhiteOverWhiteIsWhiteUpToTruncation) {
    Random random(216);
    std::vector<Fragment> fragments = test::random_layers(16, 32, random, [] { return 0.15f; });
    for (Fragment& f : fragments) f.r = f.g = f.b = f.a;
    const auto expect_mean8 = [&](const std::string& technique, double mean8) {
        TestFrame frame(technique, test::header_of(16, 16, 1, {1, 1, 1}));
        frame.draw(fragments);
        const auto figures = test::error_figures(frame, fragments);
        const double deviation =
            std::sqrt(std::max(0.0, std::pow(figures.rms8, 2) - std::pow(figures.mean8, 2)));
        EXPECT_NEAR(figures.mean8, mean8, 5 * deviation / 16 + 0.001) << technique;
    };
    expect_mean8("aoit:format=float32", 0);
    expect_mean8("mlab:format=float32", 0);
    expect_mean8("mlab", 0);
    expect_mean8("aoit", -12.9);
    expect_mean8("aoit:transmittance_rounding=nearest", 1.5);
    expect_mean8("aoit:transmittance_format=unorm16", -2.0);
    expect_mean8("adaptive:nodes=8,format=float32", -35.9);
}

}  // namespace
}  // namespace ropsim
