// `ropsim trace ...`: looks at traces, converts, cuts, sorts and makes them.
#include "cli/commands.h"
#include "cli/trace_commands.h"

namespace ropsim {

void add_trace_command(CLI::App& app) {
    CLI::App* trace = app.add_subcommand("trace", "Look at traces, convert, cut, sort and make them");
    trace->require_subcommand(1);
    add_trace_info(*trace);
    add_trace_import(*trace);
    add_trace_export(*trace);
    add_trace_cut(*trace);
    add_trace_order(*trace);
    add_trace_opaque(*trace);
    add_trace_stress(*trace);
    add_trace_volume(*trace);
}

}  // namespace ropsim
