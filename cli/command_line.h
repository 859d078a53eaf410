// The command line of `ropsim` as a whole.
#pragma once

#include <memory>

#include <CLI/CLI.hpp>

namespace ropsim {

// With all commands. Parsing runs the one that was named, which throws what it throws.
std::unique_ptr<CLI::App> make_command_line();

// The exit code: 0, or 2 where the command line is at fault, which stderr then says. Throws as the command
// does.
int run_command_line(int argc, const char* const* argv);

}  // namespace ropsim
