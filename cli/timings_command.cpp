// `ropsim timings`: the run times that the papers print, next to simulated ones.
#include "analysis/published_timings.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "base/outputs.h"
#include "cli/commands.h"

#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace ropsim {
namespace {

struct TimingsCommandOptions {
    TimingOptions timings;
    bool json = false;
    bool list = false;
};

void list_timings() {
    for (const PublishedTiming& timing : published_timings())
        fmt::print("{:24} {}, {}: {}\n", timing.id, timing.paper, timing.place, timing.claim);
}

void run_timings_command(const TimingsCommandOptions& options) {
    if (options.list) return list_timings();
    if (options.timings.directory.empty())
        throw UserError("-o", "needs a directory for traces, runs and timings.json");
    start_directory(options.timings.directory, {"timings.json"});
    const std::vector<TimingResult> results = run_published_timings(options.timings);
    const std::string json = timings_json(results);
    write_file(options.timings.directory + "/timings.json", json);
    fmt::print("{}", options.json ? json : timings_table(results));
    for (const TimingResult& result : results)
        if (!result.failure.empty())
            throw UserError(result.timing->id, fmt::format("failed: {}", result.failure));
}

}  // namespace

void add_timings_command(CLI::App& app) {
    auto options = std::make_shared<TimingsCommandOptions>();
    CLI::App* command = app.add_subcommand(
        "timings", "The papers' run times next to simulated ones, on presets of the papers' parts");
    command->add_option("ID", options->timings.ids, "of --list; default: all");
    command
        ->add_option("--set", options->timings.settings,
                     "hardware key=value on top of the presets, repeatable")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command->add_flag("--list", options->list, "print what there is and stop");
    command->add_flag("--json", options->json, "print timings.json instead of the table");
    command->add_option("-o,--output", options->timings.directory,
                        "directory of timings.json, with traces/ (used again when there) and runs/");
    command->footer(
        "Captures the scenes, then simulates each once: a quarter of an hour and 1 GB for all of them.");
    command->callback([options] { run_timings_command(*options); });
}

}  // namespace ropsim
