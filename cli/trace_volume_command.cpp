// `ropsim trace volume`: a participating medium as the fragments of a ray march.
#include "analysis/volume_trace.h"
#include "base/error.h"
#include "base/outputs.h"
#include "base/parallel.h"
#include "cli/trace_commands.h"

#include <charconv>
#include <memory>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace ropsim {
namespace {

struct VolumeArguments {
    std::string trace, output, albedo = "1", ambient = "0.1", light, color;
    double height_falloff = 0, far = 0;
    VolumeOptions options;
};

// One number for all channels, or three with commas between them.
glm::dvec3 parse_rgb(const char* option, const std::string& text) {
    glm::dvec3 rgb{0};
    const char* at = text.data();
    const char* const end = at + text.size();
    int count = 0;
    bool complete = false;
    while (count < 3) {
        const auto [next, failure] = std::from_chars(at, end, rgb[count]);
        if (failure != std::errc()) break;
        ++count;
        at = next;
        complete = at == end;
        if (complete || *at != ',') break;
        ++at;
    }
    if (!complete || count == 2)
        throw UserError(option, fmt::format("'{}' is neither one number nor three, R,G,B", text));
    return count == 1 ? glm::dvec3(rgb.r) : rgb;
}

// An option that would change nothing is a mistake in what was asked for.
void refuse_idle_options(const CLI::App& command) {
    for (const auto& [option, needed] :
         {std::pair{"--filter", "--shadows"}, {"--base-height", "--height-falloff"}, {"--seed", "--jitter"}})
        if (command.count(option) > 0 && command.count(needed) == 0)
            throw UserError(option, fmt::format("does nothing without {}; give both or neither", needed));
}

void run_volume(const CLI::App& command, const VolumeArguments& arguments) {
    refuse_idle_options(command);
    VolumeOptions options = arguments.options;
    keep_inputs({arguments.trace, options.shadows}, {arguments.output});
    options.medium.albedo = parse_rgb("--albedo", arguments.albedo);
    options.ambient = parse_rgb("--ambient", arguments.ambient);
    if (command.count("--light") > 0) options.light = parse_rgb("--light", arguments.light);
    if (command.count("--height-falloff") > 0) options.medium.height_falloff = arguments.height_falloff;
    if (command.count("--far") > 0) options.far = arguments.far;
    if (!arguments.color.empty())
        options.color = arguments.color == "float16" ? ColorStorage::kFloat16 : ColorStorage::kFloat32;
    const VolumeSummary done = add_volume(arguments.trace, arguments.output, options);
    fmt::print(stderr, "draw 'volume': {} fragments in {} pixels, {} ALU instructions and {} fetches each\n",
               done.fragments, done.pixels, done.draw.full.alu_instructions, done.draw.full.texture_fetches);
}

void add_light_options(CLI::App& command, VolumeArguments& arguments) {
    command.add_option("--ambient", arguments.ambient, "radiance from all directions: R,G,B or one number")
        ->capture_default_str();
    command.add_option("--light", arguments.light,
                       "irradiance across the rays of the trace's light (of a perspective one at a metre): "
                       "R,G,B or one number; 3 by default, without a light in the trace none");
    command.add_option("--shadows", arguments.options.shadows,
                       "trace of the light's view (capture --view light): what it holds dims the light");
    command
        .add_option("--filter", arguments.options.filter,
                    "side of the square of its texels that a step averages, odd")
        ->capture_default_str();
}

void add_march_options(CLI::App& command, VolumeArguments& arguments) {
    command.add_option("--steps", arguments.options.steps, "a pixel, of equal length along its ray")
        ->capture_default_str();
    command.add_option("--near", arguments.options.near, "metres from the eye where the medium begins")
        ->capture_default_str();
    command.add_option("--far", arguments.far, "metres from the eye where it ends; by default the far plane")
        ->default_str("");
    command.add_flag("--jitter", arguments.options.jitter,
                     "sample the steps of each pixel at a place of its own, not at their middles");
    command.add_option("--seed", arguments.options.seed, "of the jitter")->capture_default_str();
}

}  // namespace

void add_trace_volume(CLI::App& trace) {
    const auto arguments = std::make_shared<VolumeArguments>();
    arguments->options.threads = default_threads();
    VolumeMedium& medium = arguments->options.medium;
    CLI::App* command =
        trace.add_subcommand("volume", "Fill a view with fog, as the fragments of a ray march");
    command->add_option("TRACE", arguments->trace, "trace file of a camera's view")->required();
    command->add_option("-o,--output", arguments->output, "trace file to write")->required();
    command->add_option("--extinction", medium.extinction, "per metre")->capture_default_str();
    command->add_option("--albedo", arguments->albedo, "share of it that scatters: R,G,B or one number")
        ->capture_default_str();
    command
        ->add_option("--anisotropy", medium.anisotropy,
                     "mean cosine of the Henyey-Greenstein phase function; above 0: forwards")
        ->capture_default_str();
    command
        ->add_option("--height-falloff", arguments->height_falloff,
                     "metres over which the extinction falls to 1/e upwards (world y)")
        ->default_str("");
    command->add_option("--base-height", medium.base_height, "metres, from where it falls")
        ->capture_default_str();
    command
        ->add_option("--collimation", medium.collimation,
                     "of the fragments' materials; 0: scatters what is behind")
        ->capture_default_str();
    add_light_options(*command, *arguments);
    add_march_options(*command, *arguments);
    command->add_option("--color", arguments->color, "what colours are stored as; by default the trace's")
        ->check(CLI::IsMember({"float16", "float32"}));
    command
        ->add_option("--threads", arguments->options.threads,
                     "threads on the host; results do not depend on it")
        ->check(CLI::Range(1, 1024));
    command->footer(
        "For every pixel the fragments that a shader marching from the eye to the opaque layer would blend "
        "one "
        "by one, in\na last draw 'volume': near to far, alpha 1 - exp(-extinction * length), the light "
        "scattered once. The others stay.");
    command->callback([command, arguments] { run_volume(*command, *arguments); });
}

}  // namespace ropsim
