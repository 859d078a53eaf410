// A page of prose in which the study's tables stand between marks, so that one command renews them.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ropsim {

// The tables of the matrix; that of the search is "worst".
inline constexpr std::array<std::string_view, 4> kStressMatrixBlocks{"faults", "rounding", "bits", "hazards"};

// A table's name and text.
using StressBlock = std::pair<std::string, std::string>;

// `page` with what stands between "<!-- stress NAME -->" and "<!-- end NAME -->" replaced by the block of
// that name; blocks that it has no marks for are left out. Throws UserError, naming `where`, where it has
// marks for none, or an end is missing.
std::string with_stress_blocks(const std::string& page, const std::string& where,
                               const std::vector<StressBlock>& blocks);
// Throws what that will throw for blocks of these names, before there is anything to put into them.
void check_stress_page(const std::string& page, const std::string& where,
                       std::span<const std::string_view> names);

}  // namespace ropsim
