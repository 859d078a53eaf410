// `ropsim compare`: several techniques on one or more traces, a table on stdout and report.html.
#include "analysis/comparison.h"
#include "analysis/comparison_table.h"
#include "analysis/report.h"
#include "base/error.h"
#include "base/outputs.h"
#include "cli/commands.h"

#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace ropsim {
namespace {

struct CompareOptions {
    ComparisonOptions comparison;
    std::string title;
    std::string hardware, fidelity, engine, order, sample_tiles, seed;
    std::vector<std::string> settings;
};

// Only what was given is passed on: the defaults are those of `run`.
std::vector<std::string> run_options(const CompareOptions& options) {
    std::vector<std::string> arguments;
    for (const auto& [name, value] : {std::pair{"--hardware", options.hardware},
                                      {"--fidelity", options.fidelity},
                                      {"--engine", options.engine},
                                      {"--order", options.order},
                                      {"--sample-tiles", options.sample_tiles},
                                      {"--seed", options.seed}})
        if (!value.empty()) arguments.insert(arguments.end(), {name, value});
    for (const std::string& setting : options.settings) arguments.insert(arguments.end(), {"--set", setting});
    return arguments;
}

void run_compare(CompareOptions options) {
    options.comparison.run_options = run_options(options);
    const std::string report = options.comparison.directory + "/report.html";
    keep_inputs(options.comparison.traces, {report});
    start_directory(options.comparison.directory, {"report.html"});
    const auto comparisons = run_comparison(options.comparison);
    std::vector<std::string> failed;
    std::size_t runs = 0;
    for (const ComparisonOfOneTrace& comparison : comparisons) {
        if (comparisons.size() > 1)
            fmt::print("{}{}\n", &comparison == comparisons.data() ? "" : "\n", comparison.name);
        fmt::print("{}", comparison_table(comparison.runs));
        runs += comparison.runs.size();
        for (const RunRecord& run : comparison.runs)
            if (!run.failure.empty())
                failed.push_back(comparisons.size() > 1 ? comparison.name + " " + run.technique
                                                        : run.technique);
    }
    write_report(comparisons, options.title, report);
    fmt::print(stderr, "{}\n", report);
    if (!failed.empty())
        throw UserError("compare", fmt::format("{} of {} runs failed: {}; their reasons stand in the table",
                                               failed.size(), runs, fmt::join(failed, ", ")));
}

}  // namespace

void add_compare_command(CLI::App& app) {
    auto options = std::make_shared<CompareOptions>();
    CLI::App* command =
        app.add_subcommand("compare", "Runs several techniques on traces; a table and report.html");
    command->add_option("TRACE", options->comparison.traces, "fragment traces, a section of the report each")
        ->required();
    command
        ->add_option("--technique", options->comparison.techniques,
                     "NAME[:key=value,...], repeatable; default: the headline techniques")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command->add_option("--hardware", options->hardware, "preset or TOML file");
    command->add_option("--set", options->settings, "key=value, repeatable")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command->add_option("--fidelity", options->fidelity, "what is simulated; default: that of `run`")
        ->check(CLI::IsMember({"count", "cached", "timed"}));
    command->add_option("--engine", options->engine, "rop, shader or tiled");
    command->add_option("--order", options->order, "trace or machine");
    command->add_option("--sample-tiles", options->sample_tiles, "share of the tiles that is simulated, P%");
    command->add_option("--seed", options->seed, "seed of the techniques' randomness");
    command
        ->add_option("--threads", options->comparison.threads,
                     "threads of each run; 0: the cores are shared out among the runs at a time")
        ->check(CLI::Range(0, 1024));
    command->add_option("--title", options->title, "heading of the report");
    command->add_option("-o,--output", options->comparison.directory, "directory of the results")->required();
    command->callback([options] { run_compare(*options); });
}

}  // namespace ropsim
