// `ropsim ambient`: ambient occlusion on a trace, inferred at the edges of cut-outs.
#include "analysis/ambient_study.h"
#include "base/atomic_file.h"
#include "base/outputs.h"
#include "base/parallel.h"
#include "cli/commands.h"
#include "cli/number_range.h"

#include <map>
#include <memory>
#include <string>

#include <fmt/format.h>

namespace ropsim {
namespace {

// A cut-out without whole fragments has nothing that its edges could be the edges of.
void note_thin_draws(const AmbientStudy& study) {
    for (std::size_t d = 0; d < study.draws.size(); ++d) {
        const AmbientCounts& counts = study.draws[d];
        if (counts.inferred() > 0 && counts.largest_alpha < study.options.solid_alpha)
            fmt::print(stderr,
                       "note: no fragment of '{}' is whole: its alpha is at most {:.3f}, and "
                       "--solid-alpha {}\n",
                       study.draw_names[d], counts.largest_alpha, study.options.solid_alpha);
    }
}

void run_ambient(const AmbientOptions& options) {
    keep_inputs({options.trace}, files_in(options.directory, {"ambient.json", "ambient.trace", "ao.exr",
                                                              "ao.png", "before.png", "after.png"}));
    const AmbientStudy study = study_ambient(options);
    write_file(options.directory + "/ambient.json", ambient_json(study));
    AmbientCounts total;
    for (const AmbientCounts& draw : study.draws) total.add(draw);
    fmt::print(stderr, "{} fragments: {} hidden, {} whole, {} at edges ({} by line, {} by box), {} others\n",
               total.fragments, total.hidden, total.solid, total.inferred(), total.line, total.box,
               total.other);
    note_thin_draws(study);
    if (options.infer)
        fmt::print(stderr, "inference: {} texture fetches; {} fragments with weights below 0.01\n",
                   2 * study.inference.taps, study.inference.faint);
    const EdgeStep& step = study.edges;
    if (step.without && step.solid_only && step.inferred) {
        fmt::print(stderr,
                   "edges against whole fragments: {:+.1f} % without AO, {:+.1f} % with AO on whole "
                   "fragments only",
                   100 * *step.without, 100 * *step.solid_only);
        if (options.infer) fmt::print(stderr, ", {:+.1f} % inferred", 100 * *step.inferred);
        fmt::print(stderr, "\n");
    }
    fmt::print(stderr, "{}/ambient.json\n", options.directory);
}

// One word of a few: CLI11 would also take, and list, the numbers behind them.
template <typename Value>
void add_choice(CLI::App& command, const std::string& name, Value& value,
                const std::map<std::string, Value>& choices, const std::string& description) {
    std::string chosen;
    for (const auto& [word, meaning] : choices)
        if (meaning == value) chosen = word;
    command
        .add_option_function<std::string>(
            name, [&value, choices](const std::string& word) { value = choices.at(word); }, description)
        ->check(CLI::IsMember(choices))
        ->default_str(chosen);
}

void add_buffer_options(CLI::App& command, AmbientOptions& options) {
    ObscuranceSettings& buffer = options.obscurance;
    command.add_option("--radius", buffer.radius, "of the sphere in which surfaces occlude, metres")
        ->check(between(1e-3, 1e3));
    command
        .add_option("--bias", buffer.bias, "metres above a surface's plane below which nothing occludes it")
        ->check(between(0.0, 1e3));
    command.add_option("--intensity", buffer.intensity, "factor on the occlusion")->check(between(0.0, 1e3));
    command.add_option("--taps", buffer.taps, "depths that a pixel of the ambient buffer looks at")
        ->check(CLI::Range(1, 1024));
    command.add_option("--blur", options.blur, "taps each way of the filter over that buffer; 0: none")
        ->check(CLI::Range(0, 32));
    add_choice<Format>(command, "--format", buffer.format,
                       {{"unorm8", Format::kUnorm8},
                        {"unorm16", Format::kUnorm16},
                        {"float16", Format::kFloat16},
                        {"float32", Format::kFloat32}},
                       "of the ambient buffer");
}

void add_inference_options(CLI::App& command, AmbientOptions& options) {
    InferenceSettings& inference = options.inference;
    add_choice<bool>(command, "--infer", options.infer, {{"on", true}, {"off", false}},
                     "off: edges receive no ambient occlusion");
    add_choice<HelperLanes>(
        command, "--helpers", options.helpers,
        {{"twin", HelperLanes::kTwin}, {"zero", HelperLanes::kZero}, {"own", HelperLanes::kOwn}},
        "alpha of a lane that the primitive does not cover: of the other triangle of its pair, else 0 "
        "(twin); 0; "
        "or the fragment's own");
    command.add_option("--line-taps", inference.line_taps, "taps along the gradient of alpha")
        ->check(CLI::Range(1, 256));
    command.add_option("--line-stride", inference.line_stride, "pixels from one of them to the next")
        ->check(CLI::Range(1, 64));
    command.add_option("--box-radius", inference.box_radius, "R of the (2R + 1)^2 taps where alpha is flat")
        ->check(CLI::Range(0, 16));
    command.add_option("--box-stride", inference.box_stride, "pixels from one of them to the next")
        ->check(CLI::Range(1, 64));
    add_choice<bool>(command, "--box-shift", inference.checkerboard,
                     {{"printed", false}, {"checkerboard", true}},
                     "as in Listing 2, or odd rows by half a step");
    command.add_option("--half-weight", inference.half_weight, "metres of depth at which a tap weighs half")
        ->check(between(1e-6, 1e6));
    command.add_option("--floor", inference.floor, "least sum of weights that divides; 0: a plain mean")
        ->check(between(0.0, 1e3));
}

}  // namespace

void add_ambient_command(CLI::App& app) {
    auto options = std::make_shared<AmbientOptions>();
    options->threads = default_threads();
    CLI::App* command = app.add_subcommand(
        "ambient", "Puts ambient occlusion onto a trace, inferred at the edges of leaves and other cut-outs");
    command->add_option("TRACE", options->trace, "trace file with a camera, one sample a pixel")->required();
    command
        ->add_option("--solid", options->solid,
                     "name of a draw that is a cut-out: whole or clear before filtering; repeatable")
        ->expected(1)
        ->take_all();
    command
        ->add_option("--solid-alpha", options->solid_alpha,
                     "from this alpha on, a cut-out's fragment is whole and in the depth buffer")
        ->check(between(1e-6, 1.0));
    command->add_option("--ambient", options->share, "share of every colour that is ambient light")
        ->check(between(0.0, 1.0));
    add_buffer_options(*command, *options);
    add_inference_options(*command, *options);
    command->add_option("--threads", options->threads, "threads on the host; results do not depend on it")
        ->check(CLI::Range(1, 1024));
    command
        ->add_option("-o,--output", options->directory,
                     "directory of ambient.json, ambient.trace, ao.exr, ao.png, before.png and after.png")
        ->required();
    command->callback([options] { run_ambient(*options); });
}

}  // namespace ropsim
