// The lists that make up the claims of Salvi et al. 2011.
#pragma once

#include "analysis/claims.h"

#include <vector>

namespace ropsim {

inline constexpr const char* kAdaptivePaper = "Salvi et al. 2011";

// What the curve keeps: enumerated over random layers.
void add_adaptive_curve_claims(std::vector<Claim>& claims);
// Errors and times on our scenes.
void add_adaptive_quality_claims(std::vector<Claim>& claims);
// Section 5.4 and figure 10.
void add_adaptive_bandwidth_claims(std::vector<Claim>& claims);

}  // namespace ropsim
