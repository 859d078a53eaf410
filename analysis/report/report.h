// The report of comparisons: one HTML page that needs nothing else.
#pragma once

#include "analysis/comparison.h"
#include "analysis/report/report_views.h"

#include <string>
#include <vector>

namespace ropsim {

struct ReportOptions {
    std::string title = {};                // empty: a plain one
    std::string command = {};              // that made the page
    std::vector<PixelPlace> inspect = {};  // pixels the inspector must know, inside every trace
    ReportBudget budget = {};              // of the page, shared out among the traces
};

// Writes the page to `path`, atomically: a section a trace with a table of numbers, a plot to pick axes of,
// bytes by surface, cycles by label, pictures and their inspector, configuration, and the command that
// repeats each run. Reads image.exr and tiles.exr of each run; one that cannot be read is reported in its
// place. Throws UserError when the file cannot be written.
void write_report(const std::vector<ComparisonOfOneTrace>& comparisons, const ReportOptions& options,
                  const std::string& path);

// The page as text.
std::string report_html(const std::vector<ComparisonOfOneTrace>& comparisons, const ReportOptions& options);

}  // namespace ropsim
