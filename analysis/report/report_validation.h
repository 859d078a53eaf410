// A validation as a page: the verdicts as a table, the model's image and OpenGL's under a slider.
#pragma once

#include "analysis/validation.h"

#include <cstddef>
#include <string>

namespace ropsim {

// Reads the difference EXR of each technique in the validation's directory; one that cannot be read is
// reported in its place. `command` repeats it. Pictures take at most `picture_bytes` of the page where that
// can be had.
std::string validation_report(const Validation& validation, const std::string& command,
                              std::size_t picture_bytes = 10'500'000);

}  // namespace ropsim
