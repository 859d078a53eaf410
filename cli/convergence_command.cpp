// `ropsim convergence`: how the error of techniques falls with a parameter: a table, JSON, CSV and a log-log
// plot.
#include "analysis/convergence.h"
#include "analysis/convergence_output.h"
#include "analysis/convergence_plot.h"
#include "base/atomic_file.h"
#include "base/outputs.h"
#include "cli/commands.h"

#include <memory>
#include <string>

#include <fmt/format.h>

namespace ropsim {
namespace {

struct ConvergenceCommandOptions {
    ConvergenceOptions convergence;
    bool json = false;
    std::string directory;
};

void run_convergence_command(const ConvergenceCommandOptions& options) {
    check_convergence(options.convergence);
    gnuplot_program();  // missing, it is missed before the runs
    keep_inputs({options.convergence.trace},
                files_in(options.directory,
                         {"convergence.json", "convergence.csv", "convergence.svg", "convergence.png"}));
    start_directory(options.directory,
                    {"convergence.json", "convergence.csv", "convergence.svg", "convergence.png"});
    const Convergence convergence = run_convergence(options.convergence);
    const bool plotted = has_plot(convergence);
    if (plotted)
        write_convergence_plot(convergence, options.directory);
    else
        fmt::print(stderr, "no plot: every error is 0, which has no place on a logarithmic axis\n");
    write_file(options.directory + "/convergence.csv", convergence_csv(convergence));
    const std::string json = convergence_json(convergence, plotted);
    write_file(options.directory + "/convergence.json", json);
    fmt::print("{}", options.json ? json : convergence_table(convergence));
    fmt::print(stderr, "{}/convergence.json\n", options.directory);
}

}  // namespace

void add_convergence_command(CLI::App& app) {
    auto options = std::make_shared<ConvergenceCommandOptions>();
    ConvergenceOptions& study = options->convergence;
    CLI::App* command = app.add_subcommand(
        "convergence",
        "How the error of techniques falls with a parameter: slope of log RMSE with a 95% interval, plot");
    command->add_option("TRACE", study.trace, "fragment trace")->required();
    command
        ->add_option(
            "--technique", study.techniques,
            "NAME[:key=value,...] without the key that is swept, repeatable; ratios are to the first")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
        ->required();
    command->add_option("--key", study.key, "the techniques' key that is swept");
    command->add_option("--values", study.values, "its values, numbers above 0; a slope needs 3")
        ->delimiter(',')
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command
        ->add_option("--seeds", study.seeds,
                     "runs a value with seeds 1 to N, from whose scatter the interval comes; with 1 from the "
                     "residuals")
        ->check(CLI::Range(1, 10000));
    command
        ->add_option("--threads", study.threads,
                     "threads of each run; 0: the cores are shared out among the runs at a time")
        ->check(CLI::Range(0, 1024));
    command->add_flag("--json", options->json, "print convergence.json instead of the table");
    command
        ->add_option("-o,--output", options->directory, "directory of convergence.json, .csv, .svg and .png")
        ->required();
    command->footer(
        "Each run is that of `ropsim run --fidelity count` with the seed. The slope is that of a "
        "least-squares line\n"
        "through log RMSE over log value: -1/2 for independent samples, steeper with stratification. With "
        "several\n"
        "seeds its interval is Student's from their scatter about each value's mean: with other seeds at the "
        "same\n"
        "values, 95% of such intervals hold the slope of the expected errors. With one seed it is the "
        "regression's own,\n"
        "from the residuals, and takes the errors to lie on a line but for noise. gnuplot draws the plot.");
    command->callback([options] { run_convergence_command(*options); });
}

}  // namespace ropsim
