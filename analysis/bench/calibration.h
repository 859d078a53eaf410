// A fixed piece of work by which the speed of this machine, at this moment, is told.
#pragma once

namespace ropsim {

// Processor seconds of the calling thread for blending 4 million made-up fragments into 2 MiB of pixels,
// written by hand: hashes, floats, and scattered reads and writes, as the simulator's own loops have them. A
// run's processor time over this says how slow the simulator is, whatever clock the machine grants at the
// moment.
double calibration_seconds();

}  // namespace ropsim
