// `ropsim`: runs the command line, turns failures into one line and an exit code.
#include "base/cleanup_on_signal.h"
#include "base/error.h"
#include "cli/command_line.h"

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <system_error>

namespace {

constexpr int kUserFault = 1;

}  // namespace

// SystemC's library defines main() and calls sc_main(); an own main() takes precedence at link time.
int main(int argc, char** argv) {
    ropsim::install_cleanup_on_signal();
    std::signal(SIGXFSZ, SIG_IGN);  // past the limit of a file's size writing fails, which is said
    try {
        return ropsim::run_command_line(argc, argv);
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
