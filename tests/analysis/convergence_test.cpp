// Convergence studies: the fit against textbooks and hand computation, errors against their closed form.
#include "analysis/convergence.h"

#include "analysis/convergence_output.h"
#include "base/error.h"
#include "tests/traces/scratch.h"
#include "traces/generators.h"

#include <cmath>
#include <cstdlib>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

using testing::HasSubstr;

std::vector<Replicates> single_points(const std::vector<double>& x, const std::vector<double>& y) {
    std::vector<Replicates> points;
    for (std::size_t i = 0; i < x.size(); ++i) points.push_back({x[i], {y[i]}});
    return points;
}

// The usual printed table of the 97.5% points.
TEST(ConvergenceFit, StudentsTIsThatOfTheTables) {
    const std::vector<std::pair<int, double>> table = {{1, 12.706205}, {2, 4.302653},  {3, 3.182446},
                                                       {4, 2.776445},  {5, 2.570582},  {10, 2.228139},
                                                       {13, 2.160369}, {30, 2.042272}, {1000, 1.962339}};
    for (const auto& [degrees, t] : table) EXPECT_NEAR(student_t95(degrees), t, 1e-6) << degrees;
}

// Anscombe 1973, data set 1: every textbook prints slope 0.500 with standard error 0.118; R's confint() gives
// 0.2333701 to 0.7668117.
TEST(ConvergenceFit, AnscombesFirstSet) {
    const LineFit fit =
        fit_line(single_points({10, 8, 13, 9, 11, 14, 6, 4, 12, 7, 5},
                               {8.04, 6.95, 7.58, 8.81, 8.33, 9.96, 7.24, 4.26, 10.84, 4.82, 5.68}));
    EXPECT_FALSE(fit.from_replicates);
    EXPECT_EQ(fit.degrees_of_freedom, 9);
    EXPECT_NEAR(fit.slope, 0.5000909, 1e-7);
    EXPECT_NEAR(fit.intercept, 3.0000909, 1e-7);
    EXPECT_NEAR(fit.slope - fit.slope_half_width, 0.2333701, 1e-6);
    EXPECT_NEAR(fit.slope + fit.slope_half_width, 0.7668117, 1e-6);
}

// Mass against height of 15 women (the usual worked example): slope 61.272 kg/m, 95% from 57.4 to 65.1.
TEST(ConvergenceFit, HeightsAndMasses) {
    const LineFit fit = fit_line(single_points(
        {1.47, 1.50, 1.52, 1.55, 1.57, 1.60, 1.63, 1.65, 1.68, 1.70, 1.73, 1.75, 1.78, 1.80, 1.83},
        {52.21, 53.12, 54.48, 55.84, 57.20, 58.57, 59.93, 61.29, 63.11, 64.47, 66.28, 68.10, 69.92, 72.19,
         74.46}));
    EXPECT_NEAR(fit.slope, 61.272, 5e-4);
    EXPECT_NEAR(fit.intercept, -39.062, 5e-4);
    EXPECT_NEAR(fit.slope - fit.slope_half_width, 57.4, 0.05);
    EXPECT_NEAR(fit.slope + fit.slope_half_width, 65.1, 0.05);
}

// By hand: means 1.5, 3.5, 5; sum of (x - 2) y is 7, of (x - 2)^2 is 4, so the slope is 7/4. About the means
// remain 0.5 + 0.5 + 2 = 3 on 6 - 3 degrees of freedom: variance 1, standard error sqrt(1/4), t 3.182446.
TEST(ConvergenceFit, ReplicatesGiveTheIntervalOfTheirScatter) {
    const LineFit fit = fit_line({{1, {1, 2}}, {2, {3, 4}}, {3, {4, 6}}});
    EXPECT_TRUE(fit.from_replicates);
    EXPECT_EQ(fit.degrees_of_freedom, 3);
    EXPECT_NEAR(fit.slope, 1.75, 1e-12);
    EXPECT_NEAR(fit.intercept, 10.0 / 3 - 3.5, 1e-12);
    EXPECT_NEAR(fit.slope_half_width, 3.182446 / 2, 1e-6);
}

