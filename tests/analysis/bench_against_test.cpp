// Regressions told from noise: false alarms and detection at computed rates, and what else a baseline shows.
#include "analysis/bench/against.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "tests/traces/scratch.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace ropsim {
namespace {

using testing::HasSubstr;

constexpr int kRounds = 20000;

// Shares of the verdicts over many pairs of benchmarks, whose times differ by noise and the factor.
struct Rates {
    double regressed = 0, improved = 0;
};
Rates rates(std::size_t n, std::size_t m, double factor, double sigma, double least) {
    std::mt19937_64 random(n * 100 + m);
    std::lognormal_distribution<double> noise(0, sigma);
    Rates r;
    for (int round = 0; round < kRounds; ++round) {
        std::vector<double> then(n);
        std::vector<double> now(m);
        for (double& v : then) v = 3 * noise(random);
        for (double& v : now) v = 3 * factor * noise(random);
        const SpeedVerdict verdict = compare_speeds(then, now, {0.99, least}).verdict;
        r.regressed += verdict == SpeedVerdict::kRegressed ? 1.0 / kRounds : 0;
        r.improved += verdict == SpeedVerdict::kImproved ? 1.0 / kRounds : 0;
    }
    return r;
}

double binomial_sigma(double share) {
    return std::sqrt(share * (1 - share) / kRounds);
}

TEST(AgainstSpeeds, FalseAlarmsComeAtTheStatedRate) {
    // All five above all five: one order of 252.
    const Rates five = rates(5, 5, 1, 0.03, 0);
    EXPECT_NEAR(five.regressed, 1.0 / 252, 4 * binomial_sigma(1.0 / 252));
    EXPECT_NEAR(five.improved, 1.0 / 252, 4 * binomial_sigma(1.0 / 252));
    const Rates seven = rates(7, 7, 1, 0.03, 0);
    EXPECT_LE(seven.regressed + seven.improved, 0.01 + 4 * binomial_sigma(0.01));
    EXPECT_GT(seven.regressed + seven.improved, 0.005);  // and not much more careful than stated
    // A change of just the least effect is the edge of what is no regression.
    const Rates edge = rates(5, 5, 1.05, 0.03, 0.05);
    EXPECT_NEAR(edge.regressed, 1.0 / 252, 4 * binomial_sigma(1.0 / 252));
    EXPECT_LE(rates(5, 5, 1, 0.03, 0.05).regressed, 1e-3);
}

// P(the least of five normal values > the largest of five others + distance), by quadrature.
double all_above(double distance) {
    const auto below = [](double x) { return std::erfc(-x / std::numbers::sqrt2) / 2; };
    double sum = 0;
    constexpr double kStep = 1e-3;
    for (double x = -8; x < 8; x += kStep) {
        const double density = std::exp(-x * x / 2) / std::sqrt(2 * std::numbers::pi);
        sum += 5 * density * std::pow(below(x), 4) * std::pow(1 - below(x + distance), 5) * kStep;
    }
    return sum;
}

TEST(AgainstSpeeds, ASlowdownOfAFifthIsFound) {
    for (const double sigma : {0.02, 0.04, 0.08}) {
        const double expected = all_above((std::log(1.05) - std::log(1.2)) / sigma);
        EXPECT_NEAR(rates(5, 5, 1.2, sigma, 0.05).regressed, expected, 4 * binomial_sigma(expected) + 1e-4)
            << sigma;
    }
    EXPECT_GT(rates(5, 5, 1.2, 0.02, 0.05).regressed, 0.999);
    EXPECT_GT(rates(5, 5, 1 / 1.2, 0.02, 0.05).improved, 0.999);
}

TEST(AgainstSpeeds, TooFewRepeatsDecideNothing) {
    EXPECT_EQ(compare_speeds({1, 1, 1}, {9, 9, 9}, {}).verdict, SpeedVerdict::kUndecided);
}

Baseline baseline() {
    return {"0.1.0",
            "a processor",
            {{"same", "h", {1, 1.01, 0.99, 1.02, 0.98}, {{"cycles", 100}}},
             {"slower", "h", {1, 1.01, 0.99, 1.02, 0.98}, {}},
             {"faster", "h", {1, 1.01, 0.99, 1.02, 0.98}, {}},
             {"changed", "h", {}, {{"cycles", 100}, {"rmse8", 0.1}}},
             {"trace", "h", {1, 1, 1, 1, 1}, {{"cycles", 1}}},
             {"gone", "h", {}, {}}}};
}

Baseline later() {
    Baseline now = baseline();
    for (double& v : now.entries[1].speed) v *= 1.2;
    for (double& v : now.entries[2].speed) v /= 1.2;
    now.entries[3].values["cycles"] = 101;
    now.entries[4] = {"trace", "other", {9, 9, 9, 9, 9}, {{"cycles", 2}}};
    now.entries[5].id = "new";
    return now;
}

TEST(Against, EachCaseHasItsVerdict) {
    const Against against = compare_baselines(baseline(), later(), {});
    std::vector<SpeedVerdict> verdicts;
    for (const AgainstRow& row : against.rows) verdicts.push_back(row.verdict);
    EXPECT_THAT(verdicts,
                testing::ElementsAre(SpeedVerdict::kSame, SpeedVerdict::kRegressed, SpeedVerdict::kImproved,
                                     SpeedVerdict::kChanged, SpeedVerdict::kOtherTrace));
    EXPECT_EQ(against.only_then, 1u);
    EXPECT_EQ(against.only_now, 1u);
    EXPECT_NEAR(against.rows[1].ratio->estimate, 1.2, 1e-12);
    EXPECT_EQ(against.rows[3].changed, "cycles 100 -> 101");
    const std::string table = against_table(against);
    for (const char* word : {"slower", "regressed", "1.200", "improved", "cycles 100 -> 101", "1 only there"})
        EXPECT_THAT(table, HasSubstr(word));
    EXPECT_THAT(against_failure(against), HasSubstr("1 cases are slower and 1 have other results"));
}

TEST(Against, AValueThatIsLostOrNewHasChanged) {
    Baseline now = later();
    now.entries[3].values = {{"cycles", 100}, {"pin bytes", 7}};
    const Against against = compare_baselines(baseline(), now, {});
    EXPECT_EQ(against.rows[3].verdict, SpeedVerdict::kChanged);
    EXPECT_EQ(against.rows[3].changed, "pin bytes none -> 7, rmse8 0.1 -> none");
}

TEST(Against, OnAnotherProcessorSpeedIsNotJudged) {
    Baseline now = later();
    now.processor = "another";
    now.entries[3].values["cycles"] = 100;
    const Against against = compare_baselines(baseline(), now, {});
    EXPECT_EQ(against.count(SpeedVerdict::kRegressed), 1u);
    EXPECT_EQ(against_failure(against), "");
    EXPECT_THAT(against_table(against), HasSubstr("not judged"));
    // What depends on the inputs alone is the same everywhere.
    now.entries[3].values["cycles"] = 99;
    EXPECT_NE(against_failure(compare_baselines(baseline(), now, {})), "");
}

class BaselineFiles : public ScratchTest {};

TEST_F(BaselineFiles, ComeBackAsTheyWere) {
    Baseline written = later();
    written.entries[0].values["rmse8"] = 0.1234567890123456;
    write_file(path("baseline.json"), baseline_json(written));
    const Baseline read = read_baseline(path("baseline.json"));
    EXPECT_EQ(read.processor, written.processor);
    ASSERT_EQ(read.entries.size(), written.entries.size());
    EXPECT_EQ(read.entries[0].values, written.entries[0].values);  // to the last bit
    EXPECT_EQ(read.entries[4].trace_hash, "other");
    for (std::size_t i = 0; i < 5; ++i)
        EXPECT_NEAR(read.entries[1].speed[i] / written.entries[1].speed[i], 1, 1e-3);
    EXPECT_EQ(compare_baselines(read, read, {}).count(SpeedVerdict::kSame), written.entries.size());
}

TEST_F(BaselineFiles, OthersAreRefused) {
    for (const char* text :
         {"", "{", "[]", "{\"kind\": \"other\"}", R"({"kind": "ropsim bench baseline", "ropsim": "1"})",
          R"({"kind": "ropsim bench baseline", "ropsim": "1", "processor": "p", "entries": [{"id": 3}]})",
          R"({"kind": "ropsim bench baseline", "ropsim": "1", "processor": "p", "entries": [{"id": "a",)"
          R"( "trace_hash": "h", "speed": [0, 1], "values": {}}]})"}) {
        write_file(path("bad"), text);
        EXPECT_THROW(read_baseline(path("bad")), UserError) << text;
    }
    EXPECT_THROW(read_baseline(path("missing")), UserError);
}

}  // namespace
}  // namespace ropsim
