// All claims, in the order in which they are shown.
#include "analysis/claims/list.h"

#include <algorithm>

namespace ropsim {

const std::vector<Claim>& all_claims() {
    static const std::vector<Claim> claims = [] {
        std::vector<Claim> all;
        add_stochastic_claims(all);
        add_laine_karras_claims(all);
        add_layered_claims(all);
        add_adaptive_claims(all);
        add_phenomenological_claims(all);
        add_timing_claims(all);
        // A section a paper, whatever list a claim is in.
        std::vector<std::string> papers;
        for (const Claim& claim : all)
            if (std::ranges::find(papers, claim.paper) == papers.end()) papers.push_back(claim.paper);
        std::ranges::stable_sort(all, {}, [&](const Claim& claim) {
            return std::ranges::find(papers, claim.paper) - papers.begin();
        });
        return all;
    }();
    return claims;
}

}  // namespace ropsim