TEST(ConvergenceFit, APowerLawIsFoundExactly) {
    std::vector<Replicates> errors;
    for (const double s : {4, 8, 32, 64}) errors.push_back({s, {30 / std::sqrt(s)}});
    for (const int seeds : {1, 3}) {
        for (Replicates& e : errors) e.y.resize(static_cast<std::size_t>(seeds), e.y[0]);
        const PowerLawFit fit = fit_power_law("samples", errors);
        ASSERT_TRUE(fit.law);
        EXPECT_EQ(fit.why_not, "");
        EXPECT_EQ(fit.law->line.from_replicates, seeds > 1);
        EXPECT_NEAR(fit.law->line.slope, -0.5, 1e-14);
        EXPECT_NEAR(fit.law->line.slope_half_width, 0, 1e-13);
        EXPECT_NEAR(fit.law->coefficient, 30, 1e-12);
        EXPECT_NEAR(fit.law->largest_departure_percent, 0, 1e-11);
    }
    // The middle one of three, twice too high: the line is raised by a third of log 2 and keeps its slope.
    const PowerLawFit bent = fit_power_law("samples", {{2, {8}}, {4, {8}}, {8, {2}}});
    EXPECT_NEAR(bent.law->line.slope, -1, 1e-14);
    EXPECT_NEAR(bent.law->largest_departure_percent, 100 * (std::pow(2, 2.0 / 3) - 1), 1e-9);
}

TEST(ConvergenceFit, SaysWhyThereIsNoSlope) {
    const PowerLawFit two = fit_power_law("samples", {{4, {2}}, {8, {1}}});
    EXPECT_FALSE(two.law);
    EXPECT_EQ(two.why_not, "2 values of samples; a slope needs 3");
    const PowerLawFit zero = fit_power_law("nodes", {{4, {2, 2}}, {8, {1, 0}}, {16, {.5, .5}}});
    EXPECT_FALSE(zero.law);
    EXPECT_EQ(zero.why_not, "the error is 0 at nodes=8, which has no logarithm");
}

TEST(ConvergenceFit, RatiosArePairedBySeed) {
    const auto ratio = paired_ratio({2, 6}, {4, 8});
    ASSERT_TRUE(ratio);
    EXPECT_DOUBLE_EQ(ratio->mean, (0.5 + 0.75) / 2);
    EXPECT_DOUBLE_EQ(*ratio->sd, 0.25 / std::sqrt(2));
    // One without randomness stands against every seed.
    EXPECT_DOUBLE_EQ(paired_ratio({3}, {1, 3})->mean, 2);
    EXPECT_DOUBLE_EQ(paired_ratio({1, 3}, {2})->mean, 1);
    EXPECT_FALSE(paired_ratio({3}, {1})->sd);
    EXPECT_FALSE(paired_ratio({1, 3}, {2, 0}));
}

class ConvergenceStudy : public ScratchTest {
 protected:
    void SetUp() override {
        ScratchTest::SetUp();
        ASSERT_EQ(setenv("XDG_CACHE_HOME", path("cache").c_str(), 1), 0);
    }
    // White layers of alpha 1/2 over black in every pixel of a square.
    ConvergenceOptions layers(int side, int count) {
        TraceHeader header;
        header.width = side;
        header.height = side;
        header.draws.resize(1);
        std::vector<Fragment> fragments;
        for (int layer = 0; layer < count; ++layer)
            for (int y = 0; y < side; ++y)
                for (int x = 0; x < side; ++x) {
                    Fragment f{};
                    f.x = static_cast<std::uint16_t>(x);
                    f.y = static_cast<std::uint16_t>(y);
                    f.z = 0.25f * static_cast<float>(1 + layer);
                    f.r = f.g = f.b = f.a = 0.5f;
                    f.coverage = 1;
                    f.primitive = static_cast<std::uint32_t>(fragments.size());
                    fragments.push_back(f);
                }
        write_trace(path("trace"), header, fragments);
        ConvergenceOptions options;
        options.trace = path("trace");
        options.techniques = {"stochastic:format=float32"};
        options.values = {"4", "8", "16", "32"};
        return options;
    }
};

