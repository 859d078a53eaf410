// What `ropsim trace info` says of a trace, as JSON.
#include "cli/trace_info.h"

#include <nlohmann/json.hpp>

namespace ropsim {

namespace {

using Json = nlohmann::ordered_json;

template <typename T>
Json or_null(const std::optional<T>& value) {
    return value ? Json(*value) : Json(nullptr);
}

Json depth_complexity_json(const DepthComplexity& depth) {
    return {{"mean", or_null(depth.mean)},
            {"max", depth.max},
            {"covered_pixels", depth.covered_pixels},
            {"histogram", depth.histogram}};
}

Json camera_json(const std::optional<Camera>& camera) {
    if (!camera) return nullptr;
    return {{"near_plane", camera->near_plane},
            {"far_plane", camera->far_plane},
            {"fovy_degrees", camera->fovy_degrees},
            {"metres_per_unit", camera->metres_per_unit}};
}

Json alpha_json(const TraceStatistics& statistics) {
    return {{"mean", or_null(statistics.alpha_mean)},
            {"histogram", statistics.alpha_histogram},
            {"zero", statistics.zero_alpha},
            {"one", statistics.full_alpha}};
}

// The channels that the trace has; null for those that it does not.
void add_channels(const TraceStatistics& statistics, Json& result) {
    result["depth_slopes"] = nullptr;
    result["materials"] = nullptr;
    result["non_finite"] = nullptr;
    if (statistics.slopes)
        result["depth_slopes"] = {{"sloped", statistics.slopes->sloped},
                                  {"steepest", statistics.slopes->steepest}};
    if (statistics.materials)
        result["materials"] = {{"transmissive", statistics.materials->transmissive},
                               {"scattering", statistics.materials->scattering},
                               {"refractive", statistics.materials->refractive}};
    if (statistics.unusual)
        result["non_finite"] = {{"with_nan", statistics.unusual->with_nan},
                                {"with_infinity", statistics.unusual->with_infinity},
                                {"out_of_range", statistics.unusual->out_of_range}};
}

}  // namespace

std::string trace_info_json(const TraceReader& reader, const TraceStatistics& statistics) {
    const TraceHeader& header = reader.header();
    const std::uint64_t fragments = reader.fragment_count();
    Json result{{"file", reader.path()},
                {"width", header.width},
                {"height", header.height},
                {"samples", header.samples},
                {"fragments", fragments},
                {"draws", header.draws.size()},
                {"depth_complexity", depth_complexity_json(statistics.all)},
                {"visible_depth_complexity", depth_complexity_json(statistics.visible)},
                {"hidden_by_opaque", statistics.hidden_by_opaque},
                {"facing_back", statistics.facing_back},
                {"alpha", alpha_json(statistics)},
                {"bytes", reader.file_bytes()},
                {"bytes_per_fragment", nullptr},
                {"hash", reader.hash()},
                {"scene", header.scene},
                {"view", header.view},
                {"color_storage", header.color_storage == ColorStorage::kFloat16 ? "float16" : "float32"},
                {"opaque_layer", header.opaque.has_value()},
                {"camera", camera_json(header.camera)},
                {"light", camera_json(header.light)},
                {"draw_list", Json::array()}};
    if (fragments != 0)
        result["bytes_per_fragment"] =
            static_cast<double>(reader.file_bytes()) / static_cast<double>(fragments);
    add_channels(statistics, result);
    for (std::size_t i = 0; i < header.draws.size(); ++i)
        result["draw_list"].push_back({{"name", header.draws[i].name},
                                       {"object_id", header.draws[i].object_id},
                                       {"fragments", statistics.draw_fragments[i]}});
    return result.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace ropsim
