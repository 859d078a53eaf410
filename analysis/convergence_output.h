// A convergence study as JSON, CSV and plain text.
#pragma once

#include "analysis/convergence.h"

#include <string>

namespace ropsim {

// One object with every number, "units" saying what each is in; what was not measured is null. Same inputs,
// same text. `plotted`: whether the pictures were drawn.
std::string convergence_json(const Convergence& convergence, bool plotted);
// One line a technique, value and seed under a heading; a field with a comma stands in quotes, what was not
// measured is empty.
std::string convergence_csv(const Convergence& convergence);
// Aligned plain text: two heading lines, a line a technique and value, then each technique's slope. Ends in a
// newline.
std::string convergence_table(const Convergence& convergence);

}  // namespace ropsim
