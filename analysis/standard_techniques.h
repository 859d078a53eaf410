// The techniques that studies over all of them run when none is named; a new technique takes part, at its
// defaults, without a line here.
#pragma once

#include "rop/operation.h"

#include <string>
#include <vector>

namespace ropsim {

// For traces without one of their own: techniques may ask how far a depth is.
Camera plain_camera();
// With all that a technique may ask of a trace.
Screen screen_with_camera();

// The technique as its paper leads with it (headline_parameters, else defaults).
std::string at_default(const TechniqueInfo& technique);

// Every technique whose image is colour, as its paper leads with it (headline_parameters, else defaults), in
// the order of the registry.
std::vector<std::string> techniques_at_defaults();

// The configurations at which the published techniques are compared: their papers' sizes, and modes that
// change bytes or error by much.
const std::vector<std::string>& standard_configurations();
// Those of them that are registered, and every other technique whose image is colour at its defaults.
std::vector<std::string> standard_techniques();

// What techniques of a kind have in common, for the markers of a plot.
const std::vector<std::string>& technique_families();
// Index into technique_families(); the last for a technique it does not know.
std::size_t family_of(const std::string& technique);

// Why the technique cannot run on a trace of this header, or makes no colour image, as a line without
// "--technique"; empty: it can.
std::string refusal(const std::string& technique, const TraceHeader& header);

}  // namespace ropsim
