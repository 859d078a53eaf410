// `ropsim compare`: several techniques on one or more traces, a table on stdout and report.html.
#include "analysis/child_process.h"
#include "analysis/comparison.h"
#include "analysis/comparison_table.h"
#include "analysis/report/report.h"
#include "base/error.h"
#include "base/outputs.h"
#include "cli/commands.h"

#include <algorithm>
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
    std::vector<std::string> inspect;  // X,Y each
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

std::vector<std::string> compare_command(const CompareOptions& options) {
    std::vector<std::string> command{"ropsim", "compare"};
    const auto add = [&](const std::vector<std::string>& arguments) {
        command.insert(command.end(), arguments.begin(), arguments.end());
    };
    add(options.comparison.traces);
    for (const std::string& technique : options.comparison.techniques) add({"--technique", technique});
    add(options.comparison.run_options);
    for (const std::string& pixel : options.inspect) add({"--inspect", pixel});
    if (!options.title.empty()) add({"--title", options.title});
    add({"-o", options.comparison.directory});
    return command;
}

// Once each, inside every trace: before the runs, which may take hours.
std::vector<PixelPlace> inspected_pixels(const std::vector<std::string>& texts,
                                         const std::vector<std::string>& traces) {
    std::vector<PixelPlace> places;
    for (const std::string& text : texts) {
        const PixelPlace place = parse_pixel_place(text, "--inspect");
        for (const std::string& trace : traces) {
            const TraceReader reader(trace);
            const TraceHeader& header = reader.header();
            if (place.x >= header.width || place.y >= header.height)
                throw UserError(
                    "--inspect",
                    fmt::format("{} lies outside {} of {}x{} pixels; count from the top left, from 0", text,
                                trace, header.width, header.height));
        }
        if (std::find(places.begin(), places.end(), place) == places.end()) places.push_back(place);
    }
    return places;
}

void run_compare(CompareOptions options) {
    options.comparison.run_options = run_options(options);
    const std::string report = options.comparison.directory + "/report.html";
    keep_inputs(options.comparison.traces, {report});
    const ReportOptions report_options{options.title, shell_line(compare_command(options)),
                                       inspected_pixels(options.inspect, options.comparison.traces),
                                       ReportBudget{}};
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
    write_report(comparisons, report_options, report);
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
    command
        ->add_option("--inspect", options->inspect,
                     "X,Y from the top left, repeatable: a pixel that the report's inspector must know")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command->add_option("--title", options->title, "heading of the report");
    command->add_option("-o,--output", options->comparison.directory, "directory of the results")->required();
    command->callback([options] { run_compare(*options); });
}

}  // namespace ropsim
