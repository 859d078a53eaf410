// Claims of Enderton et al. 2011, "Stochastic Transparency": its two examples, bias and masks, enumerated.
#include "analysis/claims/list.h"
#include "analysis/claims/mask_enumeration.h"
#include "rop/sampling/mask_table.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr const char* kPaper = "Enderton et al. 2011";

using Values = std::vector<double>;

// Red over green, both .45, over blue.
MaskPixel example1() {
    return {{{0.45, {1, 0, 0}}, {0.45, {0, 1, 0}}}, {0, 0, 1}, 4};
}
// Four white layers of 1/4 over 1/4.
MaskPixel example2(int samples = 4) {
    return {std::vector<MaskLayer>(4, {0.25, {1, 1, 1}}), {0.25, 0.25, 0.25}, samples};
}
// Section 4.1: red over green, both 1/4, over black.
MaskPixel two_quarters() {
    return {{{0.25, {1, 0, 0}}, {0.25, {0, 1, 0}}}, {0, 0, 0}, 4};
}

double formula_of_example2() {
    double color = std::pow(0.75, 4) * 0.25;
    for (int i = 0; i < 4; ++i) color += std::pow(0.75, i) * 0.25;
    return color;
}

Values three(const std::array<double, 3>& values) {
    return {values.begin(), values.end()};
}
Values rms(const MaskPixel& pixel, MaskDraw draw, MaskEstimate estimate) {
    return three(mask_errors(pixel, draw, estimate).rms);
}
// Section 3.1 draws "one of the S-choose-R possible subsets", so runs of R neighbouring samples at a random
// rotation are no reading of it; they are what the printed numbers seem to stand on.
std::string with_runs(const MaskPixel& pixel, MaskEstimate estimate) {
    const Values e = rms(pixel, MaskDraw::kRun, estimate);
    return fmt::format("({:.3f}, {:.3f}, {:.3f})", e[0], e[1], e[2]);
}
Values mean(const MaskPixel& pixel, MaskDraw draw, MaskEstimate estimate) {
    return three(mask_errors(pixel, draw, estimate).mean);
}

// Largest distance of a mean from the correct colour.
double bias(const MaskPixel& pixel, MaskDraw draw, MaskEstimate estimate) {
    const Values got = mean(pixel, draw, estimate);
    const auto correct = blended(pixel);
    double most = 0;
    for (std::size_t c = 0; c < 3; ++c) most = std::max(most, std::abs(got[c] - correct[c]));
    return most;
}

class Rows {
 public:
    explicit Rows(std::vector<Claim>& claims) : claims_(claims) {}

    template <class Find>
    void add(const char* id, const char* place, const char* claim, const Printed& printed, const Rule& rule,
             Find find) {
        claims_.push_back({id, kPaper, place, claim, printed, rule, Basis::kDefinition,
                           "enumeration in double precision", false, [find](ClaimRuns&) { return find(); }});
    }
    // Printed numbers of one estimate.
    template <class Find>
    void add_digits(const char* id, const char* place, const char* claim, const char* printed, Find find) {
        add(id, place, claim, Printed::numbers_of(printed), rule::digits(), find);
    }

 private:
    std::vector<Claim>& claims_;
};

void add_example1(Rows rows) {
    rows.add_digits("st-ex1-color", "section 3.1", "Colour of example 1", "(0.45, 0.2475, 0.3025)", [] {
        const Values m = mean(example1(), MaskDraw::kChoose, MaskEstimate::kBasic);
        return Finding{{}, m, {{"", m}}, "mean of the basic method over all masks; blending gives the same"};
    });
    rows.add_digits("st-ex1-r", "section 3.1", "Alpha .45 of 4 samples: chance of R = 1 and of R = 2",
                    "20 %, 80 %", [] {
                        const Values p = mask_probabilities(MaskDraw::kChoose, 4, 0.45);
                        Values of_count(5, 0.0);
                        for (std::uint32_t mask = 0; mask < p.size(); ++mask)
                            of_count[static_cast<std::size_t>(std::popcount(mask))] += 100 * p[mask];
                        return Finding{{},
                                       {of_count[1], of_count[2]},
                                       {{"", {of_count[1], of_count[2]}}},
                                       "the masks' probabilities summed by their size"};
                    });
    rows.add_digits(
        "st-ex1-naive", "section 3.1", "RMS error of example 1, 4 samples by coins", "(0.25, 0.21, 0.23)",
        [] {
            const Values e = rms(example1(), MaskDraw::kCoin, MaskEstimate::kBasic);
            return Finding{{},
                           e,
                           {{"", e}},
                           fmt::format("green is {:.4f}, which rounds to {:.2f}; red and blue are as printed",
                                       e[1], e[1])};
        });
    rows.add_digits("st-ex1-stratified", "section 3.1", "RMS error of example 1, 4 stratified samples",
                    "(0.10, 0.17, 0.18)", [] {
                        const Values choose = rms(example1(), MaskDraw::kChoose, MaskEstimate::kBasic);
                        return Finding{
                            {},
                            choose,
                            {{"", choose}},
                            fmt::format("with one of the S-choose-R subsets, as the section defines it; what "
                                        "is printed comes out with runs of R neighbouring samples: {}",
                                        with_runs(example1(), MaskEstimate::kBasic))};
                    });
    rows.add_digits(
        "st-ex1-corrected", "section 3.3", "RMS error of example 1 with alpha correction",
        "(0.17, 0.14, 0.0)", [] {
            const Values choose = rms(example1(), MaskDraw::kChoose, MaskEstimate::kCorrected);
            const Values run = rms(example1(), MaskDraw::kRun, MaskEstimate::kCorrected);
            return Finding{
                {},
                choose,
                {{"", choose}},
                fmt::format(
                    "A's red and green add up to total alpha with any masks, so their errors are equal: "
                    "{:.3f}, with runs of neighbouring samples {:.3f}; what is printed comes out with such "
                    "runs if one layer's alpha, .45, stands for total alpha",
                    choose[0], run[0])};
        });
}

