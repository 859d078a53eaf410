// What `ropsim ambient` measured as JSON; the keys are explained in docs/ambient-occlusion.md.
#include "analysis/ambient_cost.h"
#include "analysis/ambient_study.h"
#include "base/version.h"

#include <array>
#include <optional>

#include <nlohmann/json.hpp>

namespace ropsim {

namespace {

using Json = nlohmann::ordered_json;

Json mean_or_null(double sum, std::uint64_t count) {
    return count == 0 ? Json(nullptr) : Json(sum / static_cast<double>(count));
}

Json counts_json(const AmbientCounts& counts, bool infer) {
    return {
        {"input", counts.fragments},
        {"hidden", counts.hidden},
        {"other", counts.other},
        {"solid", counts.solid},
        {"line", counts.line},
        {"box", counts.box},
        {"mean_solid_ao", mean_or_null(counts.solid_ambient, counts.solid)},
        {"mean_edge_ao", infer ? mean_or_null(counts.inferred_ambient, counts.inferred()) : Json(nullptr)}};
}

Json settings_json(const AmbientOptions& options) {
    static constexpr std::array kHelpers = {"twin", "zero", "own"};
    const ObscuranceSettings& obscurance = options.obscurance;
    const InferenceSettings& inference = options.inference;
    return {{"solid", options.solid},
            {"solid_alpha", options.solid_alpha},
            {"helpers", kHelpers.at(static_cast<std::size_t>(options.helpers))},
            {"infer", options.infer},
            {"ambient", options.share},
            {"radius", obscurance.radius},
            {"bias", obscurance.bias},
            {"intensity", obscurance.intensity},
            {"taps", obscurance.taps},
            {"format", format_info(obscurance.format).name},
            {"blur", options.blur},
            {"line_taps", inference.line_taps},
            {"line_stride", inference.line_stride},
            {"box_radius", inference.box_radius},
            {"box_stride", inference.box_stride},
            {"box_shift", inference.checkerboard ? "checkerboard" : "printed"},
            {"half_weight", inference.half_weight},
            {"floor", inference.floor},
            {"least_gradient", inference.least_gradient}};
}

Json cost_json(const ShaderCost& cost) {
    return {{"alu_instructions", cost.alu_instructions},
            {"texture_fetches", cost.texture_fetches},
            {"texture_bytes", cost.texture_bytes}};
}

Json buffer_json(const AmbientStudy& study) {
    const Obscurance& buffer = study.obscurance;
    const std::uint64_t bytes = ambient_bytes(study.options.obscurance.format);
    const auto texels = static_cast<std::uint64_t>(buffer.ambient.size());
    return {{"pixels", buffer.pixels},
            {"texture_fetches", buffer.fetches},
            {"read_bytes", buffer.fetches * kDepthBytes},
            {"distinct_read_bytes", texels * kDepthBytes},
            {"write_bytes", texels * bytes},
            {"blur_texture_fetches", 2 * study.blur_taps},
            {"blur_read_bytes", study.blur_taps * (kDepthBytes + bytes)},
            {"blur_write_bytes", study.options.blur == 0 ? 0 : 2 * texels * bytes},
            {"opaque_pixels", study.opaque_pixels},
            {"mean_opaque_ao", mean_or_null(study.opaque_ambient, study.opaque_pixels)}};
}

Json inference_json(const AmbientStudy& study, const AmbientCounts& total) {
    if (!study.options.infer) return nullptr;
    const std::uint32_t bytes = ambient_bytes(study.options.obscurance.format);
    const InferenceCounts& counts = study.inference;
    const ShaderCost line = line_cost(study.options.inference, bytes);
    const ShaderCost box = box_cost(study.options.inference, bytes);
    return {{"line", cost_json(line)},
            {"box", cost_json(box)},
            {"divergent", cost_json(divergent_cost(study.options.inference, bytes))},
            {"taps", counts.taps},
            {"texture_fetches", 2 * counts.taps},
            {"read_bytes", counts.taps * (kDepthBytes + bytes)},
            {"distinct_read_bytes", counts.texels * (kDepthBytes + bytes)},
            {"alu_instructions", total.line * line.alu_instructions + total.box * box.alu_instructions},
            {"helper_lanes",
             {{"own", counts.lanes_own}, {"twin", counts.lanes_twin}, {"absent", counts.lanes_absent}}},
            {"faint", counts.faint},
            {"unmatched", counts.unmatched}};
}

Json edges_json(const EdgeStep& edges, bool infer) {
    const auto value = [](bool measured, std::optional<double> number) {
        return measured && number ? Json(*number) : Json(nullptr);
    };
    const bool any = edges.pairs > 0;
    return {{"pairs", edges.pairs},
            {"without", value(any, edges.without)},
            {"solid_only", value(any, edges.solid_only)},
            {"inferred", value(any && infer, edges.inferred)},
            {"ao_difference_solid_only", value(any, edges.difference_solid_only)},
            {"ao_difference_inferred", value(any && infer, edges.difference_inferred)}};
}

}  // namespace

std::string ambient_json(const AmbientStudy& study) {
    AmbientCounts total;
    Json draws = Json::array();
    const bool infer = study.options.infer;
    for (std::size_t d = 0; d < study.draws.size(); ++d) {
        total.add(study.draws[d]);
        Json draw = {{"name", study.draw_names[d]}};
        draw.update(counts_json(study.draws[d], infer));
        draw["shader"] = {{"before", cost_json(study.shaders_before[d])},
                          {"after", cost_json(study.shaders_after[d])}};
        draws.push_back(std::move(draw));
    }
    Json json;
    json["ropsim"] = kVersion;
    json["trace"] = {{"file", study.options.trace}, {"hash", study.trace_hash}};
    json["options"] = settings_json(study.options);
    json["fragments"] = counts_json(total, infer);
    json["draws"] = std::move(draws);
    json["buffer"] = buffer_json(study);
    json["inference"] = inference_json(study, total);
    json["edge_step"] = edges_json(study.edges, infer);
    json["host"] = {{"seconds", study.host_seconds}};
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace ropsim
