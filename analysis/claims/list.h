// The claims, a list a paper.
#pragma once

#include "analysis/claims/claims.h"

#include <vector>

namespace ropsim {

void add_adaptive_claims(std::vector<Claim>& claims);
void add_phenomenological_claims(std::vector<Claim>& claims);
void add_stochastic_claims(std::vector<Claim>& claims);
void add_stochastic_bias_claims(std::vector<Claim>& claims);   // of add_stochastic_claims
void add_stochastic_cost_claims(std::vector<Claim>& claims);   // of add_stochastic_claims
void add_stochastic_noise_claims(std::vector<Claim>& claims);  // of add_stochastic_claims
void add_laine_karras_claims(std::vector<Claim>& claims);
void add_laine_karras_table_claims(std::vector<Claim>& claims);  // of add_laine_karras_claims
void add_layered_claims(std::vector<Claim>& claims);
void add_layered_quality_claims(std::vector<Claim>& claims);  // of add_layered_claims
void add_timing_claims(std::vector<Claim>& claims);           // of all papers

}  // namespace ropsim
