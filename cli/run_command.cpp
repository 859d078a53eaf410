// `ropsim run`: one technique on one trace.
#include "base/error.h"
#include "base/outputs.h"
#include "base/parallel.h"
#include "cli/commands.h"
#include "cli/observation_options.h"
#include "model/run.h"
#include "rop/registry.h"

#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include <fmt/format.h>

namespace ropsim {
namespace {

// Throws what a misspelt run is refused with: before the results of an earlier one go.
void check_run(const RunOptions& run) {
    TechniqueSpec technique = parse_technique(run.technique, "--technique");
    Parameters hardware = hardware_parameters(run.hardware);
    for (const std::string& setting : run.settings) set_from_text(hardware, setting, "--set");
    machine_config(hardware, run.hardware);
    hardware.close();
    const TraceReader trace(run.trace);
    make_operation(technique, screen_of(trace.header(), run.seed));
}

struct RunCommandOptions {
    RunOptions run;
    std::string fidelity = "timed";
    std::string engine = "rop";
    std::string order = "trace";
    std::string sample_tiles = "100%";
    std::string directory;
    bool no_error = false;
    ObservationFiles observe;
};

// The causes that take a share worth a line.
void print_bottlenecks(const RunResult& result) {
    if (!result.machine) return;
    std::size_t lines = 0;
    for (const CycleCause& b : result.machine->observation.bottlenecks)
        if (b.share >= 0.05 && ++lines <= 4) fmt::print(stderr, "{}\n", b.text);
}

void run_command(RunCommandOptions options) {
    options.run.fidelity = options.fidelity == "count"    ? Fidelity::kCount
                           : options.fidelity == "cached" ? Fidelity::kCached
                                                          : Fidelity::kTimed;
    options.run.engine = options.engine == "shader"  ? Engine::kShader
                         : options.engine == "tiled" ? Engine::kTiled
                                                     : Engine::kRop;
    options.run.error = !options.no_error;
    options.run.order = options.order == "machine" ? Order::kMachine : Order::kTrace;
    options.run.sample_percent = sample_percent(options.sample_tiles, "--sample-tiles");
    keep_inputs(
        {options.run.trace, options.run.hardware},
        files_in(options.directory, {"run.json", "image.exr", "image.png", "tiles.exr", "tiles.png"}));
    options.run.observe = options.observe.prepare({options.run.trace, options.run.hardware},
                                                  options.run.fidelity == Fidelity::kTimed);
    // Before the simulation: one that is killed, or has not enough memory, must not leave them as its own.
    if (std::filesystem::exists(options.directory)) {
        check_run(options.run);
        start_directory(options.directory, {"run.json", "tiles.exr", "tiles.png"});
    }
    const RunResult result = run_simulation(options.run);
    if (result.machine) options.observe.write(result.machine->observation);
    write_run(result, options.directory);
    fmt::print(stderr, "{}: {} fragments", options.run.technique, result.fragments);
    if (result.sample && options.run.fidelity == Fidelity::kTimed) {
        const Estimate cycles = result.sample->cycles();
        fmt::print(stderr, ", {:.0f} cycles (95 % within {:.0f} to {:.0f})", cycles.value, cycles.low,
                   cycles.high);
    }
    if (result.machine)
        fmt::print(stderr, ", {} cycles ({:.3f} ms)", result.machine->rop_cycles,
                   1e3 * result.machine->seconds);
    if (result.error) fmt::print(stderr, ", RMSE {:.3f}/255", result.error->rmse8);
    fmt::print(stderr, "; {:.2f} s on the host\n", result.host_seconds);
    print_bottlenecks(result);
    fmt::print(stderr, "{}/run.json\n", options.directory);
    if (result.pool_nodes_overflowed > 0)
        fmt::print(
            stderr,
            "{} fragments were dropped: the node pool is full; give more with --set pool.mebibytes=N\n",
            result.pool_nodes_overflowed);
}

}  // namespace

void add_run_command(CLI::App& app) {
    auto options = std::make_shared<RunCommandOptions>();
    options->run.threads = default_threads();
    CLI::App* command = app.add_subcommand("run", "Simulates one technique on a trace");
    command->add_option("trace", options->run.trace, "Trace file")->required();
    command
        ->add_option("--technique", options->run.technique,
                     "NAME[:key=value,...]; see `ropsim list techniques`")
        ->required();
    command->add_option("--hardware", options->run.hardware,
                        "Preset or .toml file; see `ropsim list hardware`");
    command->add_option("--set", options->run.settings, "A hardware key=value, repeatable")
        ->expected(1)
        ->take_all();
    command
        ->add_option("--fidelity", options->fidelity,
                     "count: images, bytes without caches; cached: + bytes on the pins; timed: + cycles")
        ->check(CLI::IsMember({"count", "cached", "timed"}));
    command
        ->add_option(
            "--engine", options->engine,
            "Where the operation runs: rop (fixed function), shader (under an interlock), tiled (tile "
            "by tile, pixel state on chip)")
        ->check(CLI::IsMember({"rop", "shader", "tiled"}));
    command
        ->add_option("--order", options->order,
                     "Order of operations on a pixel: trace (raster order), machine (as it came to them)")
        ->check(CLI::IsMember({"trace", "machine"}));
    command->add_option("--seed", options->run.seed, "Seed of every random draw");
    command->add_option("--sample-tiles", options->sample_tiles,
                        "P%: simulate a sample of the frame, at most so much of it in time; results are "
                        "estimates with 95 % confidence intervals");
    command->add_option("--sample-seed", options->run.sample_seed,
                        "Seed of what is in the sample; else that of --seed");
    command->add_option("--threads", options->run.threads, "Threads on the host; results do not depend on it")
        ->check(CLI::Range(1, 1024));
    command->add_flag("--no-error", options->no_error,
                      "Leave out the comparison with the exact image, which large traces take long for: "
                      "errors are null");
    options->observe.add_to(*command);
    command
        ->add_option("-o,--output", options->directory,
                     "Directory for run.json, image.exr, image.png and the bytes by tile")
        ->required();
    command->callback([options] { run_command(*options); });
}

}  // namespace ropsim
