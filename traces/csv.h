// Fragments as comma-separated text, in arrival order: import to a trace, export from one.
#pragma once

#include <string>

namespace ropsim {

// Reads the CSV file twice (once to learn the size and the draws) and writes a trace of float32 colours.
// Every fault is a UserError that names file, line and column.
void import_csv(const std::string& csv_path, const std::string& trace_path);

// Writes all fragments, losslessly: premultiplied R, G, B, and numbers that read back to the same bits. The
// opaque layer and the draws' states have no place in a CSV file and are left out. Throws UserError.
void export_csv(const std::string& trace_path, const std::string& csv_path);

}  // namespace ropsim
