// The commands of `ropsim`, one file each: add_X_command declares the options and the callback that runs it.
#pragma once

#include <CLI/CLI.hpp>

namespace ropsim {

void add_ambient_command(CLI::App& app);
void add_bench_command(CLI::App& app);
void add_cache_sizes_command(CLI::App& app);
void add_capture_command(CLI::App& app);
void add_claims_command(CLI::App& app);
void add_compare_command(CLI::App& app);
void add_compression_command(CLI::App& app);
void add_convergence_command(CLI::App& app);
void add_cost_command(CLI::App& app);
void add_curve_command(CLI::App& app);
void add_diff_command(CLI::App& app);
void add_list_command(CLI::App& app);
void add_memory_command(CLI::App& app);
void add_order_sensitivity_command(CLI::App& app);
void add_reference_command(CLI::App& app);
void add_run_command(CLI::App& app);
void add_scenes_command(CLI::App& app);
void add_shadow_command(CLI::App& app);
void add_stress_command(CLI::App& app);
void add_sweep_command(CLI::App& app);
void add_trace_command(CLI::App& app);
void add_tradeoff_command(CLI::App& app);
void add_timings_command(CLI::App& app);
void add_validate_command(CLI::App& app);

}  // namespace ropsim
