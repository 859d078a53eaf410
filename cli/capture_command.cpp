// `ropsim capture`: draws a scene through OpenGL and writes its fragments as a trace.
#include "base/error.h"
#include "capture/capture.h"
#include "cli/commands.h"

#include <charconv>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>

#include <unistd.h>

namespace ropsim {
namespace {

struct CaptureArguments {
    CaptureOptions options;
    std::string size = "1280x720";
    std::uint64_t fragments = 0;
    std::string output;
};

// "1280x720" into width and height.
void parse_size(const std::string& text, CaptureOptions& options) {
    const char* end = text.data() + text.size();
    const auto width = std::from_chars(text.data(), end, options.width);
    if (width.ec == std::errc() && width.ptr != end && *width.ptr == 'x') {
        const auto height = std::from_chars(width.ptr + 1, end, options.height);
        if (height.ec == std::errc() && height.ptr == end) return;
    }
    throw UserError("--size", fmt::format("'{}' is not WIDTHxHEIGHT in pixels, e.g. 1280x720", text));
}

void run_capture(CaptureArguments& arguments, bool fragments_given) {
    parse_size(arguments.size, arguments.options);
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
               arguments.output, summary.description, arguments.options.width, arguments.options.height,
               summary.fragments, summary.seconds, summary.renderer);
}

}  // namespace

void add_capture_command(CLI::App& app) {
    auto arguments = std::make_shared<CaptureArguments>();
    CLI::App* command =
        app.add_subcommand("capture", "Draw a scene or mesh and write its transparent fragments");
    std::string scenes;
    for (const SceneInfo& scene : scene_list()) scenes += (scenes.empty() ? "" : ", ") + scene.name;
    command->add_option("scene", arguments->options.scene_or_mesh, "A scene (" + scenes + ") or a mesh file")
        ->required();
    command->add_option("--size", arguments->size, "Image size in pixels, WIDTHxHEIGHT");
    command->add_option("--samples", arguments->options.samples, "Spatial samples a pixel");
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
