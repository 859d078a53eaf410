// The stability study: its double-precision reading, its verdicts on single pixels, and the whole matrix in
// small.
#include "analysis/standard_techniques.h"
#include "analysis/stress/largest.h"
#include "analysis/stress/stress_inputs.h"
#include "analysis/stress/stress_study.h"
#include "analysis/stress/stress_variants.h"
#include "rop/double_reading/boxed_double.h"
#include "rop/double_reading/double_pixel.h"
#include "rop/single_pixel.h"

#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

TEST(BoxedDouble, FloatsAreTheirOwnBitsAndDoublesComeBack) {
    forget_boxed_doubles();
    for (const float value : {0.0f, -0.0f, 1.0f, -3.5f, 0x1p-149f, std::numeric_limits<float>::infinity()})
        EXPECT_EQ(boxed_double(static_cast<double>(value)), std::bit_cast<std::uint32_t>(value));
    EXPECT_EQ(boxed_doubles(), 0u);
    const std::vector<double> values{0.1, -1e300, 1.0 / 3, 0x1p-1000};
    std::vector<std::uint32_t> words;
    for (const double value : values) words.push_back(boxed_double(value));
    for (std::size_t i = 0; i < values.size(); ++i) {
        EXPECT_TRUE(is_boxed(words[i]));
        EXPECT_EQ(unboxed_double(words[i]), values[i]);
    }
    EXPECT_TRUE(std::isnan(unboxed_double(boxed_double(-std::numeric_limits<double>::quiet_NaN()))));
    forget_boxed_doubles();
}

PixelScene random_scene(std::uint64_t seed, int fragments) {
    std::mt19937_64 engine(seed);
    const auto unit = [&] { return static_cast<float>(static_cast<double>(engine() >> 40) * 0x1p-24); };
    PixelScene scene;
    scene.background = {unit(), unit(), unit()};
    for (int i = 0; i < fragments; ++i) {
        const float a = unit();
        scene.fragments.push_back(
            {unit(), a * unit(), a * unit(), a * unit(), a, 0, 0, static_cast<std::uint32_t>(i), 1, 0});
    }
    return scene;
}
StressInput input_of(const PixelScene& scene) {
    StressInput input = layer_input("even", 1, 0);
    input.kind = "traces";
    input.pixels = {scene};
    return input;
}

// Techniques that keep every fragment are exact compositing: what double precision leaves of the difference
// is its own rounding, 2 n of them.
TEST(DoubleReading, ExactTechniquesAreExactInDoublePrecision) {
    const TraceHeader header = layer_input("even", 1, 0).header;
    for (const char* technique : {"a_buffer:format=float32", "depth_peeling:format=float32",
                                  "dual_depth_peeling:format=float32", "k_buffer:layers=64,format=float32",
                                  "mlab:layers=64,format=float32", "hybrid:layers=64,format=float32"}) {
        const auto in_double = ropsim_double::make_single_pixel(technique, header, 0);
        const auto in_single = make_single_pixel(technique, header, 0);
        double single_error = 0;
        for (std::uint64_t seed = 0; seed < 20; ++seed) {
            const PixelScene scene = random_scene(seed, 50);
            const auto exact = exact_color(scene);
            const auto color = in_double->run(scene);
            const auto single = in_single->run(scene);
            for (std::size_t c = 0; c < 3; ++c) {
                ASSERT_NEAR(color[c], exact[c], 2 * 51 * 0x1p-52) << technique;
                single_error = std::max(single_error, std::abs(single[c] - exact[c]));
            }
        }
        EXPECT_GT(single_error, 1e-8) << technique << ": single precision is no worse";
        EXPECT_LT(single_error, 2 * 51 * 0x1p-23) << technique;
    }
}

// Weighted sums by hand, with the weights of equation 10 of McGuire and Bavoil 2013.
TEST(DoubleReading, WeightedBlendedIsItsFormula) {
    const TraceHeader header = layer_input("even", 1, 0).header;
    const auto in_double =
        ropsim_double::make_single_pixel("weighted_blended:weight=none,format=float32", header, 0);
    const PixelScene scene = random_scene(7, 40);
    std::array<double, 3> sum{};
    double alphas = 0, revealage = 1;
    for (const Fragment& f : scene.fragments) {
        sum[0] += f.r;
        sum[1] += f.g;
        sum[2] += f.b;
        alphas += f.a;
        revealage *= 1.0 - f.a;
    }
    const auto color = in_double->run(scene);
    for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(color[c],
                    sum[c] / alphas * (1 - revealage) + revealage * scene.background[static_cast<int>(c)],
                    1e-14);
}

