// The two examples of Enderton et al. 2011, sections 3.1, 3.3 and 3.4, in all methods: RMS errors against the
// exact colour, enumerated over masks and pinned, and the technique's pixels against the same enumeration.
// The paper's "stratified" numbers come out with runs of neighbouring samples and not with the S-choose-R
// subsets that it describes; the tests below name what each printed number is.
#include "tests/rop/mask_outcomes.h"

namespace ropsim {
namespace {

using test::Estimate;
using test::Layer;
using test::MaskKind;

constexpr int kSamples = 4;

struct Example {
    std::vector<Layer> layers;
    std::array<double, 3> background;
};
// Red over green, both .45, over blue.
Example first_example() {
    return {{{0.45, {1, 0, 0}}, {0.45, {0, 1, 0}}}, {0, 0, 1}};
}
// Four white layers of 1/4 over 1/4.
Example second_example() {
    return {{4, {0.25, {1, 1, 1}}}, {0.25, 0.25, 0.25}};
}

std::array<test::Moments, 3> exact(const Example& e, Estimate estimate, MaskKind kind) {
    return test::exact_moments(estimate, kind, e.layers, kSamples, e.background);
}
// Root of the mean squared error: spread and bias.
std::array<double, 3> errors(const Example& e, const std::array<test::Moments, 3>& m) {
    const auto correct = test::blended(e.layers, e.background);
    std::array<double, 3> rms{};
    for (std::size_t c = 0; c < 3; ++c) rms[c] = std::hypot(m[c].deviation(), m[c].mean - correct[c]);
    return rms;
}
void expect_near(const std::array<double, 3>& got, const std::array<double, 3>& expected, double tolerance) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(got[c], expected[c], tolerance) << "channel " << c;
}

struct Row {
    Estimate estimate;
    MaskKind kind;
    std::array<double, 3> error;
};
void expect_row(const Example& e, const Row& row) {
    const std::string technique = test::technique_of(row.estimate, row.kind, kSamples);
    SCOPED_TRACE(technique);
    const auto expected = exact(e, row.estimate, row.kind);
    expect_near(errors(e, expected), row.error, 1e-6);
    const auto image =
        test::image_of_layers(technique, test::fragments_of(e.layers),
                              {static_cast<float>(e.background[0]), static_cast<float>(e.background[1]),
                               static_cast<float>(e.background[2])});
    for (std::size_t c = 0; c < 3; ++c) {
        SCOPED_TRACE("channel " + std::to_string(c));
        test::expect_moments(image, c, expected[c]);
    }
}

class FirstExample : public testing::TestWithParam<Row> {};
class SecondExample : public testing::TestWithParam<Row> {};
std::string row_name(const testing::TestParamInfo<Row>& row) {
    static constexpr std::array kEstimates = {"Basic", "Corrected", "Depth", "DepthByCoverage",
                                              "DepthByAlpha"};
    return kEstimates[static_cast<std::size_t>(row.param.estimate)] + ("_" + test::name_of(row.param.kind));
}
INSTANTIATE_TEST_SUITE_P(
    Methods, FirstExample,
    testing::Values(Row{Estimate::kBasic, MaskKind::kCoin, {0.248747, 0.215780, 0.229670}},
                    Row{Estimate::kBasic, MaskKind::kChoose, {0.100000, 0.154765, 0.157962}},
                    Row{Estimate::kBasic, MaskKind::kRun, {0.100000, 0.174982, 0.177817}},
                    Row{Estimate::kBasicCorrected, MaskKind::kCoin, {0.216807, 0.214063, 0.000000}},
                    Row{Estimate::kBasicCorrected, MaskKind::kChoose, {0.134784, 0.134784, 0.000000}},
                    Row{Estimate::kBasicCorrected, MaskKind::kRun, {0.148177, 0.148177, 0.000000}},
                    Row{Estimate::kDepth, MaskKind::kCoin, {0.000000, 0.111936, 0.229670}},
                    Row{Estimate::kDepth, MaskKind::kChoose, {0.000000, 0.045000, 0.157962}},
                    Row{Estimate::kDepth, MaskKind::kRun, {0.000000, 0.045000, 0.177817}},
                    Row{Estimate::kDepthCoverage, MaskKind::kCoin, {0.255023, 0.270239, 0.000000}},
                    Row{Estimate::kDepthCoverage, MaskKind::kChoose, {0.135721, 0.114432, 0.000000}},
                    Row{Estimate::kDepthCoverage, MaskKind::kRun, {0.144871, 0.116666, 0.000000}},
                    Row{Estimate::kDepthAccumulated, MaskKind::kCoin, {0.081628, 0.081628, 0.000000}},
                    Row{Estimate::kDepthAccumulated, MaskKind::kChoose, {0.026627, 0.026627, 0.000000}},
                    Row{Estimate::kDepthAccumulated, MaskKind::kRun, {0.026627, 0.026627, 0.000000}}),
    row_name);
INSTANTIATE_TEST_SUITE_P(
    Methods, SecondExample,
    testing::Values(Row{Estimate::kBasic, MaskKind::kCoin, {0.174403, 0.174403, 0.174403}},
                    Row{Estimate::kBasic, MaskKind::kChoose, {0.120616, 0.120616, 0.120616}},
                    Row{Estimate::kBasic, MaskKind::kRun, {0.120616, 0.120616, 0.120616}},
                    Row{Estimate::kBasicCorrected, MaskKind::kCoin, {0.068437, 0.068437, 0.068437}},
                    Row{Estimate::kBasicCorrected, MaskKind::kChoose, {0.000000, 0.000000, 0.000000}},
                    Row{Estimate::kBasicCorrected, MaskKind::kRun, {0.000000, 0.000000, 0.000000}},
                    Row{Estimate::kDepth, MaskKind::kCoin, {0.199844, 0.199844, 0.199844}},
                    Row{Estimate::kDepth, MaskKind::kChoose, {0.087122, 0.087122, 0.087122}},
                    Row{Estimate::kDepth, MaskKind::kRun, {0.087122, 0.087122, 0.087122}},
                    Row{Estimate::kDepthCoverage, MaskKind::kCoin, {0.585053, 0.585053, 0.585053}},
                    Row{Estimate::kDepthCoverage, MaskKind::kChoose, {0.281451, 0.281451, 0.281451}},
                    Row{Estimate::kDepthCoverage, MaskKind::kRun, {0.281451, 0.281451, 0.281451}},
                    Row{Estimate::kDepthAccumulated, MaskKind::kCoin, {0.000000, 0.000000, 0.000000}},
                    Row{Estimate::kDepthAccumulated, MaskKind::kChoose, {0.000000, 0.000000, 0.000000}},
                    Row{Estimate::kDepthAccumulated, MaskKind::kRun, {0.000000, 0.000000, 0.000000}}),
    row_name);

TEST_P(FirstExample, ErrorsAreTheEnumeratedOnes) {
    expect_row(first_example(), GetParam());
}
TEST_P(SecondExample, ErrorsAreTheEnumeratedOnes) {
    expect_row(second_example(), GetParam());
}

// Printed: naive (0.25, 0.21, 0.23) and stratified (0.10, 0.17, 0.18). Naive holds but for green, which
// rounds to 0.22. Stratified is that of runs; S-choose-R subsets give (0.1000, 0.1548, 0.1580).
TEST(PrintedErrors, OfTheBasicMethodInExample1) {
    const Example e = first_example();
    expect_near(errors(e, exact(e, Estimate::kBasic, MaskKind::kCoin)), {0.25, 0.2158, 0.23}, 0.005);
    expect_near(errors(e, exact(e, Estimate::kBasic, MaskKind::kRun)), {0.10, 0.17, 0.18}, 0.00501);
    EXPECT_GT(0.17 - errors(e, exact(e, Estimate::kBasic, MaskKind::kChoose))[1], 0.015);
}

// Printed: (0.17, 0.14, 0). Impossible by 4.1: A's red and green add up to total alpha whatever the masks, so
// that their spreads are equal, and, total alpha being exact, their biases opposite. Run masks corrected to
// an alpha of .45, one layer's, instead of total alpha, .6975, would give the printed numbers.
TEST(PrintedErrors, OfAlphaCorrectionInExample1) {
    const Example e = first_example();
    for (const MaskKind kind : {MaskKind::kChoose, MaskKind::kRun}) {
        test::for_masks(kind, e.layers, kSamples, [&](const std::vector<std::uint32_t>& masks, double) {
            const auto a = test::estimated(Estimate::kBasicCorrected, e.layers, masks, kSamples, {0, 0, 0},
                                           test::total_alpha(e.layers));
            EXPECT_NEAR(a[0] + a[1], 0.6975, 1e-12);
        });
        const auto rms = errors(e, exact(e, Estimate::kBasicCorrected, kind));
        EXPECT_NEAR(rms[0], rms[1], 1e-12);
    }
    const auto by_one_layer = test::exact_moments(Estimate::kBasicCorrected, MaskKind::kRun, e.layers,
                                                  kSamples, e.background, 0.45);
    expect_near(errors(e, by_one_layer), {0.17, 0.14, 0}, 0.005);
}

// Printed: (0, 0.05, 0.18) without correction: runs, in blue. Printed: (0.14, 0.12, 0) with it, "more harm
// than good": runs, and U divided by F(B1) (red, 0.1449, rounds to it). Divided by U1, as 4.2 has it, either
// kind of mask gives (0.027, 0.027, 0), five times better; only red is then worse than uncorrected.
TEST(PrintedErrors, OfTheDepthBasedMethodInExample1) {
    const Example e = first_example();
    expect_near(errors(e, exact(e, Estimate::kDepth, MaskKind::kRun)), {0, 0.05, 0.18}, 0.00501);
    expect_near(errors(e, exact(e, Estimate::kDepthCoverage, MaskKind::kRun)), {0.14, 0.12, 0}, 0.005);
    for (const MaskKind kind : {MaskKind::kChoose, MaskKind::kRun})
        expect_near(errors(e, exact(e, Estimate::kDepthAccumulated, kind)), {0.0266, 0.0266, 0}, 5e-5);
}

// Printed: naive 0.35, which is one sample's, 4 give 0.174; stratified 0.12; corrected 0; depth-based 0.08,
// where the value is 0.0871; depth-based and corrected 0.
TEST(PrintedErrors, OfExample2) {
    const Example e = second_example();
    const auto one_sample = test::exact_moments(Estimate::kBasic, MaskKind::kCoin, e.layers, 1, e.background);
    EXPECT_NEAR(one_sample[0].deviation(), 0.35, 0.005);
    EXPECT_NEAR(exact(e, Estimate::kBasic, MaskKind::kCoin)[0].deviation(), 0.174, 5e-4);
    for (const MaskKind kind : {MaskKind::kChoose, MaskKind::kRun}) {
        EXPECT_NEAR(exact(e, Estimate::kBasic, kind)[0].deviation(), 0.12, 0.005);
        EXPECT_NEAR(exact(e, Estimate::kBasicCorrected, kind)[0].deviation(), 0, 1e-12);
        EXPECT_NEAR(exact(e, Estimate::kDepth, kind)[0].deviation(), 0.0871, 5e-5);
        EXPECT_NEAR(exact(e, Estimate::kDepthAccumulated, kind)[0].deviation(), 0, 1e-12);
    }
    // The single sample of naive transparency, by the technique.
    const auto m = one_sample[0];
    test::expect_moments(test::technique_of(Estimate::kBasic, MaskKind::kCoin, 1),
                         test::fragments_of(e.layers), glm::vec3(0.25f), 0, m);
}

}  // namespace
}  // namespace ropsim
