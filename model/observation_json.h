// Parts of run.json on what was seen while the machine ran.
#pragma once

#include "model/run.h"

#include <nlohmann/json_fwd.hpp>

namespace ropsim {

// What a run's fidelity does not measure is null.
nlohmann::ordered_json bottlenecks_json(const RunResult& result);
nlohmann::ordered_json occupancy_json(const RunResult& result);
nlohmann::ordered_json passes_json(const RunResult& result);
// Of caches of other sizes, by sampled stack distances.
nlohmann::ordered_json reuse_json(const RunResult& result);

}  // namespace ropsim
