// `ropsim order-sensitivity`: how far techniques' images depend on the order in which fragments arrive.
#include "analysis/order_sensitivity.h"
#include "base/atomic_file.h"
#include "base/outputs.h"
#include "base/parallel.h"
#include "cli/commands.h"
#include "cli/study_options.h"

#include <memory>
#include <string>

#include <fmt/format.h>

namespace ropsim {
namespace {

void run_command(const OrderSensitivityOptions& options, bool json_wanted) {
    check_order_sensitivity(options);
    check_hardware(options.hardware, options.settings);
    keep_inputs({options.trace},
                files_in(options.directory, {"order-sensitivity.json", "order-sensitivity.csv"}));
    start_directory(options.directory, {"order-sensitivity.json", "order-sensitivity.csv"});
    const OrderSensitivity study = run_order_sensitivity(options);
    write_file(options.directory + "/order-sensitivity.csv", order_sensitivity_csv(study));
    const std::string json = order_sensitivity_json(study);
    write_file(options.directory + "/order-sensitivity.json", json);
    fmt::print("{}", json_wanted ? json : order_sensitivity_table(study));
    fmt::print(stderr, "{}/order-sensitivity.json\n", options.directory);
}

}  // namespace

void add_order_sensitivity_command(CLI::App& app) {
    auto options = std::make_shared<OrderSensitivityOptions>();
    auto json = std::make_shared<bool>(false);
    options->threads = default_threads();
    CLI::App* command = app.add_subcommand(
        "order-sensitivity", "How far techniques' images depend on the order in which fragments arrive");
    command->add_option("TRACE", options->trace, "fragment trace")->required();
    add_technique_option(*command, options->techniques,
                         "NAME[:key=value,...], repeatable; default: every technique that makes a colour "
                         "image, at its headline parameters");
    command->add_option("--orders", options->orders, "random orders")->check(CLI::Range(2, 10000));
    command->add_option("--order-seed", options->order_seed,
                        "of the random orders: the first is `trace order --order shuffle` with this seed, "
                        "the next with the next number");
    command->add_option("--seed", options->seed,
                        "seed of the techniques' randomness, the same in all orders");
    command->add_option("--hardware", options->hardware, "preset or TOML file");
    command->add_option("--set", options->settings, "a hardware key=value, repeatable")
        ->expected(1)
        ->take_all();
    command->add_option("--threads", options->threads, "threads on the host; results do not depend on it")
        ->check(CLI::Range(1, 1024));
    command->add_flag("--json", *json, "print order-sensitivity.json instead of the table");
    command
        ->add_option("-o,--output", options->directory,
                     "directory of order-sensitivity.json and .csv, and of one reordered trace at a time")
        ->required();
    command->footer(
        "Each run is that of `ropsim run --fidelity count` on the trace in another order, in which every "
        "fragment keeps\nits draw, primitive and values, and fragments of one pixel and depth keep their "
        "order: the exact image is the\nsame in all. Besides the random orders: as captured, near to far, "
        "far "
        "to near. Memory: 76 bytes for each technique and pixel with a fragment, besides one run.");
    command->callback([options, json] { run_command(*options, *json); });
}

}  // namespace ropsim
