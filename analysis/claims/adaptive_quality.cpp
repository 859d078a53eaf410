// Claims of Salvi et al. 2011 that compare images: of our scenes of the kind.
#include "analysis/claims/adaptive.h"
#include "analysis/claims/declared_cost.h"
#include "base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr const char* kMaps[] = {"opacity_map", "fourier_map"};

constexpr AdaptiveScene kScenes[] = {{"smoke", 24, 24, "which Table 1's memory is nearest to"},
                                     {"hair", 16, 24, "of section 5.1.2; Table 1's memory is of 16"},
                                     {"forest", 8, 8, "of Table 1's memory"}};

std::string adaptive(int nodes) {
    return fmt::format("adaptive:nodes={}", nodes);
}
std::string stochastic(int samples) {
    return fmt::format("stochastic:samples={},method=depth_based", samples);
}
double rmse(ClaimRuns& runs, const char* scene, const std::string& technique) {
    return number_of(runs.run({{scene}, technique}).rmse8);
}

std::string listed(const std::vector<std::string>& names, const std::vector<double>& values) {
    std::string text;
    for (std::size_t i = 0; i < names.size(); ++i)
        text += fmt::format("{}{} {:.2f}", i == 0 ? "" : ", ", names[i], values[i]);
    return text;
}

Finding ranking(ClaimRuns& runs, const AdaptiveScene& row) {
    std::vector<std::string> names{adaptive(row.nodes), stochastic(row.samples), kMaps[0], kMaps[1],
                                   "alpha_blend"};
    std::vector<double> errors;
    for (const std::string& name : names) errors.push_back(rmse(runs, row.scene, name));
    const double others = *std::min_element(errors.begin() + 1, errors.end());
    return {{},
            errors,
            {{fmt::format("our scene {}", row.scene), {}, errors[0] < others}},
            "RMSE in 1/255: " + listed(names, errors)};
}

void add_scene_quality(std::vector<Claim>& claims, const AdaptiveScene& row) {
    claims.push_back({fmt::format("at-quality-{}", row.scene), kAdaptivePaper, "abstract, section 5.1",
                      fmt::format("AT is of higher quality than ST, OSMT and FOMT, {}", row.scene),
                      Printed::statement("higher quality ... than other approximate techniques"),
                      rule::statement(), Basis::kAssets,
                      fmt::format("RMSE against exact compositing; AT, ST with {} samples, {}, opacity map, "
                                  "Fourier map, blending",
                                  row.samples, row.from),
                      true, [&row](ClaimRuns& runs) { return ranking(runs, row); }});
    claims.push_back(
        {fmt::format("at-indistinguishable-{}", row.scene), kAdaptivePaper, "figure 1, sections 5.1, 6",
         fmt::format("{} nodes represent {} so that it is nearly indistinguishable: RMSE, 1/255", row.nodes,
                     row.scene),
         Printed::meaning("nearly indistinguishable: taken as at most 1 of 255", 1, 0), rule::at_most(),
         Basis::kAssets, "RMSE against exact compositing", true, [&row](ClaimRuns& runs) {
             const double error = rmse(runs, row.scene, adaptive(row.nodes));
             return Finding{{},
                            {error},
                            {{fmt::format("our scene {}", row.scene), {error}}},
                            "the paper compares by eye"};
         }});
    claims.push_back(
        {fmt::format("at-half-{}", row.scene), kAdaptivePaper, "section 5.4",
         fmt::format(
             "AT often exhibits better quality than ST even with 50% less samples: RMSE of 8 nodes over "
             "16 samples, {}",
             row.scene),
         Printed::meaning("better: below 1", 1, 0), rule::at_most(), Basis::kAssets, "RMSE of two runs", true,
         [&row](ClaimRuns& runs) {
             const double ratio = half_samples_error(runs, row.scene);
             return Finding{
                 {},
                 {ratio},
                 {{fmt::format("our scene {}", row.scene), {ratio}}},
                 fmt::format("{:.3f} over {:.3f} of 255, of {} and {} bits a pixel; the paper "
                             "compares by eye",
                             rmse(runs, row.scene, adaptive(8)), rmse(runs, row.scene, stochastic(16)),
                             declared_cost(adaptive(8)).storage_bits,
                             declared_cost(stochastic(16)).storage_bits)};
         }});
}

constexpr std::array<const char*, 3> kRemovals{"underestimate", "overestimate", "node_by_node"};

// Which removal has the least of a measure.
std::string least_of(const std::array<const char*, 3>& names, const std::vector<double>& values) {
    return names.at(static_cast<std::size_t>(std::ranges::min_element(values) - values.begin()));
}

