// What commands that run several techniques have in common.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace ropsim {

// Declares --technique, which repeats and may be left out.
void add_technique_option(CLI::App& command, std::vector<std::string>& techniques,
                          const std::string& description);

// Throws UserError for a preset, file or key=value that no run would take.
void check_hardware(const std::string& hardware, const std::vector<std::string>& settings);

}  // namespace ropsim
