// `ropsim shadow`: a stochastic shadow map of a light's view, cast on the camera's view.
#include "analysis/shadow_study.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "base/parallel.h"
#include "cli/commands.h"

#include <memory>
#include <string>

#include <fmt/format.h>

namespace ropsim {
namespace {

void run_shadow(const ShadowStudyOptions& options) {
    if (options.receiving.filter.side % 2 == 0)
        throw UserError("--filter", fmt::format("{} texels have none in their middle; use an odd number",
                                                options.receiving.filter.side));
    const ShadowStudy study = study_shadows(options);
    write_file(options.directory + "/shadow.json", shadow_json(study));
    const auto line = [](const char* receivers, const ShadowLookups& lookups) {
        fmt::print(stderr, "{}: {} look-ups, visibility off by {:+.4f} on average, RMSE {:.4f}\n", receivers,
                   lookups.count, lookups.noise.mean(), lookups.noise.rmse());
    };
    fmt::print(stderr, "{}: {} bits a texel\n", options.map.technique,
               study.run.declaration.storage_bits_per_pixel());
    line("fragments", study.shadowed.fragments);
    line("opaque", study.shadowed.opaque);
    fmt::print(stderr, "{}/shadow.json\n", options.directory);
}

}  // namespace

void add_shadow_command(CLI::App& app) {
    auto options = std::make_shared<ShadowStudyOptions>();
    options->map.threads = default_threads();
    options->receiving.filter.bias = 0.001;
    options->receiving.filter.slope_bias = 0.002;
    ShadowFilter& filter = options->receiving.filter;
    CLI::App* command = app.add_subcommand(
        "shadow", "Casts a light's transparent shadows by a stochastic shadow map, next to exact ones");
    command->add_option("LIGHT_TRACE", options->map.trace, "the light's view (capture --view light)")
        ->required();
    command->add_option("CAMERA_TRACE", options->camera_trace, "the camera's view of the same scene")
        ->required();
    command->add_option("--technique", options->map.technique,
                        "shadow_map[:key=value,...]; see `ropsim list techniques`");
    command->add_option("--filter", filter.side, "side of the square of texels that a look-up averages, odd")
        ->check(CLI::Range(1, ShadowFilter::kMaxSide));
    command
        ->add_option("--taps", filter.taps,
                     "texels drawn at random from that square for each look-up; 0: all of them")
        ->check(CLI::Range(0, 4096));
    command
        ->add_option("--bias", filter.bias,
                     "window depth by which a sample must be nearer than a point to shadow it")
        ->check(CLI::Range(0.0, 1.0));
    command
        ->add_option("--slope-bias", filter.slope_bias,
                     "what is added to the bias for each texel between the point and the texel's centre")
        ->check(CLI::Range(0.0, 1.0));
    command->add_option("--ambient", options->receiving.ambient, "share of the light that no shadow takes")
        ->check(CLI::Range(0.0, 1.0));
    command->add_option("--hardware", options->map.hardware, "preset or .toml file");
    command->add_option("--set", options->map.settings, "a hardware key=value, repeatable")
        ->expected(1)
        ->take_all();
    command->add_option("--seed", options->map.seed, "seed of every random draw");
    command->add_option("--threads", options->map.threads, "threads on the host; results do not depend on it")
        ->check(CLI::Range(1, 1024));
    command
        ->add_option("-o,--output", options->directory,
                     "directory of shadow.json, map.png, shadowed.trace, shadowed.png and exact.trace")
        ->required();
    command->callback([options] { run_shadow(*options); });
}

}  // namespace ropsim
