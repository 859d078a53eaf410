// Claims of Wyman 2016, "Stochastic Layered Alpha Blending".
#include "analysis/claims_list.h"
#include "rop/nodes/insertion_probability.h"

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr const char* kPaper = "Wyman 2016";

}  // namespace

void add_layered_claims(std::vector<Claim>& claims) {
    claims.push_back(
        {"slab-limit", kPaper, "section 2.1", "With more coverage bits P_b goes to 1",
         Printed::meaning("P_b -> 1", 1, 0.005), rule::digits(), Basis::kDefinition,
         "equation 1 for alpha .1 behind .9 with 10, 40, 160 and 640 bits", false, [](ClaimRuns&) {
             std::vector<double> values;
             for (const int bits : {10, 40, 160, 640})
                 values.push_back(static_cast<double>(InsertionProbability(bits, CoverageBits::kStratified)
                                                          .at(static_cast<std::uint32_t>(bits * 9 / 10),
                                                              static_cast<std::uint32_t>(bits / 10))));
             return Finding{{},
                            values,
                            {{"coverage in front below 1", {values.back()}}},
                            "behind full coverage P is 0 for every b"};
         }});
}

}  // namespace ropsim
