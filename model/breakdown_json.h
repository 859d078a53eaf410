// Parts of run.json that say who moved bytes, where, and how long reads took.
#pragma once

#include "model/run.h"

#include <nlohmann/json_fwd.hpp>

namespace ropsim {

// Null where nothing was cached: below fidelity cached, latencies below timed.
nlohmann::ordered_json traffic_by_pass_json(const RunResult& result);
nlohmann::ordered_json traffic_by_draw_json(const RunResult& result);
nlohmann::ordered_json channels_json(const RunResult& result);
nlohmann::ordered_json read_latency_json(const RunResult& result);

}  // namespace ropsim
