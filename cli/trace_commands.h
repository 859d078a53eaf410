// The commands of `ropsim trace`: each declares its options and the callback that runs it.
#pragma once

#include <string_view>

#include <CLI/CLI.hpp>

namespace ropsim {

void add_trace_info(CLI::App& trace);
void add_trace_import(CLI::App& trace);
void add_trace_export(CLI::App& trace);
void add_trace_cut(CLI::App& trace);
void add_trace_order(CLI::App& trace);
void add_trace_opaque(CLI::App& trace);
void add_trace_stress(CLI::App& trace);
void add_trace_volume(CLI::App& trace);

}  // namespace ropsim
