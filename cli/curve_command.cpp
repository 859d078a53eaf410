// `ropsim curve`: visibility functions at one pixel, exact and as techniques represent them.
#include "analysis/gnuplot.h"
#include "analysis/visibility_curve.h"
#include "base/atomic_file.h"
#include "base/outputs.h"
#include "cli/commands.h"
#include "cli/study_options.h"

#include <memory>
#include <string>

#include <fmt/format.h>

namespace ropsim {
namespace {

void run_curve(const CurveOptions& options, const std::string& directory, bool json_wanted) {
    keep_inputs({options.trace}, files_in(directory, {"curve.json", "curve.svg", "curve.png"}));
    gnuplot_program();  // missing, it is missed first
    const VisibilityCurve curve = visibility_curve(options);
    start_directory(directory, {"curve.json", "curve.svg", "curve.png"});
    write_curve_plot(curve, directory);
    const std::string json = curve_json(curve);
    write_file(directory + "/curve.json", json);
    fmt::print("{}", json_wanted ? json : curve_table(curve));
    fmt::print(stderr, "{}/curve.json\n", directory);
}

}  // namespace

void add_curve_command(CLI::App& app) {
    struct Options {
        CurveOptions curve;
        std::string directory;
        bool json = false;
    };
    auto options = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand(
        "curve", "Visibility functions at one pixel: the exact one and what techniques make of it");
    command->add_option("TRACE", options->curve.trace, "fragment trace")->required();
    command->add_option("--pixel", options->curve.pixel,
                        "X,Y from the top left, or deepest: where most fragments are to be seen");
    add_technique_option(
        *command, options->curve.techniques,
        "NAME[:key=value,...], repeatable; default: those headline techniques that represent "
        "visibility");
    command->add_option("--seed", options->curve.seed, "seed of the techniques' randomness");
    command->add_flag("--json", options->json, "print curve.json instead of the table");
    command->add_option("-o,--output", options->directory, "directory of curve.json, curve.svg and curve.png")
        ->required();
    command->footer(fmt::format(
        "Visibility is the transmittance of what is strictly in front of a depth, a mean over the spatial "
        "samples.\nShown are {} depths evenly over the fragments' range and a twentieth of it on both sides, "
        "and each fragment's\ndepth with its two neighbours among floats (of more than {} depths an even "
        "choice). gnuplot draws the plot.",
        kUniformDepths, kMostSteps));
    command->callback([options] { run_curve(options->curve, options->directory, options->json); });
}

}  // namespace ropsim
