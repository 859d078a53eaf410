// Claims of Enderton et al. 2011 about bias, estimators and masks, enumerated.
#include "analysis/claims/stochastic_pixels.h"
#include "rop/sampling/mask_table.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace ropsim {
namespace {

using namespace stochastic_claims;

void add_bias(Rows rows) {
    rows.add_digits("st-bias-exact", "section 4.1", "C of two layers of 1/4", "(0.25, 0.1875, 0)", [] {
        const Values c = three(blended(two_quarters()));
        return Finding{{}, c, {{"", c}}, "blended"};
    });
    rows.add_digits(
        "st-bias-mean", "section 4.1", "E(A) of two layers of 1/4, 4 samples", "(0.273, 0.164, 0)", [] {
            const Values m = mean(two_quarters(), MaskDraw::kChoose, MaskEstimate::kCorrected);
            return Finding{{}, m, {{"", m}}, fmt::format("exactly {:.7f} and {:.7f}", m[0], m[1])};
        });
    rows.add("st-bias-percent", "section 4.1", "The front layer is about 10 % too high, the back one too low",
             Printed::numbers_of("10 %, 10 %"), rule::about(), [] {
                 const Values m = mean(two_quarters(), MaskDraw::kChoose, MaskEstimate::kCorrected);
                 const Values percent{100 * (m[0] / 0.25 - 1), 100 * (1 - m[1] / 0.1875)};
                 return Finding{{}, percent, {{"", percent}}, "\"about\" taken as one significant digit"};
             });
    rows.add("st-empty-pixels", "section 4.1",
             "A single layer of alpha 1/(2S) gets half its value, whatever S",
             Printed::formula("E(A) = alpha_C / 2", {.5, .5, .5}), rule::exact(), [] {
                 Values share;
                 for (const int samples : {4, 8, 16}) {
                     const double alpha = 0.5 / samples;
                     const MaskPixel pixel{{{alpha, {1, 1, 1}}}, {0, 0, 0}, samples};
                     share.push_back(mean(pixel, MaskDraw::kChoose, MaskEstimate::kCorrected)[0] / alpha);
                 }
                 return Finding{{}, share, {{"", share}}, "4, 8 and 16 samples; so A is not consistent"};
             });
    rows.add("st-no-empty-pixels", "section 4.1", "A fragment of alpha 1/S or more leaves no pixel empty",
             Printed::statement("nonempty"), rule::statement(), [] {
                 double empty = 0;
                 for (const int samples : {2, 4, 8, 12})
                     for (int part = 1; part <= 16; ++part) {
                         const double alpha = std::min(1.0, (0.75 + 0.25 * part) / samples);
                         empty = std::max(empty, mask_probabilities(MaskDraw::kChoose, samples, alpha)[0]);
                     }
                 return Finding{{}, {empty}, {{"", {}, empty == 0}}, "greatest chance of an empty mask"};
             });
}

void add_estimators(Rows rows) {
    const auto unbiased = [&](const char* id, const char* claim, const char* printed, MaskEstimate estimate) {
        rows.add(id, "section 4", claim, Printed::formula(printed, {0}), {Rule::Kind::kExact, 0}, [estimate] {
            double most = 0;
            for (const MaskDraw draw : {MaskDraw::kCoin, MaskDraw::kChoose, MaskDraw::kRun})
                for (const MaskPixel& pixel : {example1(), example2(), two_quarters()})
                    most = std::max(most, bias(pixel, draw, estimate));
            return Finding{
                {}, {most}, {{"", {most}}}, "largest |mean - C| of three pixels and three kinds of mask"};
        });
    };
    unbiased("st-unbiased", "The basic method is unbiased", "E(B) = C", MaskEstimate::kBasic);
    unbiased("st-u-unbiased", "The uncorrected depth-based method is unbiased", "E(U) = C",
             MaskEstimate::kDepth);
    rows.add("st-d-biased", "section 4.2", "D is biased, as two layers show", Printed::statement("biased"),
             rule::statement(), [] {
                 const double of_45 = bias(example1(), MaskDraw::kChoose, MaskEstimate::kDepthByAlpha);
                 const double of_quarter =
                     bias(two_quarters(), MaskDraw::kChoose, MaskEstimate::kDepthByAlpha);
                 return Finding{
                     {},
                     {of_45, of_quarter},
                     {{"", {}, of_45 > 1e-9}},
                     fmt::format("two layers of .45: off by {:.2g}; where alpha S is a whole number, as "
                                 "in 4.1's example, D is exact",
                                 of_45)};
             });
    rows.add("st-d-consistent", "section 4.2", "D converges to C", Printed::meaning("lim D = C", 0, 1e-3),
             rule::digits(), [] {
                 // Of two layers only the nearer one's R counts: U = a c1 + (1 - R/S) a c2.
                 Values errors;
                 for (const int samples : {4, 64, 1024}) {
                     constexpr double kAlpha = 0.45;
                     const double expected = kAlpha * samples;
                     const double low = std::floor(expected);
                     double squares = 0;
                     for (const double r : {low, low + 1}) {
                         const double visible = 1 - r / samples;
                         const double front = (1 - 0.55 * 0.55) / (1 + visible);
                         squares += (r == low ? low + 1 - expected : expected - low) * (front - kAlpha) *
                                    (front - kAlpha);
                     }
                     errors.push_back(std::sqrt(squares));
                 }
                 return Finding{{},
                                errors,
                                {{"", {errors.back()}}},
                                "RMS error of example 1's red with 4, 64 and 1024 samples"};
             });
}

void add_masks(Rows rows) {
    rows.add_digits("st-overlap", "section 6",
                    "Two fragments of alpha .5, 8 samples: covered within one of correct", "97 %", [] {
                        const double p = 100 * two_masks_cover(8, 4, 5, 7);
                        return Finding{{}, {p}, {{"", {p}}}, fmt::format("hypergeometric: {:.3f} %", p)};
                    });
    rows.add("st-balls-slope", "section 3.1",
             "RMS error of S fragments of one sample each falls as 1/sqrt(S)",
             Printed::meaning("1/sqrt(S)", -0.5, 0.005), rule::digits(), [] {
                 const auto error = [](int s) { return std::sqrt(empty_bins_variance(s, s)) / s; };
                 const double slope = std::log(error(1024) / error(64)) / std::log(16.0);
                 return Finding{
                     {},
                     {slope},
                     {{"", {slope}}},
                     fmt::format("exponent from 64 to 1024 samples; RMS sqrt(S) is {:.4f} with 8, goes to "
                                 "{:.4f} = sqrt(1/e - 2/e^2)",
                                 error(8) * std::sqrt(8.0), std::sqrt(std::exp(-1.0) - 2 * std::exp(-2.0)))};
             });
    rows.add("st-balls-variance", "section 3.1", "The variance of empty bins grows linearly with M = S balls",
             Printed::meaning("linearly", 1, 0.005), rule::digits(), [] {
                 const double power =
                     std::log(empty_bins_variance(1024, 1024) / empty_bins_variance(64, 64)) / std::log(16.0);
                 return Finding{{}, {power}, {{"", {power}}}, "exponent from 64 to 1024 balls"};
             });
    rows.add("st-mask-count", "section 5", "S-choose-R masks of 8 and of 16 samples at most",
             Printed::numbers_of("70, 12,870"), rule::exact(), [] {
                 const Values counts{binomial(8, 4), binomial(16, 8)};
                 return Finding{{}, counts, {{"", counts}}, "C(8,4) and C(16,8)"};
             });
    rows.add(
        "st-mask-table", "section 5", "Masks a row of the table, bits of alpha that index it",
        Printed::numbers_of("2,047, 10"), rule::exact(), [] {
            const Values table{static_cast<double>(MaskTable::kEntries),
                               std::log2(static_cast<double>(MaskTable::kLevels))};
            return Finding{{}, table, {{"", table}}, "as masks=table is built; \"approximately 10 bits\""};
        });
}

}  // namespace

void add_stochastic_bias_claims(std::vector<Claim>& claims) {
    const Rows rows(claims);
    add_bias(rows);
    add_estimators(rows);
    add_masks(rows);
}

}  // namespace ropsim
