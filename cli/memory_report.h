// What `ropsim memory` prints of a run.
#pragma once

#include "base/parameters.h"
#include "memory/memory_run.h"

#include <string>

namespace ropsim {

// As JSON text; a latency is null when there was no read.
std::string memory_run_json(const MemoryRun& run, const MemoryConfig& config, const Parameters& parameters);
// For people.
std::string memory_run_text(const MemoryRun& run, const MemoryConfig& config);

}  // namespace ropsim
