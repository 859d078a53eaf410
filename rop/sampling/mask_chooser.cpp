#include "rop/sampling/mask_chooser.h"

#include "base/error.h"

#include <string>

namespace ropsim {

MaskChooser::MaskChooser(Parameters& parameters, const Screen& screen, const SamplingOptions& options)
    : screen_(screen), options_(&options) {
    const std::string masks = parameters.get_choice(
        "masks", "choose", {"coin", "choose", "run", "table", "alpha_to_coverage", "blue_noise"});
    masks_ = masks == "coin"                ? Masks::kCoin
             : masks == "choose"            ? Masks::kChoose
             : masks == "run"               ? Masks::kRun
             : masks == "table"             ? Masks::kTable
             : masks == "alpha_to_coverage" ? Masks::kAlphaToCoverage
                                            : Masks::kBlueNoise;
    const std::string seed = parameters.get_choice(
        "seed_from", "primitive", {"primitive", "depth", "object", "object_facing", "pattern"});
    seed_from_ = seed == "primitive"       ? SeedFrom::kPrimitive
                 : seed == "depth"         ? SeedFrom::kDepth
                 : seed == "object"        ? SeedFrom::kObject
                 : seed == "object_facing" ? SeedFrom::kObjectFacing
                                           : SeedFrom::kPattern;
    dithers_ = parameters.get_choice("rounding", "random", {"random", "dither"}) == "dither";
    depth_first_ = parameters.get_choice("depth_test", "last", {"last", "first"}) == "first";
    bright_samples_ = static_cast<int>(
        parameters.get_integer("bright_samples", options.samples, 1, SamplingOptions::kMaxSamples));
    dark_below_ = static_cast<float>(parameters.get_real("dark_below", 0.25, 0, 65504));
    check(parameters);
    if (masks_ == Masks::kTable)
        table_ = std::make_unique<MaskTable>(options.strata_across_rounds ? options.samples
                                                                          : options.hardware_samples);
    if (masks_ == Masks::kBlueNoise) BlueNoise::instance();
}

std::uint32_t MaskChooser::pixel_constant(glm::vec3 background) const {
    if (!samples_vary()) return static_cast<std::uint32_t>(options_->hardware_samples);
    const float luminance = 0.2126f * background.r + 0.7152f * background.g + 0.0722f * background.b;
    return static_cast<std::uint32_t>(luminance < dark_below_ ? options_->samples : bright_samples_);
}

std::uint64_t MaskChooser::random_key(const Fragment& f) const {
    // Blue noise is a pattern over the pixels of a surface: its key leaves them out.
    const std::uint64_t place =
        masks_ == Masks::kBlueNoise
            ? 0
            : static_cast<std::uint64_t>(f.y) * static_cast<std::uint64_t>(screen_.width) + f.x + 1;
    const std::uint64_t seed = screen_.seed * 0x9E3779B97F4A7C15ull;
    const auto key = [&](std::uint64_t first, std::uint32_t second) {
        return mix64(mix64(seed + first) ^ ((place - 1) << 32) ^ second);
    };
    const std::uint32_t object = f.draw < screen_.objects.size() ? screen_.objects[f.draw] : f.draw;
    switch (seed_from_) {
        case SeedFrom::kPrimitive:
            return key(f.draw, primitive_number(f));
        case SeedFrom::kDepth:
            return key(1ull << 32, std::bit_cast<std::uint32_t>(f.z));
        case SeedFrom::kObject:
            return key((2ull << 32) + object, 0);
        case SeedFrom::kObjectFacing:
            return key((2ull << 32) + object, faces_back(f) ? 1 : 0);
        case SeedFrom::kPattern:
            break;
    }
    return screen_.seed + primitive_number(f) + static_cast<std::uint64_t>(f.x) * f.x + f.y;
}

void MaskChooser::check(const Parameters& parameters) const {
    if (dithers_ && masks_ != Masks::kChoose && masks_ != Masks::kRun)
        throw UserError(parameters.where("rounding"),
                        "dithers how many samples are chosen: use masks=choose or masks=run");
    if (depth_first_ && masks_ != Masks::kChoose)
        throw UserError(parameters.where("depth_test"),
                        "first chooses among the samples that survive: use masks=choose");
    if (depth_first_ && options_->rounds() > 1 && options_->strata_across_rounds)
        throw UserError(parameters.where("depth_test"),
                        "first knows the samples of one round only: use strata=pass");
    if (seed_from_ == SeedFrom::kDepth && masks_ == Masks::kBlueNoise)
        throw UserError(
            parameters.where("seed_from"),
            "depth differs from pixel to pixel, and blue noise lies between the pixels of one seed; use "
            "primitive, object or object_facing");
    if (seed_from_ == SeedFrom::kPattern && masks_ != Masks::kTable)
        throw UserError(parameters.where("seed_from"), "pattern is the index into masks=table");
    if (!samples_vary()) return;
    if (bright_samples_ > options_->samples || bright_samples_ % options_->spatial_samples != 0)
        throw UserError(parameters.where("bright_samples"),
                        fmt::format("{} must be at most samples={} and a multiple of the trace's {}",
                                    bright_samples_, options_->samples, options_->spatial_samples));
    if (options_->rounds() > 1 || options_->filter != DisplayFilter::kBox || !uses_any_samples())
        throw UserError(parameters.where("bright_samples"),
                        "needs one round, filter=box, accumulator=pixel and, with method=depth_based, "
                        "correction=accumulated");
}

bool MaskChooser::uses_any_samples() const {
    if (options_->accumulator_per_sample) return false;
    return !options_->depth_based() || options_->correction == Correction::kAccumulated;
}

}  // namespace ropsim
