// `ropsim sweep`: a run at every combination of values, a row each.
#include "analysis/gnuplot.h"
#include "analysis/sweep.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "base/outputs.h"
#include "cli/commands.h"
#include "cli/study_options.h"

#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace ropsim {
namespace {

struct SweepCommandOptions {
    SweepOptions sweep;
    std::string hardware, fidelity, engine, order, sample_tiles, seed;
    bool csv = false;
};

void run_sweep_command(SweepCommandOptions options) {
    SweepOptions& study = options.sweep;
    // Only what was given is passed on: the defaults are those of `run`.
    for (const auto& [name, values] : {std::pair{"--hardware", options.hardware},
                                       {"--engine", options.engine},
                                       {"--fidelity", options.fidelity},
                                       {"--order", options.order},
                                       {"--sample-tiles", options.sample_tiles},
                                       {"--seed", options.seed}})
        if (!values.empty()) study.choices.emplace_back(name, values);
    std::vector<std::string> inputs = study.traces;
    for (const SweepAxis& axis : sweep_axes(study))
        if (axis.option == "--hardware") inputs.insert(inputs.end(), axis.values.begin(), axis.values.end());
    gnuplot_program();  // missing, it is missed before the runs
    const auto files = {"sweep.csv", "sweep.txt", "sweep.svg", "sweep.png"};
    keep_inputs(inputs, files_in(study.directory, files));
    start_directory(study.directory, files);
    const Sweep sweep = run_sweep(study);
    if (has_plot(sweep)) write_sweep_plot(sweep, study.directory);
    const std::string table = sweep_table(sweep);
    const std::string csv = sweep_csv(sweep);
    write_file(study.directory + "/sweep.txt", table);
    write_file(study.directory + "/sweep.csv", csv);
    fmt::print("{}", options.csv ? csv : table);
    fmt::print(stderr, "{}/sweep.csv\n", study.directory);
    std::size_t failed = 0;
    for (const SweepPoint& point : sweep.points) failed += point.run.failure.empty() ? 0 : 1;
    if (failed != 0)
        throw UserError("sweep", fmt::format("{} of {} points failed; their reasons stand in the table",
                                             failed, sweep.points.size()));
}

}  // namespace

void add_sweep_command(CLI::App& app) {
    auto options = std::make_shared<SweepCommandOptions>();
    SweepOptions& study = options->sweep;
    CLI::App* command = app.add_subcommand(
        "sweep", "A run at every combination of values: a row each, a plot; goes on where it was");
    command->add_option("TRACE", study.traces, "fragment traces")->required();
    add_technique_option(*command, study.techniques, "NAME[:key=value,...], repeatable");
    command->get_option("--technique")->required();
    command->add_option("--set", study.settings, "key=value,value,...: a hardware key's values, repeatable")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command->add_option("--hardware", options->hardware, "presets or TOML files, separated by commas");
    command->add_option("--fidelity", options->fidelity, "count, cached, timed, separated by commas");
    command->add_option("--engine", options->engine, "engines of `run`, separated by commas");
    command->add_option("--order", options->order, "orders of `run`, separated by commas");
    command->add_option("--sample-tiles", options->sample_tiles, "shares of the tiles, separated by commas");
    command->add_option("--seed", options->seed, "seeds, separated by commas");
    command
        ->add_option("--threads", study.threads,
                     "threads of each run; 0: the cores are shared out among the runs at a time")
        ->check(CLI::Range(0, 1024));
    command->add_flag("--csv", options->csv, "print sweep.csv instead of the table");
    command
        ->add_option("-o,--output", study.directory,
                     "directory of sweep.csv, .txt, .svg and .png, and of the points")
        ->required();
    command->footer(
        "Options that are not given are those of `ropsim run`. A value cannot hold a comma. What is in the "
        "directory "
        "already is\nnot run again: a point is known by the program's version, the trace's content, "
        "technique, options and "
        "settings.");
    command->callback([options] { run_sweep_command(*options); });
}

}  // namespace ropsim
