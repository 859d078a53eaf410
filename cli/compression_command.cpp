// `ropsim compression`: what lossless compression saves by technique, surface and codec: tables, JSON, CSV.
#include "analysis/compression_output.h"
#include "analysis/compression_study.h"
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

struct CompressionCommandOptions {
    CompressionStudyOptions study;
    bool json = false;
    std::string directory;
};

void run_compression_command(const CompressionCommandOptions& options) {
    check_compression_study(options.study);
    const auto files = {"compression.json", "compression.csv"};
    std::vector<std::string> inputs = options.study.traces;
    inputs.push_back(options.study.hardware);
    keep_inputs(inputs, files_in(options.directory, files));
    start_directory(options.directory, files);
    const CompressionStudy study = run_compression_study(options.study);
    write_file(options.directory + "/compression.csv", compression_csv(study));
    const std::string json = compression_json(study);
    write_file(options.directory + "/compression.json", json);
    fmt::print("{}", options.json ? json : compression_table(study));
    fmt::print(stderr, "{}/compression.json\n", options.directory);
}

}  // namespace

void add_compression_command(CLI::App& app) {
    auto options = std::make_shared<CompressionCommandOptions>();
    CompressionStudyOptions& study = options->study;
    CLI::App* command = app.add_subcommand(
        "compression", "What lossless compression of blocks saves, by technique, surface and codec: tables");
    command->add_option("TRACE", study.traces, "fragment traces")->required();
    add_technique_option(*command, study.techniques, "NAME[:key=value,...], repeatable");
    command->get_option("--technique")->required();
    command->add_option("--hardware", study.hardware, "preset or TOML file");
    command->add_option("--set", study.settings, "key=value, repeatable")
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    command
        ->add_option("--metadata", study.metadata_kibibytes,
                     "KiB of a partition's cache of block states, of the setup that keeps them in memory")
        ->check(CLI::Range(1, 1024));
    command->add_option("--seed", study.seed, "seed of the techniques' randomness");
    command
        ->add_option("--threads", study.threads,
                     "threads of each run; 0: the cores are shared out among the runs at a time")
        ->check(CLI::Range(0, 1024));
    command->add_flag("--json", options->json, "print compression.json instead of the tables");
    command->add_option("-o,--output", options->directory, "directory of compression.json and .csv")
        ->required();
    command->footer(
        "Bytes are those of `ropsim run --fidelity cached` with the compression.* and metadata.* keys that\n"
        "compression.json gives for each setup. Two ratios: 'stored' is blocks written over the bytes they\n"
        "were stored in; 'saved' is of the bytes on the DRAM pins, with repacks and block states. What "
        "moves\n"
        "more bytes than without compression is marked 'loses' and comes first.");
    command->callback([options] { run_compression_command(*options); });
}

}  // namespace ropsim
