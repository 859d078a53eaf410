#include "analysis/ambient_study.h"

#include "analysis/ambient_blur.h"
#include "analysis/ambient_cost.h"
#include "base/error.h"
#include "base/outputs.h"
#include "rop/reference.h"
#include "traces/depth_test.h"
#include "traces/image.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace ropsim {

namespace {

std::string draw_list(const TraceHeader& header) {
    std::string names;
    for (const Draw& draw : header.draws)
        names += fmt::format("{}'{}'", names.empty() ? "" : ", ", draw.name);
    return names.empty() ? "none" : names;
}

CutoutSettings cutout_settings(const AmbientOptions& options, const TraceHeader& header) {
    CutoutSettings settings;
    settings.solid_alpha = static_cast<float>(options.solid_alpha);
    settings.solid.assign(header.draws.size(), false);
    for (const std::string& name : options.solid) {
        bool found = false;
        for (std::size_t d = 0; d < header.draws.size(); ++d) {
            if (header.draws[d].name != name) continue;
            if (!header.draws[d].depth_test)
                throw UserError("--solid", fmt::format("'{}' is drawn without depth test, so its whole parts "
                                                       "cannot be in the depth buffer; leave it out",
                                                       name));
            settings.solid[d] = found = true;
        }
        if (!found)
            throw UserError("--solid", fmt::format("{} has no draw '{}'; its draws are {}", options.trace,
                                                   name, draw_list(header)));
    }
    return settings;
}

void check_samples(const TraceReader& trace) {
    if (trace.header().samples != 1)
        throw UserError(trace.path(),
                        fmt::format("has {} spatial samples a pixel; ambient occlusion is computed from one "
                                    "depth a pixel: capture the scene with --samples 1",
                                    trace.header().samples));
}

void check_depth_buffer(const Cutouts& cutouts, const AmbientOptions& options, const TraceReader& trace) {
    const auto drawn = [](float depth) { return std::isfinite(depth); };
    if (std::any_of(cutouts.depth.depth.begin(), cutouts.depth.depth.end(), drawn)) return;
    throw UserError(
        trace.path(),
        fmt::format("leaves the depth buffer empty: no opaque layer, and no fragment of alpha {} or "
                    "more in the draws that --solid names; its draws are {}",
                    options.solid_alpha, draw_list(trace.header())));
}

float light(const AmbientOptions& options, float ambient) {
    return static_cast<float>(1 - options.share * (1 - static_cast<double>(ambient)));
}

// Where the opaque layer itself is in the depth buffer; whole fragments before it hide it.
void shade_opaque(TraceHeader& header, const Cutouts& cutouts, AmbientStudy& study) {
    if (!header.opaque) return;
    for (std::size_t i = 0; i < cutouts.depth.depth.size(); ++i) {
        if (!std::isfinite(header.opaque->depth[i]) || cutouts.depth.depth[i] < header.opaque->depth[i])
            continue;
        const float ambient = study.obscurance.ambient[i];
        ++study.opaque_pixels;
        study.opaque_ambient += static_cast<double>(ambient);
        for (std::size_t c = 0; c < 3; ++c) header.opaque->rgb[3 * i + c] *= light(study.options, ambient);
    }
}

// Every fragment of the trace, by draw.
void count_fragments(TraceReader& trace, const Cutouts& cutouts, const CutoutSettings& settings,
                     const std::vector<float>& ambient, std::vector<AmbientCounts>& draws) {
    const TraceHeader& header = trace.header();
    for (const CutoutFragment& f : cutouts.fragments) {
        AmbientCounts& counts = draws[f.draw];
        ++counts.fragments;
        counts.in_front += f.in_front ? 1 : 0;
        counts.largest_alpha = std::max(counts.largest_alpha, f.a);
        const double value = static_cast<double>(ambient[f.arrival]);
        switch (f.kind) {
            case AmbientKind::kHidden:
                ++counts.hidden;
                break;
            case AmbientKind::kOther:
                ++counts.other;
                break;
            case AmbientKind::kSolid:
                ++counts.solid;
                counts.solid_ambient += value;
                break;
            case AmbientKind::kLine:
            case AmbientKind::kBox:
                ++(f.kind == AmbientKind::kLine ? counts.line : counts.box);
                counts.inferred_ambient += value;
                break;
        }
    }
    const OpaqueDepthTest test(header);
    FragmentChunk chunk;
    trace.rewind();
    while (trace.next(chunk, kNoChannels)) {
        for (const Fragment& f : chunk.fragments) {
            if (settings.solid[f.draw]) continue;
            draws[f.draw].in_front += test.visible_samples(f, DepthSlope{}) != 0 ? 1 : 0;
            const bool visible =
                (f.coverage & 1u) != 0 && (!header.draws[f.draw].depth_test ||
                                           f.z < cutouts.depth.depth[cutouts.depth.index(f.x, f.y)]);
            ++draws[f.draw].fragments;
            ++(visible ? draws[f.draw].other : draws[f.draw].hidden);
        }
    }
    trace.rewind();
}

std::uint32_t mean_over(std::uint64_t sum, std::uint64_t count) {
    return static_cast<std::uint32_t>((sum + count / 2) / count);
}

// Adds what inference costs to the shaders, spread over the fragments that pay for them in a timed run: those
// that the opaque layer does not cull.
void charge_shaders(AmbientStudy& study, TraceHeader& header) {
    for (const Draw& draw : header.draws) study.shaders_before.push_back(draw.full);
    const std::uint32_t bytes = ambient_bytes(study.options.obscurance.format);
    const ShaderCost line = line_cost(study.options.inference, bytes);
    const ShaderCost box = box_cost(study.options.inference, bytes);
    const ShaderCost solid = solid_cost(bytes);
    for (std::size_t d = 0; d < header.draws.size(); ++d) {
        const AmbientCounts& counts = study.draws[d];
        const std::uint64_t lines = study.options.infer ? counts.line : 0;
        const std::uint64_t boxes = study.options.infer ? counts.box : 0;
        if (lines + boxes + counts.solid == 0) continue;
        const auto mean = [&](std::uint32_t ShaderCost::*part) {
            return mean_over(lines * (line.*part) + boxes * (box.*part) + counts.solid * (solid.*part),
                             counts.in_front);
        };
        Draw& draw = header.draws[d];
        draw.full.alu_instructions += mean(&ShaderCost::alu_instructions);
        draw.full.texture_fetches += mean(&ShaderCost::texture_fetches);
        draw.full.texture_bytes += mean(&ShaderCost::texture_bytes);
        draw.cost_source += "; and ambient occlusion, mean of the fragments in front of the opaque layer";
    }
    for (const Draw& draw : header.draws) study.shaders_after.push_back(draw.full);
}

void write_trace(TraceReader& trace, TraceHeader header, const std::vector<float>& ambient,
                 const AmbientOptions& options, const std::string& path) {
    header.non_finite = false;
    TraceWriter writer(path, std::move(header));
    FragmentChunk chunk;
    std::size_t arrival = 0;
    trace.rewind();
    while (trace.next(chunk)) {
        for (Fragment& f : chunk.fragments) {
            const float factor = light(options, ambient[arrival++]);
            f.r *= factor;
            f.g *= factor;
            f.b *= factor;
        }
        writer.append(chunk);
    }
    trace.rewind();
    writer.finish();
}

void write_pictures(TraceReader& trace, const AmbientStudy& study) {
    const std::string& directory = study.options.directory;
    Image buffer(study.width, study.height, {"AO"});
    buffer.values = study.obscurance.ambient;
    write_exr(directory + "/ao.exr", buffer);
    Image grey(study.width, study.height, {"R", "G", "B"});
    for (std::size_t i = 0; i < buffer.values.size(); ++i)
        std::fill_n(&grey.values[3 * i], 3, buffer.values[i]);
    write_png(directory + "/ao.png", grey);
    write_png(directory + "/before.png", reference_image(trace, study.options.threads));
    TraceReader shaded(directory + "/ambient.trace");
    write_png(directory + "/after.png", reference_image(shaded, study.options.threads));
}

}  // namespace

