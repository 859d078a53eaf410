// Claims of Enderton et al. 2011, "Stochastic Transparency".
#include "analysis/claims_list.h"
#include "analysis/declared_cost.h"
#include "analysis/mask_enumeration.h"

#include <cmath>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr const char* kPaper = "Enderton et al. 2011";
constexpr const char* kRuns = "runs of R neighbouring samples at a random rotation as the random subset";

// Red over green, both .45, over blue; four white layers of 1/4 over 1/4.
MaskPixel example1(int samples = 4) {
    return {{{0.45, {1, 0, 0}}, {0.45, {0, 1, 0}}}, {0, 0, 1}, samples};
}
MaskPixel example2(int samples = 4) {
    return {std::vector<MaskLayer>(4, {0.25, {1, 1, 1}}), {0.25, 0.25, 0.25}, samples};
}

std::vector<double> three(const std::array<double, 3>& values) {
    return {values.begin(), values.end()};
}
std::vector<double> rms(const MaskPixel& pixel, MaskDraw draw, MaskEstimate estimate) {
    return three(mask_errors(pixel, draw, estimate).rms);
}

void add_examples(std::vector<Claim>& claims) {
    const auto add = [&](const char* id, const char* place, const char* claim, const char* printed,
                         auto find) {
        claims.push_back({id, kPaper, place, claim, Printed::numbers_of(printed), rule::digits(),
                          Basis::kDefinition, "enumeration of all masks", false,
                          [find](ClaimRuns&) { return find(); }});
    };
    add("st-ex1-color", "section 3.1", "Colour of example 1", "(0.45, 0.2475, 0.3025)", [] {
        const auto mean = three(mask_errors(example1(), MaskDraw::kChoose, MaskEstimate::kBasic).mean);
        return Finding{{}, mean, {{"", mean}}, "blended, and the mean of the basic method over all masks"};
    });
    add("st-ex1-naive", "section 3.1", "RMS error of example 1, 4 samples by coins", "(0.25, 0.21, 0.23)",
        [] {
            const auto error = rms(example1(), MaskDraw::kCoin, MaskEstimate::kBasic);
            return Finding{
                {}, error, {{"", error}}, "green's .2158 rounds to .22; red and blue are as printed"};
        });
    add("st-ex1-stratified", "section 3.1", "RMS error of example 1, 4 stratified samples",
        "(0.10, 0.17, 0.18)", [] {
            const auto choose = rms(example1(), MaskDraw::kChoose, MaskEstimate::kBasic);
            const auto run = rms(example1(), MaskDraw::kRun, MaskEstimate::kBasic);
            return Finding{
                {},
                choose,
                {{"", choose}, {kRuns, run}},
                "the S-choose-R subsets of the text give (.100, .155, .158), five points less; runs, "
                "whose masks "
                "overlap more unevenly, give (.100, .175, .178)"};
        });
    add("st-ex2-stratified", "section 3.1", "RMS error of example 2, 4 stratified samples", "0.12", [] {
        const double error = rms(example2(), MaskDraw::kChoose, MaskEstimate::kBasic)[0];
        return Finding{{}, {error}, {{"", {error}}}, "with S-choose-R and with runs alike"};
    });
}

void add_passes(std::vector<Claim>& claims) {
    claims.push_back({"st-passes", kPaper, "sections 3.5, 7",
                      "Passes over the transparent geometry for 8 and 16 samples on hardware with 8",
                      Printed::numbers_of("3, 5"), rule::exact(), Basis::kDefinition,
                      "passes that the technique declares", false, [](ClaimRuns&) {
                          std::vector<double> passes;
                          for (const int samples : {8, 16})
                              passes.push_back(
                                  declared_cost(fmt::format("stochastic:method=depth_based,samples={},"
                                                            "hardware_samples=8",
                                                            samples))
                                      .geometry_passes);
                          return Finding{passes,
                                         passes,
                                         {{"", passes}},
                                         "total alpha once, depth and accumulation for each 8 samples"};
                      }});
}

}  // namespace

void add_stochastic_claims(std::vector<Claim>& claims) {
    add_examples(claims);
    add_passes(claims);
}

}  // namespace ropsim
