// Rows of text as an aligned table and as CSV.
#pragma once

#include <string>
#include <vector>

namespace ropsim {

// Rows of equal length, the first column to the left, the others to the right; a line each, no spaces at its
// end. A row of one field may be longer than its column.
std::string aligned_table(const std::vector<std::vector<std::string>>& rows);

// A field of CSV: in quotes where it holds a comma, a quote or a line's end.
std::string csv_field(const std::string& text);

}  // namespace ropsim
