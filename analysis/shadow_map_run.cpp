#include "analysis/shadow_map_run.h"

#include "base/error.h"
#include "rop/registry.h"

namespace ropsim {

namespace {

constexpr const char* kTechnique = "shadow_map";
constexpr const char* kColored = "colored_shadow_map";
constexpr std::uint32_t kOpaqueDepthBytes = 4;  // the depth buffer of the opaque pass

TechniqueSpec shadow_technique(const std::string& text) {
    TechniqueSpec spec = parse_technique(text, "--technique");
    if (spec.name != kTechnique && spec.name != kColored)
        throw UserError("--technique", fmt::format("'{}' stores no shadow map; use {} or {}[:key=value,...]",
                                                   spec.name, kTechnique, kColored));
    return spec;
}

// Takes the maps out of the frame's pixels.
void take_maps(ShadowMapRun& run, bool colored, const StoreMap& stores, const TraceHeader& header) {
    if (colored) {
        run.colored = ColoredShadowOptions::read(run.technique);
        for (const std::string& surface : run.colored.surfaces())
            run.wavelengths.push_back(stored_depths_of(run.declaration, stores, header, surface));
        run.sample_bytes = static_cast<std::uint32_t>(run.declaration.surfaces.front().element_bytes());
        run.opaque_bytes = kOpaqueDepthBytes;
        return;
    }
    run.map = stored_shadow_map(run.declaration, stores, header);
    for (const Surface& s : run.declaration.surfaces)
        (s.name == "depth" ? run.sample_bytes : run.total_alpha_bytes) =
            static_cast<std::uint32_t>(s.element_bytes());
    if (run.map.corrected()) run.opaque_bytes = kOpaqueDepthBytes;
}

}  // namespace

ShadowMapRun draw_shadow_map(const ShadowMapOptions& options) {
    ShadowMapRun run;
    TechniqueSpec spec = shadow_technique(options.technique);
    run.hardware = hardware_parameters(options.hardware);
    for (const std::string& setting : options.settings) set_from_text(run.hardware, setting, "--set");
    const MachineConfig config = machine_config(run.hardware, options.hardware);
    run.hardware.close();
    TraceReader trace(options.trace);
    const TraceHeader& header = trace.header();
    if (header.samples != 1)
        throw UserError(options.trace, fmt::format("has {} spatial samples a pixel; capture the light's view "
                                                   "with --samples 1",
                                                   header.samples));
    const auto operation = make_operation(spec, screen_of(header, options.seed));
    Frame frame(trace, *operation, config, options.threads, /*quads=*/false);
    QuadBatch batch;
    while (frame.advance(batch)) {
    }
    run.technique = spec.parameters;
    run.trace_hash = trace.hash();
    run.declaration = operation->declaration();
    run.counts = frame.fragments();
    for (int s = 0; s < frame.surfaces().surfaces(); ++s) run.surfaces.push_back(frame.surfaces().name(s));
    run.traffic = frame.traffic();
    take_maps(run, spec.name == kColored, frame.stores(), header);
    return run;
}

bool names_colored_map(const std::string& technique) {
    return technique.substr(0, technique.find(':')) == kColored;
}

}  // namespace ropsim
