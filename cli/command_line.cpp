#include "cli/command_line.h"

#include "base/error.h"
#include "base/version.h"
#include "cli/commands.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>

#include <fmt/format.h>

namespace ropsim {
namespace {

constexpr int kUsageFault = 2;

// What was printed has reached the file or pipe behind stdout. Without this a full disk there goes unseen:
// the last of it is written when the program has already chosen its exit code.
void finish_output() {
    errno = 0;
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
        throw UserError("standard output", fmt::format("cannot be written ({}); check where it goes",
                                                       std::strerror(errno != 0 ? errno : EIO)));
}

// The parser would only say that a command is required.
bool known_command(const CLI::App& app, int argc, const char* const* argv) {
    if (argc < 2 || argv[1][0] == '-') return true;
    std::string names;
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
        if (command->get_name() == argv[1]) return true;
        names += (names.empty() ? "" : ", ") + command->get_name();
    }
    std::fprintf(stderr, "ropsim: unknown command '%s'; choose one of %s\n", argv[1], names.c_str());
    return false;
}

}  // namespace

std::unique_ptr<CLI::App> make_command_line() {
    auto app = std::make_unique<CLI::App>(
        "Simulates order-independent transparency as a fixed function of a GPU's raster-operation unit.");
    app->name("ropsim");
    app->set_version_flag("--version", kVersion);
    app->require_subcommand(1);
    app->option_defaults()->always_capture_default();
    add_capture_command(*app);
    add_scenes_command(*app);
    add_list_command(*app);
    add_trace_command(*app);
    add_run_command(*app);
    add_compare_command(*app);
    add_convergence_command(*app);
    add_reference_command(*app);
    add_diff_command(*app);
    add_cost_command(*app);
    add_memory_command(*app);
    add_shadow_command(*app);
    add_ambient_command(*app);
    add_tradeoff_command(*app);
    add_timings_command(*app);
    add_claims_command(*app);
    add_bench_command(*app);
    add_stress_command(*app);
    add_sweep_command(*app);
    add_cache_sizes_command(*app);
    add_compression_command(*app);
    add_curve_command(*app);
    add_order_sensitivity_command(*app);
    add_validate_command(*app);
    return app;
}

int run_command_line(int argc, const char* const* argv) {
    const std::unique_ptr<CLI::App> app = make_command_line();
    if (!known_command(*app, argc, argv)) return kUsageFault;
    try {
        app->parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        const int status = app->exit(error) == 0 ? 0 : kUsageFault;
        if (status == 0) finish_output();
        return status;
    }
    finish_output();
    return 0;
}

}  // namespace ropsim
