// Parts of the stability study's tables for readers.
#pragma once

#include "analysis/stress/stress_study.h"
#include "analysis/stress/stress_summary.h"

#include <string>
#include <vector>

namespace ropsim {

void add_row(std::string& text, const std::vector<std::string>& fields);
void add_heading(std::string& text, const std::vector<std::string>& fields);
// A difference in units of 1/255; "-" where it was not measured.
std::string in_255(double value);

// What is no colour in combinations whose formats hold what their surfaces declare; and what goes wrong in
// those of which that was known beforehand not to be so, with the bits that a cure costs.
void add_fault_tables(std::string& text, const StressStudy& study,
                      const std::vector<VariantSummary>& summaries);

}  // namespace ropsim
