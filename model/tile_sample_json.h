// Estimates in run.json.
#pragma once

#include "model/tile_sample.h"

#include <nlohmann/json_fwd.hpp>

namespace ropsim {

// Puts {"value":..., "ci95":[lo,hi]} where an estimate belongs, and null where a number of the sampled tiles
// alone stands.
void put_estimates(const TileSample& sample, nlohmann::ordered_json& json);

}  // namespace ropsim
