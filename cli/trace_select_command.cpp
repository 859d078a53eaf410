// `ropsim trace cut|order`: a part of a trace, or all of it in another arrival order.
#include "base/outputs.h"
#include "cli/trace_commands.h"
#include "traces/trace_cut.h"
#include "traces/trace_order.h"

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <string>

namespace ropsim {

namespace {

const std::map<std::string, ArrivalOrder> arrival_orders{{"near_to_far", ArrivalOrder::kNearToFar},
                                                         {"far_to_near", ArrivalOrder::kFarToNear},
                                                         {"shuffle", ArrivalOrder::kShuffle},
                                                         {"primitive", ArrivalOrder::kPrimitive},
                                                         {"tile", ArrivalOrder::kTile}};

}  // namespace

void add_trace_cut(CLI::App& trace) {
    struct Options {
        std::string trace, output, region;
        std::uint64_t first = 0;
        CutOptions cut;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command = trace.add_subcommand(
        "cut", "Copy a part of a trace's fragments; size, camera, opaque layer, draws and primitives stay");
    command->add_option("TRACE", options->trace, "trace file")->required();
    command->add_option("-o,--output", options->output, "trace file to write")->required();
    command->add_option("--region", options->region, "keep these pixels: X,Y,WIDTHxHEIGHT from the top left");
    command->add_option("--draws", options->cut.draws,
                        "keep these draws: numbers, ranges A-B and names, with commas between");
    command
        ->add_option("--every-nth-tile", options->cut.every_nth_tile,
                     "keep one 8x8 tile in so many, spread evenly")
        ->check(CLI::Range(1, 1 << 20));
    CLI::Option* first = command->add_option("--first", options->first,
                                             "keep so many of the fragments that the other options keep");
    command->callback([options, first] {
        keep_inputs({options->trace}, {options->output});
        CutOptions cut = options->cut;
        if (!options->region.empty()) cut.region = parse_cut_region(options->region);
        if (first->count() != 0) cut.first = options->first;
        cut_trace(options->trace, options->output, cut);
    });
}

void add_trace_order(CLI::App& trace) {
    struct Options {
        std::string trace, output, order;
        std::uint64_t seed = 0;
    };
    const auto options = std::make_shared<Options>();
    CLI::App* command = trace.add_subcommand("order", "Write a trace's fragments in another arrival order");
    command->add_option("TRACE", options->trace, "trace file")->required();
    command->add_option("-o,--output", options->output, "trace file to write")->required();
    command
        ->add_option(
            "--order", options->order,
            "near_to_far, far_to_near, shuffle (all but fragments of one pixel and depth), primitive (by "
            "draw, "
            "then primitive) or tile (8x8 tile after tile); equals stay in the order they arrived in")
        ->required()
        ->check(CLI::IsMember({"near_to_far", "far_to_near", "shuffle", "primitive", "tile"}));
    command->add_option("--seed", options->seed, "of shuffle");
    command->callback([options] {
        keep_inputs({options->trace}, {options->output});
        order_trace(options->trace, options->output, arrival_orders.at(options->order), options->seed);
    });
}

}  // namespace ropsim
