// `ropsim capture`: draws a scene through OpenGL and writes its fragments as a trace.
#include "base/error.h"
#include "capture/capture.h"
#include "capture/scene_list.h"
#include "cli/commands.h"
#include "cli/image_size.h"

#include <cstdio>
#include <functional>
#include <memory>
#include <string>

#include <unistd.h>

namespace ropsim {
namespace {

struct CaptureArguments {
    CaptureOptions options;
    std::string size;
    std::string view = "camera";
    std::string color = "float16";
    std::uint64_t fragments = 0;
    std::string output;
};

void run_capture(CaptureArguments& arguments, bool fragments_given) {
    if (!arguments.size.empty()) arguments.options.size = parse_size(arguments.size);
    if (arguments.color == "float32") arguments.options.color_storage = ColorStorage::kFloat32;
    arguments.options.light_view = arguments.view == "light";
    if (fragments_given) arguments.options.fragments = arguments.fragments;
    const bool terminal = isatty(STDERR_FILENO) == 1;
    std::function<void(std::uint64_t)> progress;
    if (terminal) {
        progress = [](std::uint64_t fragments) {
            fmt::print(stderr, "\rcaptured {:.1f} million fragments", static_cast<double>(fragments) * 1e-6);
            std::fflush(stderr);
        };
    }
    const CaptureSummary summary = capture_scene(arguments.options, arguments.output, progress);
    fmt::print(stderr, "{}{}: {}, {}x{}, {} fragments in {:.2f} s ({})\n", terminal ? "\r\033[K" : "",
               arguments.output, summary.description, summary.width, summary.height, summary.fragments,
               summary.seconds, summary.renderer);
}

}  // namespace

void add_capture_command(CLI::App& app) {
    auto arguments = std::make_shared<CaptureArguments>();
    CLI::App* command =
        app.add_subcommand("capture", "Draw a scene or mesh and write its transparent fragments");
    std::string scenes;
    for (const SceneInfo& scene : scene_list()) scenes += (scenes.empty() ? "" : ", ") + scene.name;
    command
        ->add_option(
            "scene", arguments->options.scene_or_file,
            "A scene (" + scenes + ") or a file: a mesh, CyHair .hair strands, or a .ply of 3D Gaussians")
        ->required();
    command->add_option("--size", arguments->size,
                        "Image size in pixels, WIDTHxHEIGHT; by default the scene's, mostly 1280x720");
    command->add_option("--samples", arguments->options.samples, "Spatial samples a pixel: 1, 2, 4, 8 or 16");
    command
        ->add_option("--view", arguments->view, "From the scene's camera, or from its light for shadow maps")
        ->check(CLI::IsMember({"camera", "light"}));
    command->add_option("--color", arguments->color, "What colours and materials are exported as")
        ->check(CLI::IsMember({"float16", "float32"}));
    CLI::Option* fragments =
        command
            ->add_option("--fragments", arguments->fragments,
                         "About so many transparent fragments (the scene's own amount unless given)")
            ->default_str("");
    command->add_option("--seed", arguments->options.seed, "Seed of everything random in the scene");
    command->add_option("-o,--output", arguments->output, "The trace to write")->required();
    command->callback([arguments, fragments] { run_capture(*arguments, fragments->count() > 0); });
}

}  // namespace ropsim
