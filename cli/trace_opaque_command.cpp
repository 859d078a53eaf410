// `ropsim trace opaque`: the opaque layer as fragments.
#include "base/outputs.h"
#include "cli/trace_commands.h"
#include "traces/trace_opaque.h"

#include <memory>
#include <string>

#include <fmt/format.h>

namespace ropsim {

void add_trace_opaque(CLI::App& trace) {
    struct Options {
        std::string trace, output;
        bool last = false;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command = trace.add_subcommand(
        "opaque", "Turn the opaque layer into fragments of alpha 1; the exact picture stays");
    command->add_option("TRACE", options->trace, "trace file with an opaque layer")->required();
    command->add_option("-o,--output", options->output, "trace file to write")->required();
    command->add_flag("--last", options->last,
                      "behind all other fragments in arrival order, not before them");
    command->footer(
        "One fragment for each group of a pixel's samples with one colour and depth, in a draw of its own, "
        "'opaque', the last\nin the list. Behind it is the trace's background; the other fragments stay, "
        "those "
        "that the layer hid too, and\nno depth test removes them any more.");
    command->callback([options] {
        keep_inputs({options->trace}, {options->output});
        const OpaqueConversion done = convert_opaque(
            options->trace, options->output, options->last ? OpaquePlace::kLast : OpaquePlace::kFirst);
        fmt::print(stderr, "{} opaque fragments", done.fragments);
        if (done.ties_removed > 0)
            fmt::print(stderr, "; {} fragments at the layer's own depth left out", done.ties_removed);
        if (done.widened_colors)
            fmt::print(stderr, "; colours are float32 now, as the layer's are no halves");
        fmt::print(stderr, "\n");
    });
}

}  // namespace ropsim