// The state of a long list is made anew on the way, and nothing of it is lost.
TEST(DoubleReading, LongListsKeepTheirValues) {
    const TraceHeader header = layer_input("even", 1, 0).header;
    const PixelScene scene = layer_input("thin", 60'000, 3).pixels[0];
    const auto exact = exact_color(scene);
    for (const char* technique : {"a_buffer:format=float32", "adaptive:nodes=64,format=float32"}) {
        const auto color = ropsim_double::make_single_pixel(technique, header, 0)->run(scene);
        const double allowed = std::string_view(technique).starts_with("a_buffer") ? 1e-11 : 0.02;
        for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(color[c], exact[c], allowed) << technique;
    }
}

// What one pixel's verdict says of known values.
TEST(StressStudy, NaNIsTheLargestAndStays) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    double most = 1;
    take_larger(most, 0.5);
    EXPECT_EQ(most, 1);
    take_larger(most, nan);
    take_larger(most, 2);
    EXPECT_TRUE(std::isnan(most));
    EXPECT_TRUE(is_larger(std::numeric_limits<double>::infinity(), 2));
    EXPECT_FALSE(is_larger(std::numeric_limits<double>::infinity(), nan));
}

TEST(StressStudy, SeparatesRoundingFromApproximation) {
    // Two layers in the wrong order of arrival: blending is wrong and rounds by 8 bits at most.
    PixelScene scene;
    scene.background = {1, 1, 1};
    scene.fragments = {{0.25f, 0.3f, 0, 0, 0.3f, 0, 0, 0, 1, 0}, {0.75f, 0, 0.6f, 0, 0.6f, 0, 0, 1, 1, 0}};
    const StressTechnique technique = stress_techniques({"alpha_blend:color_format=unorm8"}, false).front();
    const std::vector<StressResult> results = stress_results(technique, input_of(scene), 0);
    ASSERT_EQ(results.size(), 2u);
    EXPECT_NEAR(results[0].worst_algorithm, 0.3 * 0.6, 1e-7);
    EXPECT_EQ(results[0].worst_algorithm, results[1].worst_algorithm);
    EXPECT_GT(results[0].worst_rounding, 1e-4);
    EXPECT_LE(results[0].worst_rounding, 2 * 0.5 / 255);
    EXPECT_LT(results[1].worst_rounding, 4 * 0x1p-24);
    EXPECT_EQ(results[0].faults.all(), 0u);
}

TEST(StressStudy, CountsWhatIsNoColor) {
    StressInput input = input_of(random_scene(1, 3));
    const StressTechnique technique = stress_techniques({"a_buffer"}, false).front();
    const auto faults = [&] { return stress_results(technique, input, 0)[1]; };
    EXPECT_EQ(faults().faults.all(), 0u);
    EXPECT_EQ(faults().values, 3u);
    PixelScene& pixel = input.pixels[0];
    input.physical = false;
    pixel.fragments[0].r = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(faults().faults.not_numbers, 1u);
    pixel.fragments[0].r = 0;
    input.physical = true;
    pixel.background.g = -5;
    EXPECT_EQ(faults().faults.negative, 1u);
}

// Every configuration in the paper's formats and in float32 on every stress trace and on series of layers.
TEST(StressStudy, NoTechniqueGivesWhatIsNoColor) {
    StressInputOptions options;
    options.layers = {1, 10, 100};
    options.trace_pixels = 4;
    const StressStudy study =
        run_stress_study(stress_techniques(stress_configurations(), false), stress_inputs(options), 0, 2);
    EXPECT_GT(study.measured(), 4000u);
    for (const StressResult& r : study.results) {
        const std::string name =
            study.techniques[r.technique].variants[r.variant].technique + " on " + study.inputs[r.input].name;
        const StressFaults& f = r.faults;
        EXPECT_EQ(f.not_numbers + f.infinite + f.negative, 0u) << name;
        if (r.hazard == StressHazard::kNone) {
            EXPECT_EQ(f.too_bright, 0u) << name;
        }
    }
}

// Stored formats round by no more than float32 does elsewhere: the variants are what they say.
TEST(StressVariants, CoverEveryFormatThatASurfaceTakes) {
    const std::vector<StressTechnique> techniques =
        stress_techniques({"weighted_blended", "mlab:layers=2"}, true);
    std::vector<std::string> formats;
    for (const StressVariant& v : techniques[0].variants) formats.push_back(v.formats);
    for (const char* wanted : {"paper", "float32", "color float16", "revealage unorm8", "revealage log8",
                               "revealage unorm16", "all float16"})
        EXPECT_NE(std::ranges::find(formats, wanted), formats.end()) << wanted;
    // Colours of four channels are not packed.
    EXPECT_EQ(std::ranges::find(formats, "color rgb9e5"), formats.end());
    EXPECT_EQ(techniques[0].variants[0].bits, 72);
    EXPECT_EQ(techniques[0].variants[1].bits, 160);
}

}  // namespace
}  // namespace ropsim
