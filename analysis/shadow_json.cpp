// What `ropsim shadow` measured as JSON; the keys are explained in docs/shadow-maps.md.
#include "analysis/shadow_json_parts.h"
#include "base/version.h"

namespace ropsim {

using Json = nlohmann::ordered_json;

Json shadow_parameters_json(const Parameters& parameters) {
    Json json = Json::object();
    for (const auto& [key, resolved] : parameters.resolved()) json[key] = resolved.value;
    return json;
}

Json number_or_null(bool measured, double value) {
    return measured ? Json(value) : Json(nullptr);
}

Json shadow_error_json(const VisibilityError& error) {
    const bool measured = error.count > 0;
    return {{"mean", number_or_null(measured, error.mean())},
            {"rmse", number_or_null(measured, error.rmse())},
            {"max", number_or_null(measured, error.max)}};
}

namespace {

Json map_json(const ShadowMapRun& run) {
    Json traffic = Json::object();
    SurfaceTraffic total;
    const auto entry = [](const SurfaceTraffic& t) {
        return Json{{"worst_case_read_bytes", t.worst_read},
                    {"worst_case_write_bytes", t.worst_write},
                    {"read_bytes", t.read},
                    {"write_bytes", t.write}};
    };
    for (std::size_t s = 0; s < run.surfaces.size(); ++s) {
        const SurfaceTraffic& t = run.traffic[s];
        total.worst_read += t.worst_read;
        total.worst_write += t.worst_write;
        total.read += t.read;
        total.write += t.write;
        if (t.worst_read + t.worst_write + t.read + t.write != 0) traffic[run.surfaces[s]] = entry(t);
    }
    traffic["total"] = entry(total);
    return {{"width", run.any_map().width},
            {"height", run.any_map().height},
            {"samples", run.any_map().samples},
            {"storage_bits_per_texel", run.declaration.storage_bits_per_pixel()},
            {"passes", run.declaration.passes.size()},
            {"fragments",
             {{"input", run.counts.input},
              {"depth_culled", run.counts.depth_culled},
              {"operated", run.counts.operated}}},
            {"traffic", std::move(traffic)}};
}

Json lookups_json(const ShadowLookups& lookups, const ShadowMapRun& run) {
    const bool measured = lookups.noise.count > 0;
    const double mean = measured ? lookups.exact_sum / static_cast<double>(lookups.noise.count) : 0;
    return {{"count", lookups.count},
            {"outside", lookups.outside},
            {"texels_read", lookups.texels},
            {"samples_read", lookups.samples},
            {"bytes_read", lookups.samples * run.sample_bytes + lookups.total_alphas * run.total_alpha_bytes +
                               lookups.opaque_depths * run.opaque_bytes},
            {"mean_exact_visibility", number_or_null(measured, mean)},
            {"error", shadow_error_json(lookups.noise)},
            {"error_with_blur", shadow_error_json(lookups.all)}};
}

}  // namespace

std::string shadow_json(const ShadowStudy& study) {
    const ShadowStudyOptions& options = study.options;
    const ShadowFilter& filter = options.receiving.filter;
    Json json;
    json["ropsim"] = kVersion;
    json["technique"] = options.map.technique;
    json["technique_parameters"] = shadow_parameters_json(study.run.technique);
    json["light_trace"] = {{"file", options.map.trace}, {"hash", study.run.trace_hash}};
    json["camera_trace"] = {{"file", options.camera_trace}, {"hash", study.camera_hash}};
    json["hardware"] = options.map.hardware;
    json["hardware_parameters"] = shadow_parameters_json(study.run.hardware);
    json["seed"] = options.map.seed;
    if (study.colored) {
        json["ambient"] = options.receiving.ambient;
        json["map"] = map_json(study.run);
        add_colored_json(json, study);
    } else {
        json["filter"] = {{"side", filter.side},
                          {"taps", filter.taps > 0 ? Json(filter.taps) : Json(nullptr)},
                          {"bias", filter.bias},
                          {"slope_bias", filter.slope_bias}};
        if (filter.shape != FilterShape::kSquare) json["filter"]["shape"] = options.filter.name;
        json["ambient"] = options.receiving.ambient;
        json["map"] = map_json(study.run);
        json["fragments"] = lookups_json(study.shadowed.fragments, study.run);
        json["opaque"] = lookups_json(study.shadowed.opaque, study.run);
    }
    json["host"] = {{"seconds", study.host_seconds}};
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace ropsim