// Each of two layers takes S/2 of S samples, a uniformly random half. The samples that neither takes follow
// the hypergeometric law of S/2 draws from S with S/2 marked: variance (S/2)(1/2)(1/2)(S/2)/(S-1). Over S^2
// that is 1/(16(S-1)): the RMSE is 255/4 (S-1)^-1/2.
TEST_F(ConvergenceStudy, TwoRandomHalvesHaveTheHypergeometricError) {
    constexpr int kSide = 96;
    const Convergence study = run_convergence(layers(kSide, 2));
    const ConvergenceOfTechnique& technique = study.techniques.at(0);
    EXPECT_TRUE(technique.random);
    std::vector<Replicates> expected;
    // A squared error has a relative variance of at most 2 (the law's kurtosis is at most 3).
    const double points = 4.0 * kSide * kSide;
    for (const ConvergenceAtValue& at : technique.values) {
        double square = 0;
        for (const ConvergenceRun& run : at.runs) {
            square += run.rmse8 * run.rmse8 / 4;
            EXPECT_DOUBLE_EQ(run.rmse8_covered, run.rmse8);
        }
        ASSERT_EQ(at.runs.size(), 4u);
        const double exact = 255.0 * 255.0 / (16 * (at.value - 1));
        EXPECT_NEAR(square, exact, 5 * std::sqrt(2 / points) * exact) << at.text;
        // Without bias: the mean's standard deviation is the RMSE's over the points.
        EXPECT_NEAR(mean_sd(at.all(&ConvergenceRun::mean_signed8)).mean, 0, 5 * std::sqrt(exact / points));
        expected.push_back({at.value, {std::sqrt(exact)}});
    }
    ASSERT_TRUE(technique.fit.law);
    const LineFit line = technique.fit.law->line;
    const double slope = fit_power_law("samples", expected).law->line.slope;
    EXPECT_NEAR(slope, -0.560, 5e-4);  // steeper than -1/2 by the -1 in S-1
    // A logarithm of an RMSE has half the relative standard deviation of its square; the squares about the
    // mean of the logarithms of 4, 8, 16, 32 sum to 5 log(2)^2.
    const double deviation = 0.5 * std::sqrt(2 / points / 5) / std::log(2.0);
    EXPECT_NEAR(line.slope, slope, 5 * deviation);
    EXPECT_NEAR(line.slope, slope, line.slope_half_width);  // 19 of 20 sets of seeds do; this one is fixed
    EXPECT_EQ(line.degrees_of_freedom, 12);
    // t times a standard deviation estimated with 12 degrees of freedom: chi-squared within (1.3, 40) but for
    // 1e-4.
    EXPECT_GT(line.slope_half_width, 2.179 * deviation * std::sqrt(1.3 / 12));
    EXPECT_LT(line.slope_half_width, 2.179 * deviation * std::sqrt(40.0 / 12));
}

TEST_F(ConvergenceStudy, AnErrorOfZeroHasNoSlope) {
    // S/2 of S samples of one layer: always the exact alpha.
    const Convergence study = run_convergence(layers(8, 1));
    const ConvergenceOfTechnique& technique = study.techniques.at(0);
    EXPECT_EQ(technique.values[0].runs[0].rmse8, 0);
    EXPECT_FALSE(technique.fit.law);
    EXPECT_THAT(technique.fit.why_not, HasSubstr("error is 0 at samples=4"));
    const auto json = nlohmann::json::parse(convergence_json(study, false));
    EXPECT_TRUE(json["techniques"][0]["fit"]["slope"].is_null());
    EXPECT_EQ(json["techniques"][0]["fit"]["why_null"], technique.fit.why_not);
    EXPECT_TRUE(json["plot"].is_null());
    EXPECT_THAT(convergence_table(study), HasSubstr("no slope: the error is 0"));
}

