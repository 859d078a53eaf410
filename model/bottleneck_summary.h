// Where the cycles of a timed run went, in sentences.
#pragma once

#include "model/machine_config.h"
#include "model/machine_result.h"

#include <string>
#include <vector>

namespace ropsim {

// From the top down: the cycles of the operation stages by their labels; fills by the surface they bring and
// by what keeps memory from bringing them sooner; cycles without a quad by what the tag stage and the front
// end did meanwhile. Largest share first; shares add up to 1. Every number is a counter of the run or a share
// of the probe's samples, and the sentence says so. Of engine `shader`: interlock_bottlenecks().
// `surfaces`: names.
std::vector<CycleCause> bottleneck_summary(const MachineResult& result, const MachineConfig& config,
                                           const std::vector<std::string>& surfaces);

// Of the cycles of the places that shader cores have for quads, by what the quads in them do after shading.
std::vector<CycleCause> interlock_bottlenecks(const MachineResult& result, const MachineConfig& config);

}  // namespace ropsim
