// Claims of Enderton et al. 2011, "Stochastic Transparency": its two examples, enumerated.
#include "analysis/claims/stochastic_pixels.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace ropsim {
namespace {

using namespace stochastic_claims;

// Section 3.1 draws "one of the S-choose-R possible subsets", so runs of R neighbouring samples at a random
// rotation are no reading of it; they are what the printed numbers seem to stand on.
std::string with_runs(const MaskPixel& pixel, MaskEstimate estimate) {
    const Values e = rms(pixel, MaskDraw::kRun, estimate);
    return fmt::format("({:.3f}, {:.3f}, {:.3f})", e[0], e[1], e[2]);
}
double formula_of_example2() {
    double color = std::pow(0.75, 4) * 0.25;
    for (int i = 0; i < 4; ++i) color += std::pow(0.75, i) * 0.25;
    return color;
}

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

}  // namespace

void add_stochastic_claims(std::vector<Claim>& claims) {
    const Rows rows(claims);
    add_example1(rows);
    add_example1_depth(rows);
    add_example2(rows);
    add_stochastic_bias_claims(claims);
    add_stochastic_cost_claims(claims);
    add_stochastic_noise_claims(claims);
}

}  // namespace ropsim
