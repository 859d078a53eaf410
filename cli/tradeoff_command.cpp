// `ropsim tradeoff`: error against bytes, of every technique on several traces.
#include "analysis/gnuplot.h"
#include "analysis/standard_techniques.h"
#include "analysis/tradeoff.h"
#include "analysis/tradeoff_output.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "base/outputs.h"
#include "cli/commands.h"
#include "cli/study_options.h"
#include "model/run.h"

#include <array>
#include <memory>
#include <string>
#include <vector>

#include <fmt/ranges.h>

namespace ropsim {
namespace {

constexpr std::array kBytes{TradeoffBytes::kTouched, TradeoffBytes::kWorstCase, TradeoffBytes::kPins,
                            TradeoffBytes::kPinsAndWorstCase};

struct TradeoffCommandOptions {
    TradeoffOptions tradeoff;
    std::string bytes = bytes_kind(TradeoffBytes::kTouched).name;
    std::string hardware, seed;
    std::vector<std::string> settings;
    bool json = false;
};

// Only what was given is passed on: the defaults are those of `run`.
std::vector<std::string> run_options(const TradeoffCommandOptions& options) {
    std::vector<std::string> arguments;
    if (!options.hardware.empty()) arguments.insert(arguments.end(), {"--hardware", options.hardware});
    if (!options.seed.empty()) arguments.insert(arguments.end(), {"--seed", options.seed});
    for (const std::string& setting : options.settings) arguments.insert(arguments.end(), {"--set", setting});
    return arguments;
}

void run_tradeoff_command(TradeoffCommandOptions options) {
    options.tradeoff.run_options = run_options(options);
    for (const TradeoffBytes bytes : kBytes)
        if (options.bytes == bytes_kind(bytes).name) options.tradeoff.bytes = bytes;
    check_tradeoff(options.tradeoff);
    check_hardware(options.hardware.empty() ? RunOptions().hardware : options.hardware, options.settings);
    gnuplot_program();  // missing, it is missed before the runs
    const std::string& directory = options.tradeoff.directory;
    const auto files = {"tradeoff.json", "tradeoff.csv", "tradeoff.md", "tradeoff.svg", "tradeoff.png"};
    keep_inputs(options.tradeoff.traces, files_in(directory, files));
    start_directory(directory, files);
    const Tradeoff tradeoff = run_tradeoff(options.tradeoff);
    const bool plotted = has_plot(tradeoff);
    if (plotted) write_tradeoff_plot(tradeoff, directory);
    const std::string table = tradeoff_markdown(tradeoff);
    write_file(directory + "/tradeoff.md", table);
    write_file(directory + "/tradeoff.csv", tradeoff_csv(tradeoff));
    const std::string json = tradeoff_json(tradeoff, plotted);
    write_file(directory + "/tradeoff.json", json);
    fmt::print("{}", options.json ? json : table);
    fmt::print(stderr, "{}/tradeoff.json\n", directory);
    const std::vector<std::string> broken = broken_runs(tradeoff);
    if (!broken.empty())
        throw UserError("tradeoff", fmt::format("{} runs failed: {}; their reasons stand in the table",
                                                broken.size(), fmt::join(broken, ", ")));
}

}  // namespace

void add_tradeoff_command(CLI::App& app) {
    auto options = std::make_shared<TradeoffCommandOptions>();
    TradeoffOptions& study = options->tradeoff;
    CLI::App* command = app.add_subcommand(
        "tradeoff",
        "Error against bytes: every technique on traces, a table and a plot with the Pareto front");
    command->add_option("TRACE", study.traces, "fragment traces, a panel of the plot each")->required();
    add_technique_option(*command, study.techniques,
                         "NAME[:key=value,...], repeatable; default: every technique that makes a colour "
                         "image, at its headline parameters and the standard sizes below");
    std::vector<std::string> kinds;
    for (const TradeoffBytes bytes : kBytes) kinds.emplace_back(bytes_kind(bytes).name);
    command
        ->add_option(
            "--bytes", options->bytes,
            "what errors are set against: bytes that the trace touched before caches, those if every "
            "fragment took its costliest path, those on the DRAM pins (fidelity cached), or the last two "
            "side by "
            "side")
        ->check(CLI::IsMember(kinds));
    command->add_option("--hardware", options->hardware, "preset or TOML file; default: that of `run`");
    command->add_option("--set", options->settings, "key=value, repeatable")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command->add_option("--seed", options->seed,
                        "seed of the techniques' randomness; default: that of `run`");
    command
        ->add_option("--threads", study.threads,
                     "threads of each run; 0: the cores are shared out among the runs at a time")
        ->check(CLI::Range(0, 1024));
    command->add_flag("--keep-images", study.keep_images, "keep each run's image.exr besides its image.png");
    command->add_flag("--json", options->json, "print tradeoff.json instead of the table");
    command
        ->add_option("-o,--output", study.directory,
                     "directory of tradeoff.json, .csv, .md, .svg and .png, and of the runs")
        ->required();
    command->footer(
        "Each run is that of `ropsim run --fidelity count` (cached with --bytes pins and "
        "pins_and_worst_case). Bytes are those of "
        "the "
        "whole frame:\ndepth test, initial copies, every pass, resolve, the image; beside them the most that "
        "the operations on one fragment\ncan move, from their control paths. A technique that refuses a "
        "trace "
        "is a row with its reason. gnuplot draws the plot.\nWithout --technique:\n" +
        fmt::format("  {}\n", fmt::join(standard_techniques(), "\n  ")));
    command->callback([options] { run_tradeoff_command(*options); });
}

}  // namespace ropsim