void AmbientCounts::add(const AmbientCounts& counts) {
    fragments += counts.fragments;
    hidden += counts.hidden;
    other += counts.other;
    solid += counts.solid;
    in_front += counts.in_front;
    line += counts.line;
    box += counts.box;
    solid_ambient += counts.solid_ambient;
    inferred_ambient += counts.inferred_ambient;
    largest_alpha = std::max(largest_alpha, counts.largest_alpha);
}

AmbientStudy study_ambient(const AmbientOptions& options) {
    AmbientStudy study;
    study.options = options;
    const auto start = std::chrono::steady_clock::now();
    TraceReader trace(options.trace);
    check_samples(trace);
    TraceHeader header = trace.header();
    const AmbientView view(header, trace.path());
    const CutoutSettings settings = cutout_settings(options, header);
    study.trace_hash = trace.hash();
    study.width = header.width;
    study.height = header.height;
    Cutouts cutouts = read_cutouts(trace, settings);
    check_depth_buffer(cutouts, options, trace);
    start_directory(options.directory, {"ambient.json"});
    study.obscurance = ambient_obscurance(cutouts.depth, view, options.obscurance, options.threads);
    study.blur_taps = blur_ambient(study.obscurance.ambient, cutouts.depth, view, options.blur,
                                   options.obscurance.format, options.threads);
    const AmbientInference inference(cutouts.depth, study.obscurance.ambient, view, options.inference);
    std::vector<float> ambient(cutouts.trace_fragments, 1.0f);
    study.inference = infer_ambient(cutouts, settings, options.helpers, inference, study.obscurance.ambient,
                                    options.infer, options.threads, ambient);
    study.edges = edge_step(cutouts, ambient, options.share);
    for (const Draw& draw : header.draws) study.draw_names.push_back(draw.name);
    study.draws.resize(header.draws.size());
    count_fragments(trace, cutouts, settings, ambient, study.draws);
    shade_opaque(header, cutouts, study);
    charge_shaders(study, header);
    write_trace(trace, std::move(header), ambient, options, options.directory + "/ambient.trace");
    study.host_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    write_pictures(trace, study);
    return study;
}

}  // namespace ropsim
