// A page of prose in which the study's tables stand between marks, so that one command renews them.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace ropsim {

// A table's name and text.
using StressBlock = std::pair<std::string, std::string>;

// `page` with what stands between "<!-- stress NAME -->" and "<!-- end NAME -->" replaced by the block of
// that name; blocks that it has no marks for are left out. Throws UserError, naming `where`, where it has
// marks for none, or an end is missing.
std::string with_stress_blocks(const std::string& page, const std::string& where,
                               const std::vector<StressBlock>& blocks);

}  // namespace ropsim
