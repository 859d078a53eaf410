// `ropsim diff`: the error figures between two images.
#include "base/error.h"
#include "cli/commands.h"
#include "rop/image_metrics.h"

#include <cmath>
#include <cstdio>
#include <memory>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {
namespace {

struct DiffOptions {
    std::string image;
    std::string reference;
    bool json = false;
};

// JSON has neither infinity nor NaN: null stands for an infinite PSNR (equal images), an infinite difference
// (values that are not finite) and what was not measured.
nlohmann::ordered_json number(double value) {
    return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

// Pixels with a transparent fragment, where the second image says so (a file of `ropsim reference` does).
std::vector<std::uint8_t> covered_pixels(const Image& reference) {
    std::vector<std::uint8_t> covered;
    const int layers = reference.channel("layers");
    if (layers < 0) return covered;
    covered.reserve(reference.values.size() / reference.channels.size());
    for (int y = 0; y < reference.height; ++y)
        for (int x = 0; x < reference.width; ++x)
            covered.push_back(reference.pixel(x, y)[layers] > 0 ? 1 : 0);
    return covered;
}

void print_json(const ImageError& error) {
    const nlohmann::ordered_json json{{"rmse8", number(error.rmse8)},
                                      {"rmse8_covered", number(error.rmse8_covered)},
                                      {"psnr_db", number(error.psnr_db)},
                                      {"max_abs", number(error.max_abs)},
                                      {"mean_signed8", number(error.mean_signed8)},
                                      {"ssim", number(error.ssim)},
                                      {"flip", number(error.flip)}};
    fmt::print("{}\n", json.dump(2));
}

void print_text(const ImageError& error) {
    fmt::print("RMSE                 {:12.6f}  of 255\n", error.rmse8);
    if (!std::isnan(error.rmse8_covered))
        fmt::print("RMSE, covered pixels {:12.6f}  of 255\n", error.rmse8_covered);
    fmt::print("PSNR                 {:12.4f}  dB\n", error.psnr_db);
    fmt::print("largest difference   {:12.6f}  linear\n", error.max_abs);
    fmt::print("mean signed error    {:12.6f}  of 255\n", error.mean_signed8);
    fmt::print("SSIM                 {:12.6f}\n", error.ssim);
    fmt::print("FLIP                 {:12.6f}\n", error.flip);
}

void run_diff(const DiffOptions& options) {
    const Image image = read_exr(options.image);
    const Image reference = read_exr(options.reference);
    for (const auto& [path, opened] :
         {std::pair{&options.image, &image}, std::pair{&options.reference, &reference}})
        for (const char* channel : {"R", "G", "B"})
            if (opened->channel(channel) < 0)
                throw UserError(
                    *path, fmt::format("has no channel {}; an image to compare needs R, G and B", channel));
    if (image.width != reference.width || image.height != reference.height)
        throw UserError(
            options.image,
            fmt::format("is {}x{} pixels, but {} is {}x{}; compare images of one size", image.width,
                        image.height, options.reference, reference.width, reference.height));
    const ImageError error = image_error(image, reference, covered_pixels(reference));
    if (options.json)
        print_json(error);
    else
        print_text(error);
}

}  // namespace

void add_diff_command(CLI::App& app) {
    auto options = std::make_shared<DiffOptions>();
    CLI::App* command =
        app.add_subcommand("diff", "Error figures between two OpenEXR images: RMSE, PSNR, SSIM, FLIP");
    command->add_option("A", options->image, "image")->required();
    command->add_option("B", options->reference, "image that is taken as exact")->required();
    command->add_flag("--json", options->json,
                      "print JSON; null is infinite (PSNR of equal images) or not measured");
    command->callback([options] { run_diff(*options); });
}

}  // namespace ropsim
