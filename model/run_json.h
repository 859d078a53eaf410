// A run's results as JSON: every number with its meaning in docs/results.md, what was not measured as null.
#pragma once

#include "model/run.h"

#include <string>

namespace ropsim {

// The text of run.json. Same inputs, same text, `host` apart.
std::string run_json(const RunResult& result);

}  // namespace ropsim
