// The report of comparisons: one HTML page that needs nothing else.
#pragma once

#include "analysis/comparison.h"

#include <string>
#include <vector>

namespace ropsim {

// Writes the page to `path`, atomically: a section a trace with a table of numbers, bytes by surface, cycles
// by label, pictures, configuration, and the command that repeats each run. Reads image.exr of each run; one
// that cannot be read is reported in its place. An empty title gets a plain one. Throws UserError when the
// file cannot be written.
void write_report(const std::vector<ComparisonOfOneTrace>& comparisons, const std::string& title,
                  const std::string& path);

// The page as text.
std::string report_html(const std::vector<ComparisonOfOneTrace>& comparisons, const std::string& title);

}  // namespace ropsim
