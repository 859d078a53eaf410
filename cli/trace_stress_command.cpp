// `ropsim trace stress`: writes traces at the edges of what fragments can be.
#include "base/error.h"
#include "cli/trace_commands.h"
#include "traces/stress_traces.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include <fmt/format.h>

namespace ropsim {

namespace {

void list_stress_traces() {
    std::string text;
    for (const StressTrace& stress : stress_traces())
        text += fmt::format("{:<18}{}\n", stress.name, stress.summary);
    std::fputs(text.c_str(), stdout);
}

void write_all(const std::string& directory, std::uint64_t seed) {
    std::error_code error;
    std::filesystem::create_directories(directory, error);
    if (!std::filesystem::is_directory(directory))
        throw UserError(directory, "cannot be made a directory; name another");
    for (const StressTrace& stress : stress_traces())
        write_stress_trace(stress.name, (std::filesystem::path(directory) / stress.name).string() + ".trace",
                           seed);
}

}  // namespace

void add_trace_stress(CLI::App& trace) {
    struct Options {
        std::string name, output;
        bool all = false, list = false;
        std::uint64_t seed = 0;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command = trace.add_subcommand("stress", "Write traces at the edges of what fragments can be");
    CLI::Option* name = command->add_option("NAME", options->name, "which; --list names them");
    CLI::Option* output =
        command->add_option("-o,--output", options->output, "trace file to write; with --all, a directory");
    CLI::Option* all =
        command->add_flag("--all", options->all, "write every one, as NAME.trace")->excludes(name);
    command->add_flag("--list", options->list, "list them")->excludes(name)->excludes(all)->excludes(output);
    command->add_option("--seed", options->seed, "of their random parts");
    command->callback([options] {
        if (options->list) {
            list_stress_traces();
            return;
        }
        if (options->name.empty() && !options->all) throw CLI::RequiredError("NAME, --all or --list");
        if (options->output.empty()) throw CLI::RequiredError("--output");
        if (options->all)
            write_all(options->output, options->seed);
        else
            write_stress_trace(options->name, options->output, options->seed);
    });
}

}  // namespace ropsim
