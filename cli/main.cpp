// `ropsim`: parses the command line, runs one command, turns failures into one line and an exit code.
#include "base/cleanup_on_signal.h"
#include "base/error.h"
#include "base/version.h"
#include "cli/commands.h"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <new>
#include <string>
#include <system_error>

#include <fmt/format.h>

namespace {

constexpr int kUserFault = 1;
constexpr int kUsageFault = 2;

// What was printed has reached the file or pipe behind stdout. Without this a full disk there goes unseen:
// the last of it is written when the program has already chosen its exit code.
void finish_output() {
    errno = 0;
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
        throw ropsim::UserError("standard output", fmt::format("cannot be written ({}); check where it goes",
                                                               std::strerror(errno != 0 ? errno : EIO)));
}

// The parser would only say that a command is required.
bool known_command(const CLI::App& app, int argc, char** argv) {
    if (argc < 2 || argv[1][0] == '-') return true;
    std::string names;
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
        if (command->get_name() == argv[1]) return true;
        names += (names.empty() ? "" : ", ") + command->get_name();
    }
    std::fprintf(stderr, "ropsim: unknown command '%s'; choose one of %s\n", argv[1], names.c_str());
    return false;
}

int run(int argc, char** argv) {
    CLI::App app{
        "Simulates order-independent transparency as a fixed function of a GPU's raster-operation unit."};
    app.name("ropsim");
    app.set_version_flag("--version", ropsim::kVersion);
    app.require_subcommand(1);
    app.option_defaults()->always_capture_default();
    ropsim::add_capture_command(app);
    ropsim::add_scenes_command(app);
    ropsim::add_list_command(app);
    ropsim::add_trace_command(app);
    ropsim::add_run_command(app);
    ropsim::add_compare_command(app);
    ropsim::add_convergence_command(app);
    ropsim::add_reference_command(app);
    ropsim::add_diff_command(app);
    ropsim::add_cost_command(app);
    ropsim::add_memory_command(app);
    ropsim::add_shadow_command(app);
    ropsim::add_ambient_command(app);
    ropsim::add_tradeoff_command(app);
    ropsim::add_timings_command(app);
    ropsim::add_claims_command(app);
    ropsim::add_bench_command(app);
    ropsim::add_stress_command(app);
    ropsim::add_sweep_command(app);
    ropsim::add_cache_sizes_command(app);
    ropsim::add_compression_command(app);
    ropsim::add_curve_command(app);
    ropsim::add_order_sensitivity_command(app);
    ropsim::add_validate_command(app);
    if (!known_command(app, argc, argv)) return kUsageFault;
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        const int status = app.exit(error) == 0 ? 0 : kUsageFault;
        if (status == 0) finish_output();
        return status;
    }
    finish_output();
    return 0;
}

}  // namespace

// SystemC's library defines main() and calls sc_main(); an own main() takes precedence at link time.
int main(int argc, char** argv) {
    ropsim::install_cleanup_on_signal();
    std::signal(SIGXFSZ, SIG_IGN);  // past the limit of a file's size writing fails, which is said
    try {
        return run(argc, argv);
    } catch (const ropsim::UserError& error) {
        std::fprintf(stderr, "ropsim: %s: %s\n", error.where().c_str(), error.what());
    } catch (const std::bad_alloc&) {
        std::fprintf(stderr, "ropsim: out of memory; use a smaller trace or technique, or fewer threads\n");
    } catch (const std::system_error& error) {
        std::fprintf(stderr, "ropsim: the system refuses: %s\n", error.what());
    } catch (const std::exception& error) {
        std::fprintf(stderr, "ropsim: %s\n", error.what());
    }
    return kUserFault;
}