void add_removal(std::vector<Claim>& claims) {
    for (const AdaptiveScene& row : kScenes) {
        claims.push_back(
            {fmt::format("at-removal-{}", row.scene), kAdaptivePaper, "section 3.2, figure 5",
             fmt::format("The best image is obtained by always underestimating, {}", row.scene),
             Printed::statement("the best image quality"), rule::statement(), Basis::kAssets,
             "RMSE with 8 nodes: underestimation, overestimation, node by node", true,
             [&row](ClaimRuns& runs) {
                 std::vector<double> errors;
                 std::vector<double> flips;
                 for (const char* removal : kRemovals) {
                     const RunRecord& run =
                         runs.run({{row.scene}, fmt::format("adaptive:nodes=8,removal={}", removal)});
                     errors.push_back(number_of(run.rmse8));
                     flips.push_back(number_of(run.flip));
                 }
                 return Finding{
                     {},
                     errors,
                     {{fmt::format("our scene {}", row.scene),
                       {},
                       errors[0] < errors[1] && errors[0] < errors[2]}},
                     fmt::format("best by RMSE is {}, by FLIP ({:.4f}, {:.4f}, {:.4f}) {}; the paper "
                                 "prefers by eye, for high-frequency artifacts of node by node",
                                 least_of(kRemovals, errors), flips[0], flips[1], flips[2],
                                 least_of(kRemovals, flips))};
             }});
    }
}

void add_fourier(std::vector<Claim>& claims) {
    claims.push_back(
        {"at-fomt-smoke", kAdaptivePaper, "section 5.1.1",
         "Fourier maps ring on thin blockers and darken the smoke heavily: mean signed error of covered "
         "pixels, "
         "1/255",
         Printed::meaning("heavily darkened smoke: taken as at most -5 of 255", -5, 0), rule::at_most(),
         Basis::kAssets,
         "mean signed error of 7 and 15 coefficients over the pixels with a transparent fragment; the others "
         "have none",
         true, [](ClaimRuns& runs) {
             std::vector<double> mean;
             std::vector<double> error;
             for (const char* technique :
                  {"fourier_map", "fourier_map:coefficients=15,coefficients_format=float32"}) {
                 const RunRecord& run = runs.run({{"smoke"}, technique});
                 // The errors' squares have the same sum over covered pixels as over all.
                 const double share = std::pow(number_of(run.rmse8) / number_of(run.rmse8_covered), 2);
                 mean.push_back(number_of(run.mean_signed8) / share);
                 error.push_back(number_of(run.rmse8_covered));
             }
             return Finding{{},
                            mean,
                            {{"our scene smoke", {mean[0]}}},
                            fmt::format("7 coefficients, and 15; RMSE of the same pixels {:.2f} and {:.2f}",
                                        error[0], error[1])};
         }});
    claims.push_back(
        {"at-st-noise", kAdaptivePaper, "section 2",
         "Stochastic transparency needs many samples: noise increases with depth complexity, RMSE of 8 "
         "samples, 4, 16 and 64 layers",
         Printed::statement("noise increases with depth complexity"), rule::statement(), Basis::kDefinition,
         "layers of alpha .15 of random colour and depth, 8 samples, corrected by the depth-based method",
         true, [](ClaimRuns& runs) {
             std::vector<double> errors;
             for (const int layers : {4, 16, 64}) {
                 ClaimTrace trace{"layers", "64x64", "32x32"};
                 trace.layers = layers;
                 trace.alpha = 0.15;
                 errors.push_back(number_of(runs.run({trace, stochastic(8)}).rmse8));
             }
             return Finding{{},
                            errors,
                            {{"", {}, errors[0] < errors[1] && errors[1] < errors[2]}},
                            "of random colours and depths, corrected by total alpha"};
         }});
}

}  // namespace

const AdaptiveScene& adaptive_scene(const std::string& scene) {
    const AdaptiveScene* row = std::ranges::find(kScenes, scene, &AdaptiveScene::scene);
    CHECK(row != std::end(kScenes), "{}", scene);
    return *row;
}

double half_samples_error(ClaimRuns& runs, const std::string& scene) {
    return rmse(runs, scene.c_str(), adaptive(8)) / rmse(runs, scene.c_str(), stochastic(16));
}

void add_adaptive_quality_claims(std::vector<Claim>& claims) {
    for (const AdaptiveScene& row : kScenes) add_scene_quality(claims, row);
    add_removal(claims);
    add_fourier(claims);
}

}  // namespace ropsim
