// The pictures of rows that have one.
#pragma once

#include "analysis/claims/claims.h"

#include <string>
#include <vector>

namespace ropsim {

// DIRECTORY/NAME.svg, .png and .csv of each, each atomically; the directory is made if there is one to write.
// Throws UserError when gnuplot is missing or fails.
void write_claim_plots(const std::vector<ClaimResult>& results, const std::string& directory);

}  // namespace ropsim
