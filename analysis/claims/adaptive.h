// The lists that make up the claims of Salvi et al. 2011.
#pragma once

#include "analysis/claims/claims.h"

#include <string>
#include <vector>

namespace ropsim {

inline constexpr const char* kAdaptivePaper = "Salvi et al. 2011";

// Of a technique with lists: a node's and a pixel's, as declared.
struct ListBytes {
    double node = 0;
    double head = 0;
};
ListBytes stored_list_bytes(int spatial_samples, const std::string& technique = "adaptive:memory=variable");
// A pixel's of a visibility map; with the colour that is accumulated, or without.
double stored_map_bytes(const std::string& technique, int spatial_samples, bool with_color);
// A pixel's of depth-based stochastic transparency with its sums a spatial sample.
double stored_stochastic_bytes(int samples, int spatial_samples);

// A scene of the paper with the nodes that figure 1 gives it and the samples of stochastic transparency,
// which figure 6 gives and the text at hand has not.
struct AdaptiveScene {
    const char* scene;
    int nodes;
    int samples;
    const char* from;  // where the samples are from
};
// "smoke", "hair" or "forest".
const AdaptiveScene& adaptive_scene(const std::string& scene);
// RMSE of 8 nodes over that of 16 samples, our scene: section 5.4's "50% less samples".
double half_samples_error(ClaimRuns& runs, const std::string& scene);

// Table 1, and what the text says against it.
void add_adaptive_table_claims(std::vector<Claim>& claims);
// What the curve keeps: enumerated over random layers.
void add_adaptive_curve_claims(std::vector<Claim>& claims);
// Errors on our scenes.
void add_adaptive_quality_claims(std::vector<Claim>& claims);
// The prototype with lists: traversals and times.
void add_adaptive_prototype_claims(std::vector<Claim>& claims);
// Section 5.4 and figure 10.
void add_adaptive_bandwidth_claims(std::vector<Claim>& claims);

}  // namespace ropsim
