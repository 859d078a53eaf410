// `ropsim claims`: the papers' claims with our values and verdicts.
#include "analysis/child_process.h"
#include "analysis/claims/claims.h"
#include "analysis/claims/output.h"
#include "analysis/claims/plots.h"
#include "analysis/gnuplot.h"
#include "analysis/report/report_rows.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "base/outputs.h"
#include "base/temporary_directory.h"
#include "cli/commands.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/ranges.h>

namespace ropsim {
namespace {

struct ClaimsCommandOptions {
    ClaimsOptions claims;
    std::string directory;
    bool json = false;
    bool markdown = false;
};

// That repeats these claims.
std::vector<std::string> claims_command(const ClaimsCommandOptions& options) {
    std::vector<std::string> command{"ropsim", "claims"};
    command.insert(command.end(), options.claims.ids.begin(), options.claims.ids.end());
    if (options.claims.runs.quick) command.emplace_back("--quick");
    command.insert(command.end(), {"-o", options.directory});
    return command;
}

void run_claims_command(ClaimsCommandOptions options) {
    chosen_claims(all_claims(), options.claims.ids);    // a wrong id is told before anything is made
    if (!options.directory.empty()) gnuplot_program();  // and a missing one before the runs
    std::optional<TemporaryDirectory> temporary;
    ClaimRunsOptions& runs = options.claims.runs;
    if (options.directory.empty()) {
        runs.directory = temporary.emplace().path();
    } else {
        runs.directory = options.directory;
        start_directory(options.directory, {"claims.json", "claims.md", "report.html"});
    }
    const std::vector<ClaimResult> results = run_claims(options.claims);
    const std::string json = claims_json(results, runs.quick);
    const std::string markdown = claims_markdown(results, runs.quick);
    if (!options.directory.empty()) {
        write_file(options.directory + "/claims.json", json);
        write_file(options.directory + "/claims.md", markdown);
        write_file(options.directory + "/report.html",
                   claims_report(json, shell_line(claims_command(options))));
        write_claim_plots(results, options.directory + "/images");
    }
    fmt::print("{}", options.json ? json : options.markdown ? markdown : claims_table(results));
    std::vector<std::string> failed;
    for (const ClaimResult& result : results)
        if (!result.failure.empty()) failed.push_back(result.claim->id);
    if (!failed.empty())
        throw UserError("claims", fmt::format("runs of {} failed; their reasons stand beside them",
                                              fmt::join(failed, ", ")));
}

}  // namespace

void add_claims_command(CLI::App& app) {
    auto options = std::make_shared<ClaimsCommandOptions>();
    CLI::App* command = app.add_subcommand(
        "claims", "The papers' claims: what is printed, what comes out here, and a verdict");
    command->add_option("ID", options->claims.ids,
                        "of `ropsim list claims`, or the beginning of some and *; default: all");
    command->add_flag("--quick", options->claims.runs.quick, "smaller images: under a minute on two cores");
    command
        ->add_option("--threads", options->claims.runs.threads,
                     "threads of each run; 0: the cores are shared out among the runs at a time")
        ->check(CLI::Range(0, 1024));
    CLI::Option* json = command->add_flag("--json", options->json, "print claims.json instead of the table");
    command->add_flag("--markdown", options->markdown, "print claims.md instead of the table")
        ->excludes(json);
    command->add_option("-o,--output", options->directory,
                        "directory of claims.json, claims.md, report.html and images/, with traces/ (used "
                        "again when there) and "
                        "runs/; without, they go to a temporary one that is removed");
    command->footer(
        "Values: `worst case` is what techniques declare, nothing cached; `measured` what runs gave (bytes "
        "with caches\nand compression on), or an exact enumeration. Verdicts are judged from the numbers.");
    command->callback([options] { run_claims_command(*options); });
}

}  // namespace ropsim
