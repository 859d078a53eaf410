// Fragments as comma-separated text, in arrival order: import to a trace, export from one.
#pragma once

#include <string>
#include <vector>

namespace ropsim {

// Writes a trace of what the CSV file holds (docs/interchange.md); a file without '# size' and '# draws' is
// read twice to learn them. Returns what the user should know, a line each. Every fault is a UserError that
// names file, line and column.
std::vector<std::string> import_csv(const std::string& csv_path, const std::string& trace_path);

// Writes all fragments with their channels, losslessly: premultiplied R, G, B, numbers that read back to the
// same bits, values out of range and NaNs with their payload included. The opaque layer, the draws' names and
// states, the light and the camera's matrices have no place in a CSV file and are left out. Throws UserError.
void export_csv(const std::string& trace_path, const std::string& csv_path);

}  // namespace ropsim
