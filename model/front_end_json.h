// Part of run.json: what the front end did.
#pragma once

#include "model/run.h"

#include <nlohmann/json_fwd.hpp>

namespace ropsim {

// Null below fidelity cached.
nlohmann::ordered_json front_end_json(const RunResult& result);

}  // namespace ropsim
