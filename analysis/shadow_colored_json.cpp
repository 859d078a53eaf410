// What `ropsim shadow` measured of a coloured map as JSON; the keys are explained in docs/colored-shadows.md.
#include "analysis/shadow_json_parts.h"
#include "rop/shadow/filter_cost.h"

#include <array>
#include <cmath>

namespace ropsim {

namespace {

using Json = nlohmann::ordered_json;

std::string wavelength_name(std::size_t w, std::size_t wavelengths) {
    return wavelengths == 1 ? "all" : std::array{"red", "green", "blue"}[w];
}

MapShape shape_of(const ShadowMapRun& run) {
    const StoredShadowMap& map = run.any_map();
    return {static_cast<std::uint64_t>(map.width), static_cast<std::uint64_t>(map.height),
            static_cast<std::uint64_t>(map.samples), run.wavelengths.size(), run.sample_bytes};
}

Json wavelength_json(const WavelengthErrors& errors, const ShadowStudy& study) {
    const std::uint64_t count = errors.filter.count;
    const bool measured = count > 0;
    const auto over_count = [&](double sum) { return measured ? sum / static_cast<double>(count) : 0.0; };
    Json json = {{"mean_exact_visibility", number_or_null(measured, over_count(errors.exact_sum))},
                 {"error", shadow_error_json(errors.filter)}};
    if (study.options.filter.variance)
        json["noise"] = shadow_error_json(errors.noise);
    else if (study.options.receiving.filter.taps == 0)
        json["expected_noise_rmse"] =
            number_or_null(measured, std::sqrt(over_count(errors.expected_variance_sum)));
    json["error_with_blur"] = shadow_error_json(errors.blur);
    if (study.run.colored.caustics.on)
        json["error_against_transmittance"] = shadow_error_json(errors.transmittance);
    return json;
}

// Numbers as numbers: of what is resolved as TOML, numbers and quoted words are JSON alike.
Json filter_json(const FilterChoice& filter, const ShadowFilter& closer) {
    Json json = {{"kind", filter.name}};
    for (const auto& [key, resolved] : filter.parameters.resolved()) json[key] = Json::parse(resolved.value);
    if (filter.name == "square") {
        json["side"] = closer.side;
        json["taps"] = closer.taps > 0 ? Json(closer.taps) : Json(nullptr);
    }
    json["bias"] = closer.bias;
    json["slope_bias"] = closer.slope_bias;
    return json;
}

// Texels and bytes are without caches: of every wavelength, and the opaque depth of every point inside.
Json lookups_json(const ColoredLookups& lookups, const ShadowStudy& study) {
    const std::size_t wavelengths = study.run.wavelengths.size();
    const std::uint64_t texels = lookups.texels * wavelengths;
    const bool variance = study.options.filter.variance;
    const std::uint64_t texel_bytes =
        variance ? std::uint64_t{DepthMoments::kBytes}
                 : study.run.sample_bytes * static_cast<std::uint64_t>(study.run.any_map().samples);
    const std::uint64_t opaque_depths = lookups.count - lookups.outside;
    Json json = {{"count", lookups.count},
                 {"outside", lookups.outside},
                 {"in_opaque_shadow", lookups.in_shadow},
                 {"fetches", variance ? lookups.looked_up() * wavelengths : texels},
                 {"texels_read", texels},
                 {"bytes_read", texels * texel_bytes},
                 {"opaque_bytes_read", opaque_depths * study.run.opaque_bytes}};
    for (std::size_t w = 0; w < wavelengths; ++w)
        json["wavelengths"][wavelength_name(w, wavelengths)] = wavelength_json(lookups.wavelengths[w], study);
    return json;
}

Json stage_json(const StageNoise& noise) {
    return {{"measured", noise.measured}, {"expected", noise.expected}};
}

Json conversion_json(const ShadowStudy& study) {
    const VarianceOptions& options = study.options.filter.conversion;
    const ColoredStudy& colored = *study.colored;
    Json json = {
        {"width", colored.reduced_width},
        {"height", colored.reduced_height},
        {"storage_bits_per_texel", std::size_t{8} * DepthMoments::kBytes * study.run.wavelengths.size()}};
    for (const ConversionPass& pass : conversion_passes(shape_of(study.run), options))
        json["passes"].push_back({{"name", pass.name},
                                  {"output_texels", pass.output_texels},
                                  {"fetches", pass.fetches},
                                  {"read_bytes", pass.read_bytes},
                                  {"distinct_read_bytes", pass.distinct_bytes},
                                  {"write_bytes", pass.write_bytes}});
    for (std::size_t w = 0; w < colored.noise.size(); ++w) {
        const MapNoise& noise = colored.noise[w];
        json["variance_of_mean_depth"][wavelength_name(w, colored.noise.size())] = {
            {"stored", stage_json(noise.stored)},
            {"filtered", stage_json(noise.filtered)},
            {"reduced", stage_json(noise.reduced)}};
    }
    return json;
}

// The same look-ups by as many fetches of the unconverted map as the tent's disc has texels.
Json saving_json(const ShadowStudy& study) {
    const MapShape map = shape_of(study.run);
    const VarianceOptions& options = study.options.filter.conversion;
    const ColoredShadowedTrace& shadowed = study.colored->shadowed;
    const std::uint64_t lookups = shadowed.fragments.looked_up() + shadowed.opaque.looked_up();
    const auto whole = [](double bytes) { return static_cast<std::uint64_t>(bytes); };
    const int fetches = disc_texels(options.tent);
    const auto both = [&](bool cached) {
        const FilterSaving saving =
            filter_saving(map, options, static_cast<double>(lookups), fetches, cached, false);
        return Json{{"conversion_bytes", whole(saving.conversion_bytes)},
                    {"ratio", number_or_null(lookups > 0, saving.ratio())}};
    };
    const FilterSaving saving =
        filter_saving(map, options, static_cast<double>(lookups), fetches, true, false);
    return {{"lookups", lookups},
            {"direct_fetches_a_lookup", fetches},
            {"direct_bytes", whole(saving.direct_bytes)},
            {"lookup_bytes", whole(saving.lookup_bytes)},
            {"conversion_cached", both(true)},
            {"conversion_uncached", both(false)}};
}

}  // namespace

void add_colored_json(Json& json, const ShadowStudy& study) {
    const FilterChoice& filter = study.options.filter;
    json["filter"] = filter_json(filter, study.options.receiving.filter);
    if (filter.variance) {
        json["conversion"] = conversion_json(study);
        json["saving"] = saving_json(study);
    }
    json["fragments"] = lookups_json(study.colored->shadowed.fragments, study);
    json["opaque"] = lookups_json(study.colored->shadowed.opaque, study);
}

}  // namespace ropsim
