#include "rop/sampling/sampling_options.h"

#include "base/error.h"

#include <fmt/format.h>

namespace ropsim {

SamplingOptions::SamplingOptions(Parameters& parameters, const Screen& screen)
    : spatial_samples(screen.samples) {
    read_samples(parameters);
    read_rounds(parameters);
    read_correction(parameters);
    strata_across_rounds = parameters.get_choice("strata", "all", {"all", "pass"}) == "all";
    if (parameters.get_choice("filter", "box", {"box", "gaussian"}) == "gaussian")
        filter = DisplayFilter::kGaussian;
    early_termination = parameters.get_flag("early_termination", false);
    adaptive_error = parameters.get_real("adaptive_error", 0, 0, 255);
    adaptive_rounds = static_cast<int>(parameters.get_integer("adaptive_rounds", 4, 2, kMaxSamples));
    cross_filter = static_cast<int>(parameters.get_integer("cross_filter", 0, 0, 8));
    cross_sigma = parameters.get_real("cross_sigma", 0.05, 1e-4, 1);
    check(parameters);
}

SamplingOptions SamplingOptions::depth_alone(Parameters& parameters, const Screen& screen) {
    SamplingOptions options(screen.samples);
    options.read_samples(parameters);
    options.hardware_samples = options.samples;
    return options;
}

void SamplingOptions::read_samples(Parameters& parameters) {
    samples = static_cast<int>(parameters.get_integer("samples", 8, 1, kMaxSamples));
    if (samples % spatial_samples != 0)
        throw UserError(
            parameters.where("samples"),
            fmt::format("{} stored samples over a trace of {} samples a pixel; use a multiple of {}", samples,
                        spatial_samples, spatial_samples));
}

void SamplingOptions::read_rounds(Parameters& parameters) {
    const auto hardware = static_cast<int>(parameters.get_integer("hardware_samples", 0, 0, kMaxSamples));
    hardware_samples = hardware == 0 ? samples : hardware;
    if (samples % hardware_samples != 0 || hardware_samples % spatial_samples != 0)
        throw UserError(parameters.where("hardware_samples"),
                        fmt::format("{} must divide samples={} and be a multiple of the trace's {}",
                                    hardware_samples, samples, spatial_samples));
}

void SamplingOptions::read_correction(Parameters& parameters) {
    const bool depth = parameters.get_choice("method", "basic", {"basic", "depth_based"}) == "depth_based";
    method = depth ? SampleMethod::kDepthBased : SampleMethod::kBasic;
    const std::string name = parameters.get_choice("correction", depth ? "accumulated" : "none",
                                                   {"none", "coverage", "accumulated"});
    correction = name == "none"       ? Correction::kNone
                 : name == "coverage" ? Correction::kCoverage
                                      : Correction::kAccumulated;
    merged = parameters.get_choice("passes", "separate", {"separate", "merged"}) == "merged";
    const bool edges = spatial_samples > 1;  // total alpha must know them: ST 3.5
    accumulator_per_sample =
        parameters.get_choice("accumulator", edges && merged && depth ? "sample" : "pixel",
                              {"pixel", "sample"}) == "sample";
    total_per_sample =
        parameters.get_choice("total_alpha", edges ? "sample" : "pixel", {"pixel", "sample"}) == "sample";
}

void SamplingOptions::check(const Parameters& parameters) const {
    if (!depth_based() && correction == Correction::kAccumulated)
        throw UserError(parameters.where("correction"),
                        "only method=depth_based accumulates alpha; use correction=coverage");
    if (!depth_based() && accumulator_per_sample)
        throw UserError(parameters.where("accumulator"), "only method=depth_based has an accumulator");
    if (merged && !has_total())
        throw UserError(parameters.where("passes"),
                        "merges the total alpha pass, which correction=none does not have");
    if (merged && rounds() > 1)
        throw UserError(parameters.where("passes"),
                        "would draw total alpha again in every round; use passes=separate, or one round");
    if (merged && depth_based() && total_per_sample != accumulator_per_sample)
        throw UserError(parameters.where("passes"),
                        "keeps total alpha beside the accumulator: both a pixel or both a sample");
    if (!has_total() && depth_based() && rounds() > 1 && spatial_samples > 1)
        throw UserError(
            parameters.where("correction"),
            "over several rounds the background is known a pixel only: use a trace of one sample");
    if (adaptive() && depth_based() && !has_total())
        throw UserError(parameters.where("adaptive_error"),
                        "would not see the noise of the background that correction=none leaves; use "
                        "correction=accumulated or correction=coverage");
    if (adaptive() && accumulator_per_sample)
        throw UserError(parameters.where("adaptive_error"), "judges a pixel; use accumulator=pixel");
    if (filter == DisplayFilter::kGaussian && depth_based() && !accumulator_per_sample)
        throw UserError(parameters.where("filter"),
                        "weighs samples, which the accumulator must keep apart; add accumulator=sample");
    if (filter == DisplayFilter::kGaussian && has_total() && !total_per_sample)
        throw UserError(parameters.where("filter"),
                        "weighs samples, which total alpha must keep apart; add total_alpha=sample");
    if (filter == DisplayFilter::kGaussian && gathers())
        throw UserError(parameters.where("filter"),
                        "needs the samples of all rounds; use one round (hardware_samples=0)");
    if (adaptive() && rounds() < 3)
        throw UserError(
            parameters.where("adaptive_error"),
            fmt::format("{} rounds leave nothing to adapt; set hardware_samples to samples / 3 or "
                        "less",
                        rounds()));
    if (cross_filter > 0 &&
        (!depth_based() || accumulator_per_sample || correction != Correction::kAccumulated))
        throw UserError(
            parameters.where("cross_filter"),
            "works on one corrected colour a pixel; use method=depth_based, accumulator=pixel and "
            "correction=accumulated");
    if (cross_filter > 0 && filter != DisplayFilter::kBox)
        throw UserError(parameters.where("cross_filter"), "and filter=gaussian are two footprints; use one");
}

}  // namespace ropsim
