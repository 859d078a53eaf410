// Claims of Laine and Karras 2011, "Stratified Sampling for Stochastic Transparency": its sequences and
// stages.
#include "analysis/claims/declared_cost.h"
#include "analysis/claims/list.h"
#include "analysis/claims/opacity_statistics.h"

#include <array>
#include <cmath>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr const char* kPaper = "Laine and Karras 2011";

using Values = std::vector<double>;

// Eight surfaces of alpha .1, .3 and .5 over one another.
double exact_coverage(double alpha) {
    return 1 - std::pow(1 - alpha, 8);
}

template <class Find>
void add_enumerated(std::vector<Claim>& claims, const char* id, const char* place, const char* claim,
                    const Printed& printed, const Rule& rule, const char* how, Find find) {
    claims.push_back({id, kPaper, place, claim, printed, rule, Basis::kDefinition, how, false,
                      [find](ClaimRuns& runs) { return find(runs.quick() ? 1 : 8); }});
}

void add_sequences(std::vector<Claim>& claims) {
    add_enumerated(
        claims, "lk-radical-inverse", "section 3", "The radical inverse of indices 0 to 7",
        Printed::numbers_of("0.000, 0.500, 0.250, 0.750, 0.125, 0.625, 0.375, 0.875"), rule::digits(),
        "the sequence hash=radical_inverse", [](int) {
            Values values;
            for (std::uint32_t i = 0; i < 8; ++i)
                values.push_back(opacity_reference<PlainDatapath>(OpacityHash::kRadicalInverse, i, 0) *
                                 0x1p-32);
            return Finding{{}, values, {{"", values}}, "so that spans 0...3 and 4...7 differ by 0.125"};
        });
    add_enumerated(
        claims, "lk-scrambled", "section 3",
        "The printed scrambled sequence is stratified in its aligned spans of 2, 4 and 8",
        Printed::statement("0.750, 0.250, 0.000, 0.500, 0.375, 0.875, 0.125, 0.625"), rule::statement(),
        "every aligned span of 2, 4 and 8", [](int) {
            Values own;
            for (std::uint32_t i = 0; i < 8; ++i)
                own.push_back(opacity_reference<PlainDatapath>(OpacityHash::kPaper, i, 0) * 0x1p-32);
            const bool valid = spans_stratified({.75, .25, 0, .5, .375, .875, .125, .625});
            return Finding{{},
                           own,
                           {{"", {}, valid}},
                           "a valid Owen scramble; measured is what Fig. 4's hash gives for surface 0, "
                           "which is another"};
        });
    add_enumerated(
        claims, "lk-aligned-spans", "section 3",
        "Every aligned span of 2^k indices is perfectly stratified, on any surface",
        Printed::statement("perfectly stratified"), rule::statement(),
        "random spans of 2^1 to 2^10 indices on surfaces 0 to 63", [](int effort) {
            const bool all = aligned_spans_stratified(OpacityHash::kPaper, 4 * effort);
            return Finding{{}, {all ? 1.0 : 0.0}, {{"", {}, all}}, "1: one reference in each interval"};
        });
    add_enumerated(
        claims, "lk-nearest-share", "section 4", "The nearest surface covers floor or ceil(alpha N) samples",
        Printed::formula("floor or ceil", {0}), rule::exact(),
        "random pixels, surfaces and alphas, 8 and 16 samples", [](int effort) {
            const double off =
                std::max(farthest_from_share(8, 12'500 * effort), farthest_from_share(16, 12'500 * effort));
            return Finding{{}, {off}, {{"", {off}}}, "farthest from either, in samples"};
        });
    add_enumerated(claims, "lk-uncorrelated", "section 3.1",
                   "The references of one surface are not correlated with the next eight's",
                   Printed::meaning("not correlated", 0, 0.01), rule::digits(),
                   "largest correlation of surface 0 with 1 to 8", [](int) {
                       const double largest = largest_correlation(OpacityHash::kPaper, 1 << 16);
                       return Finding{{}, {largest}, {{"", {largest}}}, "\"not\" taken as below .01"};
                   });
}

void add_bias(std::vector<Claim>& claims) {
    const auto coverage = [](OpacityHash hash, double alpha, int effort) {
        return mean_coverage(hash, alpha, 8, 8, 8192 * effort);
    };
    add_enumerated(claims, "lk-radical-inverse-biased", "section 3",
                   "With the plain radical inverse several surfaces are biased", Printed::statement("biased"),
                   rule::statement(), "mean coverage by 8 surfaces of alpha .1, 8 samples", [=](int effort) {
                       const Coverage c = coverage(OpacityHash::kRadicalInverse, 0.1, effort);
                       const double off = std::abs(c.mean - exact_coverage(0.1));
                       return Finding{{},
                                      {c.mean, exact_coverage(0.1)},
                                      {{"", {}, off > 5 * c.standard_error + 1e-6}},
                                      "second: the correct coverage. The surfaces hide one another"};
                   });
    add_enumerated(claims, "lk-sobol-biased", "Figure 3b",
                   "With Sobol's sequence significant correlations remain",
                   Printed::statement("significant correlations remain"), rule::statement(),
                   "mean coverage by 8 surfaces of alpha .1, 8 samples", [=](int effort) {
                       const Coverage c = coverage(OpacityHash::kSobol, 0.1, effort);
                       const double off = std::abs(c.mean - exact_coverage(0.1));
                       return Finding{{},
                                      {c.mean, exact_coverage(0.1)},
                                      {{"", {}, off > 5 * c.standard_error + 1e-6}},
                                      "second: the correct coverage. The surfaces avoid one another"};
                   });
    add_enumerated(
        claims, "lk-unbiased", "sections 3.1, 4", "With Fig. 4's hash the result is unbiased",
        Printed::formula("correct expected value: .5695, .9424, .9961",
                         {exact_coverage(0.1), exact_coverage(0.3), exact_coverage(0.5)}),
        rule::exact(), "mean coverage by 8 surfaces of alpha .1, .3, .5, 8 samples", [=](int effort) {
            Values means;
            double noise = 0;
            for (const double alpha : {.1, .3, .5}) {
                const Coverage c = coverage(OpacityHash::kPaper, alpha, effort);
                means.push_back(c.mean);
                noise = std::max(noise, 4 * c.standard_error);
            }
            return Finding{{}, means, {{"", means, false, noise}}, "within 4 standard errors of the pixels"};
        });
}

