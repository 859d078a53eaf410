// `ropsim trace info`: what a trace is like.
#include "base/error.h"
#include "base/outputs.h"
#include "cli/trace_commands.h"
#include "cli/trace_info.h"
#include "traces/image.h"
#include "traces/overdraw_picture.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>

#include <fmt/format.h>

namespace ropsim {

namespace {

struct InfoOptions {
    std::string path, picture, counted = "all";
    bool json = false;
};

void write_picture(const InfoOptions& options, const TraceHeader& header, const PixelLayers& layers) {
    const std::vector<std::uint32_t>& counts = options.counted == "visible" ? layers.visible : layers.all;
    write_png(options.picture, overdraw_picture(counts, header.width, header.height));
    const std::uint32_t largest = *std::max_element(counts.begin(), counts.end());
    std::fprintf(stderr,
                 "ropsim: %s: %sfragments a pixel, logarithmic from 1 (violet) to %u (yellow), a tick at "
                 "each power of "
                 "two; black: none\n",
                 options.picture.c_str(), options.counted == "visible" ? "visible " : "", largest);
}

}  // namespace

void add_trace_info(CLI::App& trace) {
    const auto options = std::make_shared<InfoOptions>();
    CLI::App* command =
        trace.add_subcommand("info", "Describe a trace: fragments, depth complexity, alpha, hash");
    command->add_option("TRACE", options->path, "trace file")->required();
    command->add_flag("--json", options->json, "write JSON to stdout");
    command->add_option("--overdraw", options->picture, "write a heat map of fragments a pixel to this .png");
    command
        ->add_option("--overdraw-of", options->counted, "which fragments the heat map counts: all or visible")
        ->check(CLI::IsMember({"all", "visible"}));
    command->callback([options] {
        if (!options->picture.empty() && !options->picture.ends_with(".png"))
            throw UserError(options->picture, "the heat map is a PNG file; name it .png");
        keep_inputs({options->path}, {options->picture});
        TraceReader reader(options->path);
        PixelLayers layers;
        const TraceStatistics statistics = measure_trace(reader, &layers);
        const std::string text =
            options->json ? trace_info_json(reader, statistics) : trace_info_text(reader, statistics);
        std::fputs(text.c_str(), stdout);
        if (!options->picture.empty()) write_picture(*options, reader.header(), layers);
    });
}

}  // namespace ropsim
