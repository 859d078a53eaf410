// The techniques that studies over all of them run when none is named: made from what is registered, so that
// a new technique takes part without a line here.
#pragma once

#include "rop/operation.h"

#include <string>
#include <vector>

namespace ropsim {

// Every technique whose image is colour, as its paper leads with it (headline_parameters, else defaults), in
// the order of the registry.
std::vector<std::string> techniques_at_defaults();

// The same and, behind each, its further standard sizes and modes, as far as it takes them and they differ:
// kStandardSizes of whichever of these keys it has, and kStandardModes.
std::vector<std::string> standard_techniques();

// What a technique spends its memory on, by key, and the sizes at which techniques are compared.
struct StandardSizes {
    const char* key;
    std::vector<int> sizes;
};
const std::vector<StandardSizes>& standard_sizes();
// Whole techniques besides: modes that change bytes or error by much.
const std::vector<std::string>& standard_modes();

// What techniques of a kind have in common, for the markers of a plot.
const std::vector<std::string>& technique_families();
// Index into technique_families(); the last for a technique it does not know.
std::size_t family_of(const std::string& technique);

// For a trace of this header. `objects` as in the run.
Screen screen_of(const TraceHeader& header, std::uint64_t seed);

}  // namespace ropsim