TEST_F(ConvergenceStudy, TechniquesAreSetAgainstTheFirst) {
    RandomFragments random;
    random.width = random.height = 24;
    random.count = 1728;
    write_trace(path("random"), random_header(random), random_fragments(random));
    ConvergenceOptions options;
    options.trace = path("random");
    options.techniques = {"laine_karras", "stochastic"};
    options.values = {"16", "4", "8"};
    options.seeds = 2;
    const Convergence study = run_convergence(options);
    ASSERT_EQ(study.techniques.size(), 2u);
    EXPECT_EQ(study.fragments, random.count);
    for (std::size_t v = 0; v < 3; ++v) {
        const ConvergenceAtValue& first = study.techniques[0].values[v];
        const ConvergenceAtValue& second = study.techniques[1].values[v];
        EXPECT_EQ(first.value, 4 << v);
        EXPECT_FALSE(first.ratio);
        ASSERT_TRUE(second.ratio);
        ASSERT_EQ(second.runs.size(), 2u);
        EXPECT_EQ(second.runs[1].seed, 2u);
        EXPECT_NE(second.runs[0].rmse8, second.runs[1].rmse8);
        EXPECT_DOUBLE_EQ(
            second.ratio->mean,
            (second.runs[0].rmse8 / first.runs[0].rmse8 + second.runs[1].rmse8 / first.runs[1].rmse8) / 2);
        // Depth 32 bits and colour 32 bits a sample; the other's tracking has a bit a sample and 32 more.
        EXPECT_EQ(second.storage_bits_per_pixel, 64 * (4 << v));
        EXPECT_EQ(first.storage_bits_per_pixel, 65 * (4 << v) + 32);
        EXPECT_GE(second.runs[0].worst_case_bytes_per_fragment, second.runs[0].touched_bytes_per_fragment);
        EXPECT_GT(second.runs[0].touched_bytes_per_fragment, 0);
    }
    EXPECT_EQ(study.techniques[0].parameters.count("samples"), 0u);
    EXPECT_EQ(study.techniques[0].parameters.at("format"), "\"paper\"");
    options.threads = 3;
    EXPECT_EQ(convergence_json(run_convergence(options), true), convergence_json(study, true));
}

TEST_F(ConvergenceStudy, OneSeedWithoutRandomness) {
    ConvergenceOptions options = layers(8, 3);
    options.techniques = {"adaptive"};
    options.key = "nodes";
    options.values = {"2", "3"};
    const Convergence study = run_convergence(options);
    EXPECT_FALSE(study.techniques[0].random);
    EXPECT_EQ(study.techniques[0].values[0].runs.size(), 1u);
    EXPECT_THAT(convergence_csv(study), HasSubstr("\nadaptive,nodes,2,1,"));
    EXPECT_THAT(convergence_table(study), HasSubstr("no slope"));
}

TEST_F(ConvergenceStudy, RefusesWhatCannotBeSwept) {
    const ConvergenceOptions good = layers(8, 1);
    EXPECT_NO_THROW(check_convergence(good));
    const auto refused = [&](auto change, const std::vector<std::string>& words) {
        ConvergenceOptions options = good;
        change(options);
        try {
            check_convergence(options);
            ADD_FAILURE() << words[0];
        } catch (const UserError& error) {
            for (const std::string& word : words)
                EXPECT_THAT(error.where() + ": " + error.what(), HasSubstr(word));
        }
    };
    refused([](auto& o) { o.techniques = {"stochastic:samples=8"}; },
            {"stochastic:samples=8", "leave it out"});
    refused([](auto& o) { o.techniques = {"stochastic", "stochastic"}; }, {"stochastic", "twice"});
    refused([](auto& o) { o.techniques = {"stochastik"}; }, {"stochastik"});
    refused([](auto& o) { o.techniques = {"alpha_blend"}; }, {"alpha_blend:samples=4", "no such key"});
    refused([](auto& o) { o.key = "sampels"; }, {"sampels", "samples"});
    refused([](auto& o) { o.values = {"4", "65"}; }, {"stochastic:format=float32,samples=65", "1 to 64"});
    refused([](auto& o) { o.values = {"4", "2.5"}; }, {"samples=2.5", "integer"});
    for (const char* bad : {"four", "4x", "", "0", "-4", "inf", "nan", "1e999"})
        refused([&](auto& o) { o.values = {"4", bad}; }, {"--values", fmt::format("'{}'", bad)});
    refused([](auto& o) { o.values = {"4", "4.0"}; }, {"--values", "twice"});
    refused([&](auto& o) { o.trace = path("none"); }, {path("none")});
}

}  // namespace
}  // namespace ropsim
