// `ropsim cache-sizes`: bytes on the DRAM pins against the size of the ROP caches: tables, JSON, CSV, a plot.
#include "analysis/cache_sizes.h"
#include "analysis/cache_sizes_output.h"
#include "analysis/gnuplot.h"
#include "base/atomic_file.h"
#include "base/outputs.h"
#include "cli/commands.h"
#include "cli/study_options.h"

#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace ropsim {
namespace {

struct CacheSizesCommandOptions {
    CacheSizesOptions study;
    bool json = false;
    std::string directory;
};

void run_cache_sizes_command(const CacheSizesCommandOptions& options) {
    check_cache_sizes(options.study);
    gnuplot_program();  // missing, it is missed before the runs
    const auto files = {"cache-sizes.json", "cache-sizes.csv", "cache-sizes.svg", "cache-sizes.png"};
    std::vector<std::string> inputs = options.study.traces;
    inputs.push_back(options.study.hardware);
    keep_inputs(inputs, files_in(options.directory, files));
    start_directory(options.directory, files);
    const CacheSizes study = run_cache_sizes(options.study);
    write_cache_sizes_plot(study, options.directory);
    write_file(options.directory + "/cache-sizes.csv", cache_sizes_csv(study));
    const std::string json = cache_sizes_json(study);
    write_file(options.directory + "/cache-sizes.json", json);
    fmt::print("{}", options.json ? json : cache_sizes_table(study));
    fmt::print(stderr, "{}/cache-sizes.json\n", options.directory);
}

}  // namespace

void add_cache_sizes_command(CLI::App& app) {
    auto options = std::make_shared<CacheSizesCommandOptions>();
    CacheSizesOptions& study = options->study;
    CLI::App* command = app.add_subcommand(
        "cache-sizes",
        "Bytes on the DRAM pins against the size of the ROP caches, next to models without: tables, a plot");
    command->add_option("TRACE", study.traces, "fragment traces, a panel of the plot each")->required();
    add_technique_option(*command, study.techniques, "NAME[:key=value,...], repeatable");
    command->get_option("--technique")->required();
    command->add_option("--kibibytes", study.kibibytes, "sizes of a partition's cache, KiB")
        ->delimiter(',')
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command->add_option("--hardware", study.hardware, "preset or TOML file");
    command->add_option("--set", study.settings, "key=value, repeatable")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command->add_option("--seed", study.seed, "seed of the techniques' randomness");
    command
        ->add_option("--threads", study.threads,
                     "threads of each run; 0: the cores are shared out among the runs at a time")
        ->check(CLI::Range(0, 1024));
    command->add_flag("--json", options->json, "print cache-sizes.json instead of the tables");
    command
        ->add_option("-o,--output", options->directory, "directory of cache-sizes.json, .csv, .svg and .png")
        ->required();
    command->footer(
        "Bytes are those of `ropsim run --fidelity cached` with cache.kibibytes set to each size; one pass "
        "over "
        "the\n"
        "frame feeds all of them, and fully associative LRU caches of every size by their stack distances. "
        "Without a cache:\n"
        "worst case (every operation on its costliest path: the papers' model), touched (what this trace "
        "asked "
        "for), and\n"
        "bursts (the same in whole DRAM bursts, a quad at a time). gnuplot draws the plot.");
    command->callback([options] { run_cache_sizes_command(*options); });
}

}  // namespace ropsim
