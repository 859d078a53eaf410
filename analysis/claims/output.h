// Claims as a table, as JSON and as the page of the documentation.
#pragma once

#include "analysis/claims/claims.h"

#include <string>
#include <vector>

namespace ropsim {

// A line each: id, printed, worst case, measured, verdict.
std::string claims_table(const std::vector<ClaimResult>& results);
// A list of {id, paper, place, claim, printed, worst_case, measured, verdict, why, ...}; a value is a number,
// a list of numbers, or null where there is none.
std::string claims_json(const std::vector<ClaimResult>& results, bool quick);
// A section a paper, a row a claim, with the tables that rows stand on.
std::string claims_markdown(const std::vector<ClaimResult>& results, bool quick);

}  // namespace ropsim
