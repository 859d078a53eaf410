// The lists that make up the claims of McGuire and Mara 2017.
#pragma once

#include "analysis/claims/claims.h"

#include <vector>

namespace ropsim {

inline constexpr const char* kPhenomenologicalPaper = "McGuire and Mara 2017";

// Equations against listings, precision, and Table 1's arithmetic.
void add_phenomenological_listing_claims(std::vector<Claim>& claims);
// Listing 1's operations.
void add_phenomenological_operation_claims(std::vector<Claim>& claims);
// Bytes of runs, and shadow maps.
void add_phenomenological_traffic_claims(std::vector<Claim>& claims);
// Table 1's milliseconds.
void add_phenomenological_time_claims(std::vector<Claim>& claims);

}  // namespace ropsim
