// `ropsim trace import|export`: traces from and to deep OpenEXR and CSV.
#include "base/error.h"
#include "base/outputs.h"
#include "cli/trace_commands.h"
#include "traces/interchange/csv.h"
#include "traces/interchange/deep_exr.h"
#include "traces/trace.h"

#include <cstdio>
#include <map>
#include <memory>
#include <string>

namespace ropsim {

namespace {

const std::map<std::string, DeepOrder> deep_orders{{"file", DeepOrder::kFile},
                                                   {"near_to_far", DeepOrder::kNearToFar},
                                                   {"far_to_near", DeepOrder::kFarToNear},
                                                   {"shuffle", DeepOrder::kShuffle}};

}  // namespace

void add_trace_import(CLI::App& trace) {
    struct Options {
        std::string file, output, order;
        std::uint64_t seed = 0;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command =
        trace.add_subcommand("import", "Make a trace from a deep OpenEXR file or CSV fragments");
    command->add_option("FILE", options->file, ".exr (deep) or .csv (in arrival order)")->required();
    command->add_option("-o,--output", options->output, "trace file to write")->required();
    command
        ->add_option(
            "--order", options->order,
            "deep OpenEXR: arrival order of each pixel's samples: file, near_to_far, far_to_near or shuffle; "
            "without it files that 'trace export' wrote keep theirs, others are shuffled")
        ->check(CLI::IsMember({"file", "near_to_far", "far_to_near", "shuffle"}));
    command->add_option("--seed", options->seed, "of shuffle");
    command->callback([options] {
        keep_inputs({options->file}, {options->output});
        std::vector<std::string> notes;
        if (!options->file.ends_with(".exr") && !is_exr_file(options->file)) {
            if (!options->order.empty())
                throw UserError("--order", "a CSV file is in arrival order; use 'trace order' on the trace");
            notes = import_csv(options->file, options->output);
        } else {
            DeepImportOptions deep;
            deep.seed = options->seed;
            if (!options->order.empty()) deep.order = deep_orders.at(options->order);
            notes = import_deep_exr(options->file, options->output, deep);
        }
        for (const std::string& note : notes)
            std::fprintf(stderr, "ropsim: %s: %s\n", options->file.c_str(), note.c_str());
    });
}

void add_trace_export(CLI::App& trace) {
    struct Options {
        std::string trace, output;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command =
        trace.add_subcommand("export", "Write a trace's fragments as deep OpenEXR or CSV, losslessly");
    command->add_option("TRACE", options->trace, "trace file")->required();
    command->add_option("-o,--output", options->output, "file to write, .exr (deep) or .csv")->required();
    command->callback([options] {
        keep_inputs({options->trace}, {options->output});
        if (options->output.ends_with(".exr")) {
            export_deep_exr(options->trace, options->output);
            return;
        }
        if (!options->output.ends_with(".csv"))
            throw UserError(options->output, "unknown kind of file; name it .exr (deep OpenEXR) or .csv");
        export_csv(options->trace, options->output);
        if (TraceReader(options->trace).header().opaque)
            std::fprintf(stderr, "ropsim: %s: the opaque layer is not part of a CSV file and was left out\n",
                         options->output.c_str());
    });
}

}  // namespace ropsim
