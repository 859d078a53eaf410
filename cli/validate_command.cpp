// `ropsim validate`: the model's images against the same frame drawn by OpenGL.
#include "analysis/child_process.h"
#include "analysis/report/report_validation.h"
#include "analysis/validation.h"
#include "base/atomic_file.h"
#include "base/error.h"
#include "base/outputs.h"
#include "base/parallel.h"
#include "cli/commands.h"
#include "cli/image_size.h"
#include "cli/study_options.h"

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

namespace ropsim {
namespace {

struct ValidateArguments {
    ValidationOptions options;
    std::string size;
    std::string blending = "auto";
    std::string draw = "geometry";
    std::uint64_t fragments = 0;
    bool json = false;
};

// That repeats this validation.
std::vector<std::string> validate_command(const ValidateArguments& arguments) {
    const ValidationOptions& options = arguments.options;
    std::vector<std::string> command{"ropsim", "validate", options.input};
    const auto add = [&](const char* name, const std::string& value) {
        command.insert(command.end(), {name, value});
    };
    for (const std::string& technique : options.techniques) add("--technique", technique);
    if (!arguments.size.empty()) add("--size", arguments.size);
    if (options.samples != 1) add("--samples", std::to_string(options.samples));
    if (options.fragments) add("--fragments", std::to_string(*options.fragments));
    if (options.scene_seed != 1) add("--scene-seed", std::to_string(options.scene_seed));
    if (options.seed != 0) add("--seed", std::to_string(options.seed));
    if (arguments.draw != "geometry") add("--draw", arguments.draw);
    if (arguments.blending != "auto") add("--blending", arguments.blending);
    add("-o", options.directory);
    return command;
}

void run_validate(ValidateArguments& arguments, bool fragments_given) {
    static const std::map<std::string, Blending> kBlending = {{"auto", Blending::kAutomatic},
                                                              {"fixed", Blending::kFixedFunction},
                                                              {"shader", Blending::kShader},
                                                              {"shader-cut", Blending::kShaderCut}};
    ValidationOptions& options = arguments.options;
    if (!arguments.size.empty()) options.size = parse_size(arguments.size);
    if (fragments_given) options.fragments = arguments.fragments;
    options.blending = kBlending.at(arguments.blending);
    options.replay = arguments.draw == "fragments";
    keep_inputs({options.input},
                files_in(options.directory, {"validation.json", "validation.md", "report.html"}));
    std::function<void(const std::string&)> progress;
    if (isatty(STDERR_FILENO) == 1)
        progress = [](const std::string& next) { fmt::print(stderr, "{}\n", next); };
    const Validation validation = run_validation(options, progress);
    write_file(options.directory + "/report.html",
               validation_report(validation, shell_line(validate_command(arguments))));
    const std::string json = options.directory + "/validation.json";
    if (arguments.json)
        fmt::print("{}", validation_json(validation));
    else
        fmt::print("{}", validation_table(validation));
    fmt::print(stderr, "{}: {}x{}, {} fragments, drawn as {} by {} ({}); {}\n", json, validation.width,
               validation.height, validation.fragments, validation.drawn, validation.renderer,
               validation.driver.version, validation.driver.summary());
    const auto differ = std::count_if(validation.techniques.begin(), validation.techniques.end(),
                                      [](const ValidatedTechnique& t) { return t.differs(); });
    if (differ > 0)
        throw UserError("validate",
                        fmt::format("{} of {} techniques differ by more than they may; {} has the first "
                                    "differing pixel of each",
                                    differ, validation.techniques.size(), json));
}

}  // namespace

void add_validate_command(CLI::App& app) {
    auto arguments = std::make_shared<ValidateArguments>();
    ValidationOptions& options = arguments->options;
    options.threads = default_threads();
    CLI::App* command =
        app.add_subcommand("validate", "Compares the model's images with the same frame drawn by OpenGL");
    command->add_option("INPUT", options.input, "A trace, or a scene or file as `capture` takes it")
        ->required();
    add_technique_option(
        *command, options.techniques,
        "NAME[:key=value,...], repeatable; default: all of the software path, as their papers "
        "store them and in float32");
    command->add_option("--size", arguments->size,
                        "Of a scene: pixels, WIDTHxHEIGHT; by default the scene's");
    command->add_option(
        "--samples", options.samples,
        "Of a scene: spatial samples a pixel, 1, 2, 4, 8 or 16; above 1 its captured fragments are "
        "drawn");
    CLI::Option* fragments = command->add_option("--fragments", arguments->fragments,
                                                 "Of a scene: about so many (its own amount unless given)");
    fragments->default_str("");
    command->add_option("--scene-seed", options.scene_seed, "Seed of everything random in the scene");
    command->add_option("--seed", options.seed, "Seed of the techniques' random draws");
    command
        ->add_option("--draw", arguments->draw,
                     "What of a scene OpenGL draws: its geometry, or the captured fragments as points")
        ->check(CLI::IsMember({"geometry", "fragments"}));
    command
        ->add_option(
            "--blending", arguments->blending,
            "fixed: by the driver's blend units, as they round; shader: in the fragment shader, rounded "
            "as the formats say (shader-cut: halves cut off); auto: fixed where it is exact")
        ->check(CLI::IsMember({"auto", "fixed", "shader", "shader-cut"}));
    command->add_option("--threads", options.threads, "Threads of the model")->check(CLI::Range(1, 1024));
    command->add_flag("--json", arguments->json, "Print validation.json instead of the table");
    command
        ->add_option(
            "-o,--output", options.directory,
            "Directory for validation.json, validation.md, report.html, difference pictures and a scene's "
            "trace")
        ->required();
    command->callback([arguments, fragments] { run_validate(*arguments, fragments->count() > 0); });
}

}  // namespace ropsim