void add_example1_depth(Rows rows) {
    rows.add_digits("st-ex1-depth", "section 3.4", "RMS error of example 1, depth-based, uncorrected",
                    "(0.0, 0.05, 0.18)", [] {
                        const Values choose = rms(example1(), MaskDraw::kChoose, MaskEstimate::kDepth);
                        return Finding{
                            {},
                            choose,
                            {{"", choose}},
                            fmt::format("green is {:.3f}, an exact half that was rounded up, but blue is "
                                        "{:.3f}; what is printed comes out with runs of R neighbouring "
                                        "samples: {}",
                                        choose[1], choose[2], with_runs(example1(), MaskEstimate::kDepth))};
                    });
    rows.add_digits(
        "st-ex1-depth-corrected", "section 3.4", "RMS error of example 1, depth-based, corrected",
        "(0.14, 0.12, 0.0)", [] {
            const Values by_alpha = rms(example1(), MaskDraw::kChoose, MaskEstimate::kDepthByAlpha);
            const Values covered = rms(example1(), MaskDraw::kChoose, MaskEstimate::kDepthByCoverage);
            return Finding{
                {},
                by_alpha,
                {{"", by_alpha}},
                fmt::format(
                    "corrected by the accumulated alpha, as the section has it, red's error is {:.1f} "
                    "times smaller than printed; what is printed comes out with runs of R neighbouring "
                    "samples and division by the covered samples: {}; with S-choose-R subsets that "
                    "division gives ({:.3f}, {:.3f}, {:.3f})",
                    0.14 / by_alpha[0], with_runs(example1(), MaskEstimate::kDepthByCoverage), covered[0],
                    covered[1], covered[2])};
        });
    rows.add(
        "st-ex1-depth-harm", "section 3.4", "Correcting the depth-based example 1 does more harm than good",
        Printed::statement("more harm than good"), rule::statement(), [] {
            const auto total = [](const Values& e) { return std::hypot(e[0], e[1], e[2]); };
            const auto of = [&](MaskDraw draw, MaskEstimate estimate) {
                return total(rms(example1(), draw, estimate));
            };
            const double before = of(MaskDraw::kChoose, MaskEstimate::kDepth);
            const double by_alpha = of(MaskDraw::kChoose, MaskEstimate::kDepthByAlpha);
            const double by_coverage = of(MaskDraw::kChoose, MaskEstimate::kDepthByCoverage);
            return Finding{{},
                           {before, by_alpha},
                           {{"", {}, by_alpha > before}},
                           fmt::format("errors of the three channels together: {:.3f} before, {:.3f} after "
                                       "correction by the accumulated alpha; harm, {:.3f}, comes of dividing "
                                       "by the covered samples, which is section 3.3's correction",
                                       before, by_alpha, by_coverage)};
        });
}

void add_example2(Rows rows) {
    rows.add("st-ex2-color", "section 3.1", "Colour of example 2, by its formula with N = 4, background .25",
             Printed::formula("(1-a)^N c_b + sum (1-a)^i a c_f", {formula_of_example2()}), rule::exact(), [] {
                 const Values m = mean(example2(), MaskDraw::kChoose, MaskEstimate::kBasic);
                 return Finding{{}, {m[0]}, {{"", {m[0]}}}, "mean of the basic method over all masks"};
             });
    rows.add_digits("st-ex2-naive", "section 3.1", "RMS error of example 2, 4 samples by coins", "0.35", [] {
        const double four = rms(example2(), MaskDraw::kCoin, MaskEstimate::kBasic)[0];
        const double one = rms(example2(1), MaskDraw::kCoin, MaskEstimate::kBasic)[0];
        return Finding{
            {}, {four}, {{"", {four}}}, fmt::format("the text has S = 4; {:.4f} is the error of S = 1", one)};
    });
    const auto add = [&](const char* id, const char* place, const char* claim, const char* printed,
                         MaskEstimate estimate, const char* why) {
        rows.add_digits(id, place, claim, printed, [estimate, why] {
            const double error = rms(example2(), MaskDraw::kChoose, estimate)[0];
            return Finding{{}, {error}, {{"", {error}}}, why};
        });
    };
    add("st-ex2-stratified", "section 3.1", "RMS error of example 2, 4 stratified samples", "0.12",
        MaskEstimate::kBasic, "with S-choose-R subsets and with runs alike");
    add("st-ex2-corrected", "section 3.3", "RMS error of example 2 with alpha correction", "0.0",
        MaskEstimate::kCorrected, "all colours are the same");
    add("st-ex2-depth", "section 3.4", "RMS error of example 2, depth-based, uncorrected", "0.08",
        MaskEstimate::kDepth,
        "rounds to .09: the digits were cut off, where section 3.1 says that it rounds");
    add("st-ex2-depth-corrected", "section 3.4", "RMS error of example 2, depth-based, corrected", "0",
        MaskEstimate::kDepthByAlpha, "all colours are the same");
}

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

void add_stochastic_claims(std::vector<Claim>& claims) {
    const Rows rows(claims);
    add_example1(rows);
    add_example1_depth(rows);
    add_example2(rows);
    add_bias(rows);
    add_estimators(rows);
    add_masks(rows);
    add_stochastic_cost_claims(claims);
}

}  // namespace ropsim
