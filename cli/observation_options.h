// The options that say what to look at while the timed machine runs, and the files that come of it.
#pragma once

#include "model/machine_observation.h"

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace ropsim {

class ObservationFiles {
 public:
    void add_to(CLI::App& command);
    // Checks what was given, and that the files can be written: before a long run. Throws UserError.
    ObservationOptions prepare(const std::vector<std::string>& inputs, bool timed);
    void write(const MachineObservation& observation) const;

 private:
    ObservationOptions options_;
    std::string timeline_;
    std::string vcd_;
    std::string window_ = "0:20000";
};

}  // namespace ropsim
