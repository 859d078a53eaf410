// Parts of run.json on memory: bytes by surface and cause, caches, compression, DRAM.
#pragma once

#include "model/run.h"

#include <nlohmann/json_fwd.hpp>

namespace ropsim {

// Of all surfaces together, without caches.
SurfaceTraffic traffic_total(const RunResult& result);

// What a run's fidelity does not measure is null.
nlohmann::ordered_json traffic_json(const RunResult& result);
nlohmann::ordered_json cache_json(const RunResult& result);
nlohmann::ordered_json compression_json(const RunResult& result);
nlohmann::ordered_json l2_json(const RunResult& result);
nlohmann::ordered_json dram_json(const RunResult& result);

}  // namespace ropsim
