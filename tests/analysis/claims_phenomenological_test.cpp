// Claims of phenomenological transparency against values derived by hand.
#include "analysis/claims/claims.h"
#include "base/temporary_directory.h"

#include <cmath>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

namespace ropsim {
namespace {

const Claim& claim_of(const std::string& id) {
    for (const Claim& claim : all_claims())
        if (claim.id == id) return claim;
    throw std::runtime_error("no claim " + id);
}

constexpr const char* kDoesNotFollow = "does not follow from its own definition";

struct Judged {
    Finding finding;
    std::string verdict;
    // Of the reading of that name.
    double value(const std::string& name) const {
        for (const Reading& reading : finding.readings)
            if (reading.name == name) return reading.values.at(0);
        throw std::runtime_error("no reading " + name);
    }
};
// Of a claim that needs no runs.
Judged judged(const std::string& id) {
    const Claim& claim = claim_of(id);
    EXPECT_FALSE(claim.simulates) << id;
    ClaimRuns runs({});
    Judged result{claim.measure(runs), {}};
    result.verdict = judge(claim.printed, claim.rule, claim.basis, result.finding).text();
    return result;
}

TEST(PhenomenologicalClaims, Bits) {
    EXPECT_EQ(judged("mm-112").finding.worst_case.at(0), 4 * 16 + 4 * 8 + 2 * 8);
    EXPECT_EQ(judged("mm-88").finding.worst_case,
              (std::vector<double>{4 * 16 + 3 * 8, 4 * 16 + 8 + 2 * 8}));  // without RT2 and D; as form=alpha
    EXPECT_EQ(judged("mm-128").finding.worst_case.at(0), 4 * 16 + 4 * 8 + 4 * 8);
    EXPECT_EQ(judged("mm-256").finding.worst_case.at(0), 4 * 64);
    for (const char* id :
         {"mm-112", "mm-128", "mm-256", "mm-table2-rt0", "mm-table2-rt1", "mm-table2-rt2", "mm-one-pass",
          "mm-any-order", "mm-one-fetch", "mm-single-fetch", "mm-vsm-bits", "mm-vsm-size", "mm-tent-passes"})
        EXPECT_EQ(judged(id).verdict, "reproduced") << id;
    EXPECT_EQ(judged("mm-88").verdict,
              "reproduced under neither RT2 nor D, as alpha alone needs: RGBA16F and RGB8");
    EXPECT_EQ(judged("mm-128-320").finding.worst_case, (std::vector<double>{2 * 64 + 32, 5 * 64 + 32}));
    EXPECT_EQ(judged("mm-128-320").verdict, "reproduced under 64 bits a layer, 2 to 5 layers, no count");
}

// 320 / 88 and the quotients by 112; without runs what is measured is missing, the verdict is not.
TEST(PhenomenologicalClaims, QuotientsOfStorage) {
    const auto verdict = [](const std::string& id, std::vector<double> worst_case) {
        const Claim& claim = claim_of(id);
        ClaimRuns runs({});
        const Finding finding = claim.measure(runs);
        EXPECT_EQ(finding.worst_case.size(), worst_case.size());
        for (std::size_t i = 0; i < worst_case.size(); ++i)
            EXPECT_NEAR(finding.worst_case.at(i), worst_case[i], 1e-12) << id;
        return judge(claim.printed, claim.rule, claim.basis, finding).text();
    };
    EXPECT_EQ(verdict("mm-3.6x", {320 / 88.0}), "reproduced under the 320 bits of its own sentence");
    EXPECT_EQ(verdict("mm-2-3x", {256 / 112.0, 320 / 112.0}),
              "reproduced under the larger storages of its sentence, 256 and 320 bits");
    EXPECT_EQ(verdict("mm-2x-abstract", {64 / 28.0}),
              "reproduced under worst-case bytes against MLAB of 4 layers");
    EXPECT_NEAR(judged("mm-strictly-storage").finding.worst_case.at(0), 128 / 112.0, 1e-12);
}

TEST(PhenomenologicalClaims, Listings) {
    EXPECT_NEAR(judged("mm-beta-third").value(""), 2.0 / 3, 1e-6);
    EXPECT_EQ(judged("mm-beta-third").verdict,
              "reproduced under equation 2, without Listing 1's factor of 1/3");
    EXPECT_GT(judged("mm-eq9").value(""), 1);
    EXPECT_EQ(judged("mm-eq9").verdict, "reproduced under Snell's law in equation 9's place");
    // Equation 7's factor: gap / (k1 + gap), which far behind is 1.
    EXPECT_NEAR(judged("mm-hand").value(""), 0.02 / 0.52, 1e-3);
    EXPECT_NEAR(judged("mm-hand").value("Listing 1's k1"), 0.02 / 0.07, 1e-3);
    EXPECT_EQ(judged("mm-hand").verdict, "reproduced");
    EXPECT_EQ(judged("mm-k1").verdict, kDoesNotFollow);
    EXPECT_EQ(judged("mm-clear-frosted").verdict, "reproduced under alpha, as equations 6 and 7 have it");
    EXPECT_NEAR(judged("mm-deviations-add").value(""), std::sqrt(4.0), 1e-6);
    EXPECT_EQ(judged("mm-deviations-add").verdict, kDoesNotFollow);
}

TEST(PhenomenologicalClaims, Precision) {
    EXPECT_NEAR(judged("mm-half-pixel-refraction").value(""), 63 / 127.0, 1e-6);
    EXPECT_EQ(judged("mm-half-pixel-refraction").verdict, "reproduced");
    EXPECT_NEAR(judged("mm-half-pixel-diffusion").value(""), 63 / std::sqrt(255.0), 1e-5);
    EXPECT_EQ(judged("mm-half-pixel-diffusion").verdict, kDoesNotFollow);
    // A code b is stuck where .01 b rounds to nothing: from 50 on.
    EXPECT_NEAR(judged("mm-beta-exact").value(""), 50 / 255.0, 1e-6);
    EXPECT_EQ(judged("mm-beta-exact").verdict, "reproduced under beta in float16");
    EXPECT_NEAR(judged("mm-weight").value(""), 16.098453125, 1e-4);
    EXPECT_EQ(judged("mm-weight").verdict, "reproduced");
    EXPECT_EQ(judged("mm-caustics").verdict, "reproduced");
    EXPECT_EQ(judged("mm-caustics-prose").verdict, kDoesNotFollow);
}

// 7 of net coverage, 4 and 4 of the weight, 7 of A, 4 of delta; refractOffset's own are far more than the
// rest.
TEST(PhenomenologicalClaims, Operations) {
    const Judged operations = judged("mm-25-operations");
    const char* listed = "the lines that Listing 1 prints, what its call of refractOffset does not counted";
    EXPECT_EQ(operations.value(listed), 7 + 4 + 4 + 7 + 4);
    EXPECT_GT(operations.value(""), 2 * 25);
    EXPECT_EQ(operations.verdict, std::string("reproduced under ") + listed);
}

TEST(PhenomenologicalClaims, FetchesOfTheTent) {
    int texels = 0;
    for (int y = -7; y <= 7; ++y)
        for (int x = -7; x <= 7; ++x) texels += x * x + y * y <= 7.5 * 7.5 ? 1 : 0;
    const Judged fetches = judged("mm-176");
    EXPECT_EQ(fetches.value("the texels of that disc"), texels);
    EXPECT_NEAR(fetches.value("the disc of diameter 15 in the tent, by area"), std::numbers::pi * 56.25,
                1e-9);
    EXPECT_EQ(fetches.verdict, "reproduced under the disc of diameter 15 in the tent, by area");
}

// What has been worked out about the paper's numbers elsewhere, and the row that stands for it here.
TEST(PhenomenologicalClaims, HaveARowForEveryKnownNumber) {
    for (const char* id :
         {"mm-112", "mm-88", "mm-256", "mm-128-320", "mm-3.6x", "mm-2-3x", "mm-2x-abstract",
          "mm-strictly-storage", "mm-strictly-pins", "mm-176", "mm-10x", "mm-15x", "mm-weight",
          "mm-beta-third", "mm-k1", "mm-eq9", "mm-16x", "mm-25-operations", "mm-hair"})
        EXPECT_EQ(claim_of(id).id, id);
    // Table 1: ten rows of four numbers.
    int cells = 0;
    for (const Claim& claim : all_claims())
        if (claim.place == "Table 1" && claim.paper == "McGuire and Mara 2017" &&
            claim.id.starts_with("mm-table1-"))
            cells += static_cast<int>(claim.printed.numbers.size());
    EXPECT_EQ(cells, 10 * 4);
}

// The stage of sixteen layers in registers is the stage of one, and a quarter of the resolution a sixteenth
// of the blends, though not of the bytes: of runs.
TEST(PhenomenologicalClaims, RunsOfTheStage) {
    const TemporaryDirectory directory;
    ClaimsOptions options;
    options.ids = {"mm-registers", "mm-16x"};
    options.runs.quick = true;
    options.runs.directory = directory.path();
    options.runs.program = ROPSIM_PROGRAM;
    for (const ClaimResult& result : run_claims(options)) {
        EXPECT_EQ(result.failure, "") << result.claim->id;
        EXPECT_EQ(result.judgement.text(), result.claim->id == "mm-16x"
                                               ? "reproduced under our scene fog, the number of blends alone"
                                               : "reproduced")
            << result.claim->id;
    }
}

}  // namespace
}  // namespace ropsim
