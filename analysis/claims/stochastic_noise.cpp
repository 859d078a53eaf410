// Claims of Enderton et al. 2011 about noise, on a scene and on pixels of several layers.
#include "analysis/claims/list.h"

#include <algorithm>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr const char* kPaper = "Enderton et al. 2011";

// Errors of two techniques on our scene.
struct Noise {
    const char* id;
    const char* place;
    const char* claim;
    const char* printed;
    const char* better;
    const char* worse;
    const char* why;
};

void add_noise(std::vector<Claim>& claims) {
    const auto add = [&](const Noise& row) {
        claims.push_back(
            {row.id, kPaper, row.place, row.claim, Printed::statement(row.printed), rule::statement(),
             Basis::kAssets, "RMSE of both on our scene motor", true, [row](ClaimRuns& runs) {
                 const ClaimTrace motor{"motor", "500x500", "125x125"};
                 const double better = number_of(runs.run({motor, row.better}).rmse8);
                 const double worse = number_of(runs.run({motor, row.worse}).rmse8);
                 return Finding{{},
                                {better, worse},
                                {{"our scene motor", {}, better < worse}},
                                fmt::format("RMSE {:.2f} and {:.2f}; {}", better, worse, row.why)};
             }});
    };
    add({"st-noise-stratified", "section 3.1", "Stratified masks have less noise than coins",
         "we do still benefit significantly", "stochastic:samples=8", "stochastic:samples=8,masks=coin",
         "8 samples"});
    add({"st-noise-depth", "section 3.4", "Depth-based is significantly less noisy than the basic method",
         "almost always significantly less noisy", "stochastic:samples=8,method=depth_based",
         "stochastic:samples=8,correction=coverage", "8 samples, both corrected"});
    add({"st-noise-two-rounds", "section 3.5, footnote 3",
         "Two rounds of 8 samples are noisier than one of 16", "noisier than one 16-sample image",
         "stochastic:samples=16,method=depth_based",
         "stochastic:samples=16,method=depth_based,hardware_samples=8,strata=pass",
         "masks stratified by round"});
    add({"st-noise-strata", "section 4.2, footnote 4",
         "Masks stratified across all rounds are slightly better than by round", "slightly improved",
         "stochastic:samples=16,method=depth_based,hardware_samples=8,strata=all",
         "stochastic:samples=16,method=depth_based,hardware_samples=8,strata=pass",
         "16 samples in two rounds"});
}

// The paper speaks of pixels of several layers alone; a scene has others, which become exact.
void add_corrected(std::vector<Claim>& claims) {
    claims.push_back(
        {"st-noise-corrected", kPaper, "section 3.3",
         "Alpha correction reduces the error of pixels of several layers",
         Printed::statement("the error in multilayer pixels is reduced overall"), rule::statement(),
         Basis::kDefinition, "RMSE with 8 samples over pixels of 2, 4, 8 and 16 random layers, random order",
         true, [](ClaimRuns& runs) {
             ClaimTable table{{"layers a pixel", "RMSE, corrected", "as it is"}, {}};
             std::vector<double> ratios;
             for (const int layers : {2, 4, 8, 16}) {
                 ClaimTrace trace{"layers", "64x64", "32x32"};
                 trace.layers = layers;
                 const double corrected =
                     number_of(runs.run({trace, "stochastic:samples=8,correction=coverage"}).rmse8);
                 const double as_it_is = number_of(runs.run({trace, "stochastic:samples=8"}).rmse8);
                 table.rows.push_back({std::to_string(layers), fmt::format("{:.2f}", corrected),
                                       fmt::format("{:.2f}", as_it_is)});
                 ratios.push_back(corrected / as_it_is);
             }
             return Finding{{},
                            ratios,
                            {{"", {}, std::ranges::all_of(ratios, [](double r) { return r < 1; })}},
                            "measured: ratio of errors with 2, 4, 8 and 16 layers",
                            table};
         }});
}

}  // namespace

void add_stochastic_noise_claims(std::vector<Claim>& claims) {
    add_noise(claims);
    add_corrected(claims);
}

}  // namespace ropsim
