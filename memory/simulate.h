// Runs SystemC's kernel until nothing is left to do.
#pragma once

namespace ropsim {

// sc_start(), and then throws what a step of an EventWheel has thrown, which ends the simulation. Left to the
// kernel it would come out as a report of several lines without the file or option that is at fault.
void simulate();

}  // namespace ropsim
