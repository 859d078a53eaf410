// The numbers by which techniques are compared, as columns of a table.
#pragma once

#include "analysis/run_record.h"

#include <functional>
#include <string>
#include <vector>

namespace ropsim {

struct ComparisonColumn {
    std::string group;  // of neighbours that belong together; may be empty
    std::string heading;
    std::string unit;
    std::string meaning;  // one line
    int decimals;
    std::function<Measured(const RunRecord&)> value;
};

// Error, storage, traffic, time.
const std::vector<ComparisonColumn>& comparison_columns();
// ROP cache and DRAM; empty below `cached`.
const std::vector<ComparisonColumn>& memory_columns();

// With a thousands separator of a narrow gap ("," in plain text), the given decimals, "inf", or `absent`.
std::string format_measured(const Measured& value, int decimals, const std::string& separator,
                            const std::string& absent);

// Read and write bytes together; empty when neither was measured.
Measured sum_of(const Measured& read, const Measured& write);

// Aligned plain text: two heading lines (names, units), a line a run; failed runs show their reason. Ends in
// a newline.
std::string comparison_table(const std::vector<RunRecord>& runs);

}  // namespace ropsim
