// What a run did not have to do, in run.json; and the switch that is the technique's.
#pragma once

#include "model/run.h"

#include <nlohmann/json_fwd.hpp>

namespace ropsim {

// Counts over all passes; null where the fidelity does not know or the technique cannot.
nlohmann::ordered_json skipped_json(const RunResult& result);

// Turns the technique's early termination on. Throws UserError where it has none.
void end_saturated_pixels(TechniqueSpec& technique);

}  // namespace ropsim
