// `ropsim`: parses the command line, runs one command, turns failures into one line and an exit code.
#include "base/atomic_file.h"
#include "base/error.h"
#include "base/version.h"
#include "cli/commands.h"

#include <cstdio>
#include <exception>
#include <new>

namespace {

constexpr int kUserFault = 1;
constexpr int kUsageFault = 2;

int run(int argc, char** argv) {
    CLI::App app{
        "Simulates order-independent transparency as a fixed function of a GPU's raster-operation unit."};
    app.name("ropsim");
    app.set_version_flag("--version", ropsim::kVersion);
    app.require_subcommand(1);
    app.option_defaults()->always_capture_default();
    ropsim::add_capture_command(app);
    ropsim::add_list_command(app);
    ropsim::add_trace_command(app);
    ropsim::add_run_command(app);
    ropsim::add_compare_command(app);
    ropsim::add_reference_command(app);
    ropsim::add_diff_command(app);
    ropsim::add_cost_command(app);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        return app.exit(error) == 0 ? 0 : kUsageFault;
    }
    return 0;
}

}  // namespace

// SystemC's library defines main() and calls sc_main(); an own main() takes precedence at link time.
int main(int argc, char** argv) {
    ropsim::install_cleanup_on_signal();
    try {
        return run(argc, argv);
    } catch (const ropsim::UserError& error) {
        std::fprintf(stderr, "ropsim: %s: %s\n", error.where().c_str(), error.what());
    } catch (const std::bad_alloc&) {
        std::fprintf(stderr, "ropsim: out of memory; use a smaller trace or technique, or fewer threads\n");
    } catch (const std::exception& error) {
        std::fprintf(stderr, "ropsim: %s\n", error.what());
    }
    return kUserFault;
}