// What both papers say of the alpha-to-coverage of their day's hardware.
void add_static_masks(std::vector<Claim>& claims) {
    claims.push_back(
        {"lk-static-masks", kPaper, "section 1.1",
         "With alpha-to-coverage's static masks only the nearer of two surfaces is visible",
         Printed::formula("only the closer one will be visible", {0}), rule::exact(), Basis::kDefinition,
         "samples of the far one of two surfaces of alpha .5, of 16", true, [](ClaimRuns& runs) {
             ClaimTrace trace{"black_before_white", "128x128", "64x64"};
             trace.layers = 2;
             trace.alpha = 0.5;
             const RunRecord& run = runs.run({trace, "stochastic:samples=16,masks=alpha_to_coverage"});
             const double samples = 4 + 16 * number_of(run.mean_signed8) / 255;
             return Finding{{}, {samples}, {{"", {samples}}}, "4 would be right"};
         }});
}

// Figure 5: two surfaces of alpha .5, 16 samples. The image's error is that of the far surface's samples.
void add_stages(std::vector<Claim>& claims) {
    struct Stage {
        const char* id;
        const char* place;
        const char* claim;
        const char* technique;
        const char* order;
        bool exact;
        const char* why;
    };
    for (const Stage& stage :
         {Stage{"lk-fig5a", "Figure 5a",
                "Without compaction the far surface has 4 samples on average, 0 to 8",
                "laine_karras:samples=16,compaction=false", "near_to_far", false, "near to far"},
          {"lk-fig5b", "Figure 5b", "With compaction it has exactly 4, near to far",
           "laine_karras:samples=16,sort=false", "near_to_far", true, "without sorting"},
          {"lk-fig5c", "Figure 5c", "Compaction does not help far to near: 0 to 8",
           "laine_karras:samples=16,sort=false", "far_to_near", false, "without sorting"},
          {"lk-fig5d", "Figure 5d", "With sorting it has exactly 4 far to near too",
           "laine_karras:samples=16", "far_to_near", true, "as published"}}) {
        claims.push_back(
            {stage.id, kPaper, stage.place, stage.claim,
             stage.exact ? Printed::formula("exactly 4", {0, 0})
                         : Printed::formula("4 on the average, between 0 and 8", {0, 4}),
             rule::exact(), Basis::kDefinition, "mean and largest distance from 4 samples over the pixels",
             true, [stage](ClaimRuns& runs) {
                 ClaimTrace trace{"black_before_white", "128x128", "64x64"};
                 trace.layers = 2;
                 trace.alpha = 0.5;
                 trace.order = stage.order;
                 const RunRecord& run = runs.run({trace, stage.technique});
                 const double mean = 16 * number_of(run.mean_signed8) / 255;
                 const double most = 16 * number_of(run.max_abs);
                 const double deviation = 16 * number_of(run.rmse8) / 255;
                 const double pixels = number_of(run.width) * number_of(run.height);
                 const double noise = 4 * deviation / std::sqrt(pixels);
                 return Finding{
                     {},
                     {mean, most},
                     {{"", {mean, most}, false, noise}},
                     fmt::format("distances of the mean and of the farthest pixel; {}, spread {:.2f}",
                                 stage.why, deviation)};
             }});
    }
}

void add_cost(std::vector<Claim>& claims) {
    claims.push_back({"lk-single-pass", kPaper, "section 1", "The method takes a single pass",
                      Printed::formula("basic single-pass method", {1}), rule::exact(), Basis::kDefinition,
                      "passes that the technique declares", false, [](ClaimRuns&) {
                          const double passes = declared_cost("laine_karras:samples=16").geometry_passes;
                          return Finding{{passes}, {}, {{"", {passes}}}, "as declared"};
                      }});
    claims.push_back(
        {"lk-mask-bits", kPaper, "section 2",
         "Tracking keeps one bit a sample and a surface id a pixel, beyond stochastic transparency",
         Printed::formula("one bit per sample, a surface ID", {1}), rule::exact(), Basis::kDefinition,
         "bits that the techniques declare, 8 and 16 samples", false, [](ClaimRuns&) {
             Values more;
             for (const int samples : {8, 16})
                 more.push_back(declared_cost(fmt::format("laine_karras:samples={}", samples)).storage_bits -
                                declared_cost(fmt::format("stochastic:samples={}", samples)).storage_bits);
             // The id costs the same at both, so the difference is that of the masks.
             const double per_sample = (more[1] - more[0]) / 8;
             return Finding{{more[0], more[1]},
                            {per_sample},
                            {{"", {per_sample}}},
                            fmt::format("bits more with 8 and 16 samples, of which {:.0f} are the id; "
                                        "measured: bits a sample",
                                        more[0] - 8 * per_sample)};
         }});
}

}  // namespace

void add_laine_karras_claims(std::vector<Claim>& claims) {
    add_sequences(claims);
    add_bias(claims);
    add_static_masks(claims);
    add_stages(claims);
    add_cost(claims);
    add_laine_karras_table_claims(claims);
}

}  // namespace ropsim
