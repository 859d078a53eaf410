// run.json's section on the tiled engine.
#pragma once

#include "model/run.h"

#include <nlohmann/json_fwd.hpp>

namespace ropsim {

// Of a run with the tiled engine.
nlohmann::ordered_json tiled_json(const RunResult& result);

}  // namespace ropsim
