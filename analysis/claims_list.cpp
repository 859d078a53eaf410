// All claims, in the order in which they are shown.
#include "analysis/claims_list.h"

namespace ropsim {

const std::vector<Claim>& all_claims() {
    static const std::vector<Claim> claims = [] {
        std::vector<Claim> all;
        add_stochastic_claims(all);
        add_laine_karras_claims(all);
        add_layered_claims(all);
        add_adaptive_claims(all);
        add_phenomenological_claims(all);
        add_comparator_claims(all);
        add_timing_claims(all);
        return all;
    }();
    return claims;
}

}  // namespace ropsim
