// The claims' judgement on synthetic values, their list, and what chooses among them.
#include "analysis/claims/claims.h"

#include "base/error.h"

#include <algorithm>
#include <map>
#include <set>

#include <gmock/gmock.h>

namespace ropsim {
namespace {

using ::testing::HasSubstr;

bool equal(const std::string& printed, std::vector<double> ours, const Rule& by = rule::digits(),
           double noise = 0) {
    return holds(Printed::numbers_of(printed), by, {"", std::move(ours), false, noise});
}

TEST(PrintedNumbers, HaveTheirLastDigit) {
    const auto numbers = [](const std::string& text) { return Printed::numbers_of(text).numbers; };
    ASSERT_EQ(numbers("(0.10, .17, 12,870)").size(), 3u);
    EXPECT_EQ(numbers("(0.10, .17, 12,870)")[0].value, 0.1);
    EXPECT_EQ(numbers("(0.10, .17, 12,870)")[0].half, 0.005);
    EXPECT_EQ(numbers("(0.10, .17, 12,870)")[1].value, 0.17);
    EXPECT_EQ(numbers("(0.10, .17, 12,870)")[2].value, 12870);
    EXPECT_EQ(numbers("(0.10, .17, 12,870)")[2].half, 0.5);
    EXPECT_EQ(numbers("97 %")[0].half, 0.5);
    EXPECT_EQ(numbers("1.5x")[0].half, 0.05);
    EXPECT_EQ(numbers("-1/2")[0].value, -1);
    EXPECT_EQ(numbers("128-320")[1].value, 320);  // a range, not a sign
    EXPECT_EQ(numbers("1, 2, 300").size(), 3u);   // a list, not thousands
    EXPECT_EQ(numbers("ends with 3.")[0].value, 3);
}

TEST(Rules, ComparePrintedWithOwn) {
    EXPECT_TRUE(equal("1.5x", {1.45}));
    EXPECT_TRUE(equal("1.5x", {1.55}));  // an exact half may be rounded either way
    EXPECT_FALSE(equal("1.5x", {1.5500001}));
    EXPECT_FALSE(equal("1.5x", {1.4499}));
    EXPECT_TRUE(equal("0.10, 0.17", {0.104, 0.166}));
    EXPECT_FALSE(equal("0.10, 0.17", {0.104, 0.16}));  // one of them is enough
    EXPECT_TRUE(equal("1.5x", {1.56}, rule::digits(), 0.02));
    const auto by_each = [](const std::vector<double>& noises) {
        return holds(Printed::numbers_of("1.5, 2.5"), rule::digits(), {"", {1.56, 2.56}, false, 0, noises});
    };
    EXPECT_TRUE(by_each({0.02, 0.02}));
    EXPECT_FALSE(by_each({0.02, 0}));
    EXPECT_FALSE(equal("3", {3.2}, rule::exact()));
    EXPECT_TRUE(equal("3", {3}, rule::exact()));
    EXPECT_TRUE(equal("10 %", {14.9}, rule::about()));
    EXPECT_FALSE(equal("10 %", {15.1}, rule::about()));
    EXPECT_TRUE(equal("0.5", {0.46}, rule::about()));
    EXPECT_FALSE(equal("0.5", {0.44}, rule::about()));
    EXPECT_TRUE(equal("7", {7.6}, rule::within(0.1)));
    EXPECT_FALSE(equal("7", {7.8}, rule::within(0.1)));
    EXPECT_TRUE(equal("7", {7}, rule::at_least()));
    EXPECT_FALSE(equal("7", {6.99}, rule::at_least()));
    EXPECT_TRUE(equal("7", {6.99}, rule::at_most()));
    EXPECT_FALSE(equal("7", {7.01}, rule::at_most()));
    for (const Rule& by : {rule::digits(), rule::exact(), rule::about(), rule::at_least(), rule::at_most()})
        EXPECT_FALSE(equal("7", {NAN}, by)) << by.text();
}

Judgement judged(std::vector<Reading> readings, Basis basis = Basis::kDefinition) {
    Finding finding;
    finding.readings = std::move(readings);
    return judge(Printed::numbers_of("0.35"), rule::digits(), basis, finding);
}

TEST(Judgement, TakesTheFirstReadingThatHolds) {
    EXPECT_EQ(judged({{"", {0.352}}}).text(), "reproduced");
    EXPECT_EQ(judged({{"", {0.352}}, {"one sample", {0.35}}}).text(), "reproduced");
    EXPECT_EQ(judged({{"", {0.17}}, {"one sample", {0.349}}}).text(), "reproduced under one sample");
    EXPECT_EQ(judged({{"", {0.17}}, {"two", {0.2}}, {"one", {0.349}}}).text(), "reproduced under one");
    EXPECT_EQ(judged({{"", {0.17}}}).text(), "does not follow from its own definition");
}

TEST(Judgement, OfTheirSceneNeedsTheirScene) {
    EXPECT_EQ(judged({{"our scene", {0.17}}}, Basis::kAssets).text(), "not reproducible without its assets");
    EXPECT_EQ(judged({{"our scene", {0.35}}}, Basis::kAssets).text(), "reproduced under our scene");
    EXPECT_DEATH(judged({{"", {0.35}}}, Basis::kAssets), "needs to say with what");
    // Ours was made to the number: nothing is held against it.
    EXPECT_EQ(judged({}, Basis::kAssets).text(), "not reproducible without its assets");
    EXPECT_DEATH(judged({}), "nothing to hold against");
}

TEST(Judgement, OfAStatementIsTheReadings) {
    Finding finding;
    finding.readings = {{"", {}, false}, {"masks", {}, true}};
    const Printed printed = Printed::statement("never");
    EXPECT_EQ(judge(printed, rule::statement(), Basis::kDefinition, finding).text(),
              "reproduced under masks");
    finding.readings = {{"", {}, false}};
    EXPECT_EQ(judge(printed, rule::statement(), Basis::kDefinition, finding).verdict,
              Verdict::kDoesNotFollow);
}

TEST(ClaimList, SaysEverythingOfEveryClaim) {
    std::set<std::string> ids;
    std::vector<std::string> papers;
    for (const Claim& claim : all_claims()) {
        EXPECT_TRUE(ids.insert(claim.id).second) << claim.id;
        for (const std::string& text : {claim.paper, claim.place, claim.claim, claim.printed.text, claim.how})
            EXPECT_FALSE(text.empty()) << claim.id;
        EXPECT_EQ(claim.claim.find('\n'), std::string::npos) << claim.id;
        EXPECT_EQ(claim.rule.kind != Rule::Kind::kStatement && claim.printed.numbers.empty(), false)
            << claim.id;
        if (papers.empty() || papers.back() != claim.paper) papers.push_back(claim.paper);
    }
    // The page has a section a paper.
    EXPECT_EQ(std::set<std::string>(papers.begin(), papers.end()).size(), papers.size());
}

// What has been worked out about the papers' numbers elsewhere, and the row that stands for it here.
TEST(ClaimList, HasARowForEveryKnownNumber) {
    const std::multimap<std::string, std::string> rows{
        {"ST example 1, colour", "st-ex1-color"},
        {"ST example 2, background .25", "st-ex2-color"},
        {"ST R for alpha .45", "st-ex1-r"},
        {"ST example 1, naive", "st-ex1-naive"},
        {"ST example 1, stratified", "st-ex1-stratified"},
        {"ST example 1, alpha-corrected", "st-ex1-corrected"},
        {"ST example 1, depth-based", "st-ex1-depth"},
        {"ST example 1, depth and correction", "st-ex1-depth-corrected"},
        {"ST example 2, naive", "st-ex2-naive"},
        {"ST example 2, stratified", "st-ex2-stratified"},
        {"ST example 2, corrected", "st-ex2-corrected"},
        {"ST example 2, depth", "st-ex2-depth"},
        {"ST example 2, depth and correction", "st-ex2-depth-corrected"},
        {"ST E(A)", "st-bias-mean"},
        {"ST E(A) against C", "st-bias-exact"},
        {"ST about 10 %", "st-bias-percent"},
        {"ST D of two layers", "st-d-biased"},
        {"ST single thin layer", "st-empty-pixels"},
        {"ST 97 %", "st-overlap"},
        {"ST balls and bins", "st-balls-slope"},
        {"ST balls and bins, variance", "st-balls-variance"},
        {"ST number of masks", "st-mask-count"},
        {"ST passes", "st-passes"},
        {"ST passes by formula", "st-passes-formula"},
        {"ST E(B) = C", "st-unbiased"},
        {"ST E(U) = C", "st-u-unbiased"},
        {"ST D consistent", "st-d-consistent"},
        {"ST Table 1, sums", "st-table1-totals"},
        {"ST Table 1, relative", "st-table1-relative"},
        {"ST Table 1, frames", "st-table1-fps"},
        {"LK aligned spans", "lk-aligned-spans"},
        {"LK floor or ceil", "lk-nearest-share"},
        {"LK radical inverse", "lk-radical-inverse-biased"},
        {"LK hash unbiased", "lk-unbiased"},
        {"LK correlation", "lk-uncorrelated"},
        {"LK Figure 5", "lk-fig5a"},
        {"LK Figure 5", "lk-fig5b"},
        {"LK Figure 5", "lk-fig5c"},
        {"LK Figure 5", "lk-fig5d"},
        {"LK printed scramble", "lk-scrambled"},
        {"LK Table 1, ratios", "lk-table1-ratios"},
        {"LK Table 1, slopes", "lk-slope-motor"},
        {"LK Table 1, slopes", "lk-slope-cloth"},
        {"LK Table 1, errors", "lk-table1-motor-64"},
        {"LK Table 1, errors", "lk-table1-cloth-4"},
        {"LK never worse", "lk-never-worse"},
        {"LK never worse", "lk-never-worse-large"},
        {"SLAB P", "slab-p-stratified"},
        {"SLAB P, non-stratified", "slab-p-non-stratified"},
        {"SLAB limit", "slab-p-limit"},
        {"SLAB timing ratios", "time-slab-st8-st4"},
        {"SLAB timing ratios", "time-slab-mlab8-slab8"},
        {"SLAB far layer kept", "slab-same-discards"},
        {"SLAB quality", "slab-32x"},
        {"SLAB b = n", "slab-b-n"},
    };
    for (const auto& [number, id] : rows)
        EXPECT_TRUE(
            std::ranges::any_of(all_claims(), [&, wanted = id](const Claim& c) { return c.id == wanted; }))
            << number << ": " << id;
}

TEST(ChosenClaims, ByIdAndByBeginning) {
    const auto& all = all_claims();
    EXPECT_EQ(chosen_claims(all, {}).size(), all.size());
    const auto one = chosen_claims(all, {"st-passes"});
    ASSERT_EQ(one.size(), 1u);
    EXPECT_EQ(one[0]->id, "st-passes");
    const auto fig5 = chosen_claims(all, {"lk-fig5*"});
    EXPECT_EQ(fig5.size(), 4u);
    try {
        chosen_claims(all, {"st-pases"});
        ADD_FAILURE() << "no such claim";
    } catch (const UserError& error) {
        EXPECT_EQ(error.where(), "ID");
        EXPECT_THAT(error.what(), HasSubstr("near it are st-passes"));
        EXPECT_THAT(error.what(), HasSubstr("ropsim list claims"));
    }
    EXPECT_THROW(chosen_claims(all, {"nothing*"}), UserError);
}

std::map<std::string, ClaimResult> without_runs() {
    ClaimsOptions options;
    for (const Claim& claim : all_claims())
        if (!claim.simulates) options.ids.push_back(claim.id);
    options.runs.quick = true;
    std::map<std::string, ClaimResult> by_id;
    for (const ClaimResult& result : run_claims(options)) by_id[result.claim->id] = result;
    return by_id;
}

// The findings about the papers that the tests of rop/ establish by other means.
TEST(ClaimVerdicts, AreTheKnownOnes) {
    const auto results = without_runs();
    const auto verdict = [&](const char* id) { return results.at(id).judgement.verdict; };
    for (const char* id : {"st-ex1-color", "st-ex2-stratified", "st-bias-mean", "st-overlap", "st-mask-count",
                           "st-passes-formula", "st-u-unbiased", "lk-aligned-spans", "lk-unbiased",
                           "lk-radical-inverse-biased", "lk-table1-ratios", "slab-p-stratified"})
        EXPECT_EQ(verdict(id), Verdict::kReproduced) << id;
    EXPECT_EQ(verdict("slab-p-limit"), Verdict::kReproducedUnder);
    for (const char* id : {"st-ex1-stratified", "st-ex1-corrected", "st-ex1-depth", "st-ex1-depth-corrected",
                           "st-ex1-depth-harm", "st-ex2-naive", "st-ex1-naive"})
        EXPECT_EQ(verdict(id), Verdict::kDoesNotFollow) << id;
    for (const auto& [id, result] : results) {
        EXPECT_TRUE(result.failure.empty()) << id;
        EXPECT_FALSE(result.finding.why.empty()) << id;
        // Nothing here is of the kind of some of the papers' scenes.
        if (result.judgement.verdict != Verdict::kNotReproducible) {
            EXPECT_FALSE(result.finding.worst_case.empty() && result.finding.measured.empty()) << id;
        }
    }
}

}  // namespace
}  // namespace ropsim
