#include "rop/sampling/sample_surfaces.h"

#include "rop/display_filter.h"

#include <algorithm>
#include <limits>

namespace ropsim {

namespace {

constexpr float kFarthest = std::numeric_limits<float>::infinity();

// Basic samples are a mean of what they hold. Depth-based ones sum what they leave visible, which is more
// than they hide where their noise has it so; divided by the accumulated alpha it is a mean again, divided by
// the share of samples that hold a fragment it is not.
LightLaw light_of(const SamplingOptions& options) {
    if (!options.depth_based()) return LightLaw::kMean;
    switch (options.correction) {
        case Correction::kAccumulated:
            return LightLaw::kScaled;
        case Correction::kCoverage:
            return LightLaw::kAdded;
        case Correction::kNone:
            break;
    }
    return LightLaw::kConserved;
}

}  // namespace

void declare_samples(const SamplingOptions& options, const TechniqueFormats& formats,
                     Declaration& declaration, SampleSurfaces& surfaces) {
    const int samples = options.hardware_samples;
    declaration.light = light_of(options);
    surfaces.restored = {0};
    surfaces.depth = declaration.surface(
        "depth", samples, Layout::kPlanar, options.over_opaque() ? Initial::kOpaqueDepth : Initial::kClear,
        {FieldSpec::real(formats.of("depth", Format::kFloat32), 1, kFarthest, ValueRange::kUnit)})[0];
    const int totals = options.total_per_sample ? samples : 1;
    if (options.depth_based()) {
        // Merged, the fourth channel multiplies while the other three add (as blend state of one target
        // allows), and the weights move to the one-channel target.
        const int elements = options.accumulator_per_sample ? samples : 1;
        const Format format = formats.of("accumulation", Format::kFloat16);
        const auto fields =
            declaration.surface("accumulation", elements, Layout::kPlanar, Initial::kClear,
                                {FieldSpec::real(format, 3, 0.0f, ValueRange::kSum),
                                 FieldSpec::real(format, 1, options.merged ? 1.0f : 0.0f,
                                                 options.merged ? ValueRange::kUnit : ValueRange::kSum)});
        surfaces.accumulated = fields[0];
        surfaces.weight = fields[1];
        if (!options.has_total()) return;
        surfaces.total = declaration.surface(
            "total_alpha", totals, Layout::kPlanar, Initial::kClear,
            {FieldSpec::real(formats.of("total_alpha", Format::kFloat16), 1, options.merged ? 0.0f : 1.0f,
                             options.merged ? ValueRange::kSum : ValueRange::kUnit)})[0];
        if (options.merged) std::swap(surfaces.total, surfaces.weight);
        return;
    }
    surfaces.restored.push_back(1);
    if (options.over_opaque()) {
        surfaces.color = declaration.surface(
            "color", samples, Layout::kPlanar, Initial::kOpaqueColor,
            {FieldSpec::real(formats.rgb("color", Format::kUnorm8), 4, 1.0f, ValueRange::kColor)})[0];
        return;
    }
    surfaces.color = declaration.surface(
        "color", samples, Layout::kPlanar, Initial::kClear,
        {FieldSpec::real(formats.of("color", Format::kUnorm8), 4, 0.0f, ValueRange::kColor)})[0];
    surfaces.total = declaration.surface(
        "total_alpha", totals, Layout::kPlanar, Initial::kClear,
        {FieldSpec::real(formats.of("total_alpha", Format::kFloat16), 1, 1.0f, ValueRange::kUnit)})[0];
}

void declare_rounds(const SamplingOptions& options, const TechniqueFormats& formats, Declaration& declaration,
                    SampleSurfaces& surfaces) {
    if (options.early_termination) {
        surfaces.restored.push_back(static_cast<int>(declaration.surfaces.size()));
        surfaces.farthest =
            declaration.surface("farthest", 1, Layout::kInterleaved, Initial::kClear,
                                {FieldSpec::real(surfaces.depth.format, 1, kFarthest, ValueRange::kUnit)})[0];
    }
    if (options.gathers()) {
        const Format format = formats.of("sum", Format::kFloat16);
        if (options.depth_based()) {
            surfaces.sum_coverage =
                declaration.surface("sum", 1, Layout::kInterleaved, Initial::kClear,
                                    {FieldSpec::real(format, 1, 0.0f, ValueRange::kSum)})[0];
        } else {
            const auto fields = declaration.surface("sum", 1, Layout::kInterleaved, Initial::kClear,
                                                    {FieldSpec::real(format, 3, 0.0f, ValueRange::kSum),
                                                     FieldSpec::real(format, 1, 0.0f, ValueRange::kSum)});
            surfaces.sum = fields[0];
            surfaces.sum_coverage = fields[1];
        }
    }
    if (!options.adaptive()) return;
    surfaces.rounds = declaration.surface("rounds", 1, Layout::kInterleaved, Initial::kClear,
                                          {FieldSpec::integer(8, 0)})[0];
    surfaces.statistics =
        declaration.surface("statistics", 1, Layout::kInterleaved, Initial::kClear,
                            {FieldSpec::real(Format::kFloat32, 4, 0.0f, ValueRange::kSum)})[0];
}

std::vector<SamplePass> declare_passes(const SamplingOptions& options, const std::string& nothing,
                                       const std::string& write, Declaration& declaration,
                                       const SampleSurfaces& surfaces, SamplePaths& paths) {
    std::vector<SamplePass> kinds;
    const auto path = [&](int& number, const std::string& name) {
        number = static_cast<int>(declaration.paths.size());
        declaration.paths.push_back(name);
    };
    const auto pass = [&](SamplePass kind, const std::string& name, Shading shading, PassKind over) {
        kinds.push_back(kind);
        declaration.passes.push_back({name, shading, over, {}});
    };
    path(paths.nothing, nothing);
    path(paths.write, write);
    if (options.adaptive()) path(paths.settled_write, "settled_write");
    if (options.early_termination) path(paths.saturated_write, "saturated_write");
    if (options.has_total() && !options.merged) {
        pass(SamplePass::kTotalAlpha, "total_alpha", Shading::kAlphaOnly, PassKind::kGeometry);
        path(paths.total_alpha, "total_alpha");
    }
    declaration.repeat.first = static_cast<int>(kinds.size());
    const bool depth = options.depth_based();
    pass(SamplePass::kWrite, depth ? "stochastic_depth" : "draw",
         depth ? Shading::kAlphaOnly : Shading::kFull, PassKind::kGeometry);
    declaration.passes.back().restores = surfaces.restored;
    if (depth) {
        pass(SamplePass::kAccumulate, "accumulate", Shading::kFull, PassKind::kGeometry);
        path(paths.accumulate, "accumulate");
        path(paths.unseen, "unseen");
        if (options.adaptive()) path(paths.settled_accumulate, "settled_accumulate");
        if (options.early_termination) path(paths.saturated_accumulate, "saturated_accumulate");
    }
    if (options.gathers()) {
        pass(SamplePass::kGather, "gather", Shading::kAlphaOnly, PassKind::kImage);
        if (options.adaptive()) {
            path(paths.go_on, "go_on");
            path(paths.settle, "settle");
            path(paths.settled, "settled");
        } else {
            path(paths.gather, "gather");
        }
    }
    declaration.repeat.last = static_cast<int>(kinds.size()) - 1;
    declaration.repeat.rounds = options.rounds();
    declaration.repeat.path = paths.go_on;
    if (options.cross_filter > 0) {
        pass(SamplePass::kCorrect, "correct", Shading::kAlphaOnly, PassKind::kImage);
        path(paths.correct, "correct");
    }
    path(paths.resolve, "resolve");
    declaration.display_filter = options.filter;
    declaration.footprint = std::max(filter_footprint(options.filter), options.cross_filter);
    declaration.background_footprint = filter_footprint(options.filter);
    declaration.resolve_reads_background = !options.over_opaque();
    declaration.uses_coverage = true;
    declaration.random = true;
    return kinds;
}

}  // namespace ropsim
