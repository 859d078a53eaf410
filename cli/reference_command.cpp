// `ropsim reference`: exact compositing of a trace in double precision.
#include "base/outputs.h"
#include "base/parallel.h"
#include "cli/commands.h"
#include "rop/reference.h"

#include <cctype>
#include <filesystem>
#include <memory>
#include <string>

namespace ropsim {
namespace {

struct ReferenceOptions {
    std::string trace;
    std::string output;
    std::string transmission = "alpha";
    int threads = 0;
};

bool names_png(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return extension == ".png";
}

void run_reference(const ReferenceOptions& options) {
    keep_inputs({options.trace}, {options.output});
    TraceReader trace(options.trace);
    const int threads = options.threads > 0 ? options.threads : default_threads();
    const auto transmission =
        options.transmission == "colored" ? Transmission::kColored : Transmission::kAlpha;
    const Image image = cached_reference_image(trace, threads, DisplayFilter::kBox, transmission);
    if (names_png(options.output))
        write_png(options.output, image);
    else
        write_exr(options.output, image);
}

}  // namespace

void add_reference_command(CLI::App& app) {
    auto options = std::make_shared<ReferenceOptions>();
    CLI::App* command = app.add_subcommand(
        "reference", "Composites a trace exactly: channels R, G, B, A, layers and ties as 32-bit floats");
    command->add_option("TRACE", options->trace, "fragment trace")->required();
    command
        ->add_option("-o,--output", options->output,
                     "OpenEXR file to write; NAME.png: its colours as 8-bit sRGB")
        ->required();
    command
        ->add_option("--transmission", options->transmission,
                     "what a fragment lets through: alpha: 1 - alpha; colored: 1 - alpha (1 - t), with the "
                     "transmission t of its material, per channel")
        ->check(CLI::IsMember({"alpha", "colored"}))
        ->capture_default_str();
    command->add_option("--threads", options->threads, "threads; 0: one per core")
        ->check(CLI::Range(0, 1024));
    command->callback([options] { run_reference(*options); });
}

}  // namespace ropsim
