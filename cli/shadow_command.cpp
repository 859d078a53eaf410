// `ropsim shadow`: a stochastic shadow map of a light's view, cast on the camera's view.
#include "analysis/shadow_study.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "base/outputs.h"
#include "base/parallel.h"
#include "cli/commands.h"
#include "cli/number_range.h"

#include <array>
#include <memory>
#include <string>

#include <fmt/format.h>

namespace ropsim {
namespace {

// Puts the filter that the user wrote, or the technique's own, into the options.
void choose_filter(ShadowStudyOptions& options, const std::string& text) {
    const bool colored = names_colored_map(options.map.technique);
    options.filter = parse_filter(text.empty() ? (colored ? "variance" : "3") : text);
    if (options.filter.variance && !colored)
        throw UserError("--filter",
                        "variance needs a map of transparent geometry alone; use --technique "
                        "colored_shadow_map[:wavelengths=1]");
    ShadowFilter& filter = options.receiving.filter;
    if (filter.taps > 0 && options.filter.name != "square")
        throw UserError("--taps",
                        fmt::format("draws texels from a square, which --filter {} is not; leave it "
                                    "out or give the filter's side alone",
                                    options.filter.name));
    filter.side = options.filter.closer.side;
    filter.shape = options.filter.closer.shape;
    options.filter.closer = filter;
}

void print_lookups(const char* receivers, const ShadowLookups& lookups) {
    fmt::print(stderr, "{}: {} look-ups, visibility off by {:+.4f} on average, RMSE {:.4f}\n", receivers,
               lookups.count, lookups.noise.mean(), lookups.noise.rmse());
}

void print_lookups(const char* receivers, const ColoredLookups& lookups, std::size_t wavelengths) {
    for (std::size_t w = 0; w < wavelengths; ++w) {
        const VisibilityError& error = lookups.wavelengths[w].filter;
        fmt::print(stderr, "{}{}: {} look-ups, visibility off by {:+.4f} on average, RMSE {:.4f}\n",
                   receivers, wavelengths == 1 ? "" : std::array{", red", ", green", ", blue"}[w],
                   lookups.count, error.mean(), error.rmse());
    }
}

void run_shadow(ShadowStudyOptions& options, const std::string& filter) {
    choose_filter(options, filter);
    keep_inputs({options.map.trace, options.camera_trace, options.map.hardware},
                files_in(options.directory,
                         {"shadow.json", "map.png", "shadowed.trace", "shadowed.png", "exact.trace"}));
    const ShadowStudy study = study_shadows(options);
    write_file(options.directory + "/shadow.json", shadow_json(study));
    fmt::print(stderr, "{}: {} bits a texel\n", options.map.technique,
               study.run.declaration.storage_bits_per_pixel());
    if (study.colored) {
        const std::size_t wavelengths = study.run.wavelengths.size();
        print_lookups("fragments", study.colored->shadowed.fragments, wavelengths);
        print_lookups("opaque", study.colored->shadowed.opaque, wavelengths);
    } else {
        print_lookups("fragments", study.shadowed.fragments);
        print_lookups("opaque", study.shadowed.opaque);
    }
    fmt::print(stderr, "{}/shadow.json\n", options.directory);
}

// Of a plain number; words are the filter's own to refuse.
std::string check_side(const std::string& text) {
    if (text.empty()) return "a filter without a name";
    if (text.find_first_not_of("+-0123456789") != std::string::npos) return {};
    std::string number = text;
    return CLI::Range(1, ShadowFilter::kMaxSide)(number);
}

}  // namespace

void add_shadow_command(CLI::App& app) {
    auto options = std::make_shared<ShadowStudyOptions>();
    auto filter_text = std::make_shared<std::string>();
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
                        "shadow_map or colored_shadow_map[:key=value,...]; see `ropsim list techniques`");
    command
        ->add_option("--filter", *filter_text,
                     "K, the side of the square of texels that a look-up averages, odd; tent[:side=K]; "
                     "disc[:side=K]; variance[:key=value,...]; by default 3; of a coloured map variance")
        ->check(check_side);
    command
        ->add_option("--taps", filter.taps,
                     "texels drawn at random from that square for each look-up; 0: all of them")
        ->check(CLI::Range(0, 4096));
    command
        ->add_option("--bias", filter.bias,
                     "window depth by which a sample must be nearer than a point to shadow it")
        ->check(between(0.0, 1.0));
    command
        ->add_option("--slope-bias", filter.slope_bias,
                     "what is added to the bias for each texel between the point and the texel's centre")
        ->check(between(0.0, 1.0));
    command->add_option("--ambient", options->receiving.ambient, "share of the light that no shadow takes")
        ->check(between(0.0, 1.0));
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
    command->callback([options, filter_text] { run_shadow(*options, *filter_text); });
}

}  // namespace ropsim
