// Rows of `ropsim claims --json` and of studies as sections of a report.
#pragma once

#include "analysis/report/report_page.h"

#include <string>

namespace ropsim {

// `rows`: a JSON array of objects {id, paper, place, claim, printed, worst_case, measured, verdict, why}. A
// table to filter by paper, verdict and text, the verdicts counted above it; `command` repeats it. Keys that
// are missing stay empty. Throws UserError{name, ...} for anything but an array of objects.
ReportSection claims_section(const std::string& rows, const std::string& command,
                             const std::string& name = "claims");

// `rows`: a JSON array of objects. Strings with few values are groups by which points may be coloured, the
// one under "name" (else the first) names the point; numbers, and estimates {"value", "ci95"}, are axes. `x`,
// `y`: axes picked first, may be empty. A plot, and the rows as a table. Throws UserError{name, ...} as
// above.
struct RowsSection {
    std::string id, heading, caption, command;
    std::string x = {}, y = {};
    bool log_x = false, log_y = false;
};
ReportSection rows_section(const std::string& rows, const RowsSection& section, const std::string& name);

// A whole page of the claims.
std::string claims_report(const std::string& rows, const std::string& command);
// `bench`: what `ropsim bench --json` prints; a section for each of its plots. Throws UserError{"bench", ...}
// for anything else.
std::string bench_report(const std::string& bench, const std::string& command);

}  // namespace ropsim
