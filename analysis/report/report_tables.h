// Tables and lists of a report, as HTML.
#pragma once

#include "analysis/comparison_table.h"

#include <string>
#include <vector>

namespace ropsim {

// With thin gaps between thousands; an en dash where nothing was measured.
std::string report_number(const Measured& value, int decimals);

// A row a run; failed runs show their reason. Columns that no run measured are left out; empty when none is
// left.
std::string number_table(const std::vector<RunRecord>& runs, const std::vector<ComparisonColumn>& columns);

// What is an estimate, and how sure, of runs of a sample of the frame.
std::string sample_notes(const std::vector<RunRecord>& runs);

// Control paths with how often they were taken; empty when no run knows.
std::string path_table(const std::vector<RunRecord>& runs);

// Keys with one value in all successful runs stand once; the others stand with their technique.
std::string configuration_list(const std::vector<RunRecord>& runs);

// The command that repeats each run.
std::string command_list(const std::vector<RunRecord>& runs);

}  // namespace ropsim
