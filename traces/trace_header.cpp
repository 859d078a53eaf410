// The header section of a trace file: TraceHeader and the columns as JSON text, and its validation.
#include "traces/trace_header.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace ropsim {

namespace {

using nlohmann::json;

constexpr std::size_t kMaxDraws = 65536;  // a fragment names its draw in 16 bits

// JSON has no infinity, and far planes may lie there.
json real(float value) {
    if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
    return value;
}

float parse_float(const json& value) {
    if (value.is_string()) {
        if (value == "inf") return std::numeric_limits<float>::infinity();
        if (value == "-inf") return -std::numeric_limits<float>::infinity();
    }
    return static_cast<float>(value.get<double>());
}

// An integer of type T: the JSON library itself would let numbers out of range wrap.
template <typename T>
T parse_integer(const json& value) {
    if (!value.is_number_integer()) throw FormatFault("needs an integer where something else stands");
    const auto number = value.get<std::int64_t>();
    if (number < std::numeric_limits<T>::min() || number > std::numeric_limits<T>::max())
        throw FormatFault(fmt::format("holds {}, which is out of range", value.dump()));
    return static_cast<T>(number);
}

json matrix(const glm::mat4& m) {
    json result = json::array();
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) result.push_back(real(m[column][row]));
    return result;
}

glm::mat4 parse_matrix(const json& values) {
    if (!values.is_array() || values.size() != 16) throw FormatFault("a matrix needs 16 numbers");
    glm::mat4 result;
    for (int i = 0; i < 16; ++i) result[i / 4][i % 4] = parse_float(values[static_cast<std::size_t>(i)]);
    return result;
}

constexpr std::array<const char*, 3> kBlendNames{"over", "additive", "multiply"};
constexpr std::array<const char*, 3> kCullNames{"none", "back", "front"};

template <typename Enum>
Enum parse_name(const json& value, const std::array<const char*, 3>& names) {
    const std::string text = value;
    const auto found = std::find(names.begin(), names.end(), text);
    if (found == names.end()) throw FormatFault(fmt::format("holds '{}', which is unknown", text));
    return static_cast<Enum>(found - names.begin());
}

json cost_json(const ShaderCost& cost) {
    return {{"alu_instructions", cost.alu_instructions},
            {"texture_fetches", cost.texture_fetches},
            {"texture_bytes", cost.texture_bytes}};
}

ShaderCost parse_cost(const json& value) {
    return {parse_integer<std::uint32_t>(value.at("alu_instructions")),
            parse_integer<std::uint32_t>(value.at("texture_fetches")),
            parse_integer<std::uint32_t>(value.at("texture_bytes"))};
}

json draw_json(const Draw& draw) {
    return {{"name", draw.name},
            {"object_id", draw.object_id},
            {"depth_test", draw.depth_test},
            {"depth_write", draw.depth_write},
            {"blend", kBlendNames[static_cast<std::size_t>(draw.blend)]},
            {"cull", kCullNames[static_cast<std::size_t>(draw.cull)]},
            {"full_cost", cost_json(draw.full)},
            {"alpha_cost", cost_json(draw.alpha)},
            {"cost_source", draw.cost_source}};
}

Draw parse_draw(const json& value) {
    Draw draw;
    draw.name = value.at("name");
    draw.object_id = parse_integer<std::uint32_t>(value.at("object_id"));
    draw.depth_test = value.at("depth_test");
    draw.depth_write = value.at("depth_write");
    draw.blend = parse_name<BlendMode>(value.at("blend"), kBlendNames);
    draw.cull = parse_name<CullMode>(value.at("cull"), kCullNames);
    draw.full = parse_cost(value.at("full_cost"));
    draw.alpha = parse_cost(value.at("alpha_cost"));
    draw.cost_source = value.at("cost_source");
    return draw;
}

json camera_json(const Camera& camera) {
    return {{"view", matrix(camera.view)},
            {"projection", matrix(camera.projection)},
            {"near_plane", real(camera.near_plane)},
            {"far_plane", real(camera.far_plane)},
            {"fovy_degrees", real(camera.fovy_degrees)},
            {"metres_per_unit", real(camera.metres_per_unit)}};
}

Camera parse_camera(const json& value) {
    Camera camera;
    camera.view = parse_matrix(value.at("view"));
    camera.projection = parse_matrix(value.at("projection"));
    camera.near_plane = parse_float(value.at("near_plane"));
    camera.far_plane = parse_float(value.at("far_plane"));
    camera.fovy_degrees = parse_float(value.at("fovy_degrees"));
    camera.metres_per_unit = parse_float(value.at("metres_per_unit"));
    return camera;
}

json content_json(const TraceHeader& header) {
    json result{
        {"width", header.width},
        {"height", header.height},
        {"samples", header.samples},
        {"background", {real(header.background.r), real(header.background.g), real(header.background.b)}},
        {"scene", header.scene},
        {"view", header.view},
        {"depth_slopes", header.depth_slopes},
        {"materials", header.materials},
        {"non_finite", header.non_finite},
        {"draws", json::array()}};
    if (header.camera) result["camera"] = camera_json(*header.camera);
    if (header.light) result["light"] = camera_json(*header.light);
    for (const Draw& draw : header.draws) result["draws"].push_back(draw_json(draw));
    return result;
}

std::string text_of(const json& value) {
    return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

StoredHeader from_json(const json& value) {
    StoredHeader stored;
    TraceHeader& header = stored.header;
    header.width = parse_integer<int>(value.at("width"));
    header.height = parse_integer<int>(value.at("height"));
    header.samples = parse_integer<int>(value.at("samples"));
    const json& background = value.at("background");
    if (!background.is_array() || background.size() != 3) throw FormatFault("the background needs 3 numbers");
    for (int c = 0; c < 3; ++c) header.background[c] = parse_float(background[static_cast<std::size_t>(c)]);
    header.scene = value.at("scene");
    header.view = value.at("view");
    header.depth_slopes = value.at("depth_slopes");
    header.materials = value.at("materials");
    header.non_finite = value.at("non_finite");
    if (value.contains("camera")) header.camera = parse_camera(value.at("camera"));
    if (value.contains("light")) header.light = parse_camera(value.at("light"));
    if (value.at("draws").size() > kMaxDraws) throw FormatFault("names too many draws");
    for (const json& draw : value.at("draws")) header.draws.push_back(parse_draw(draw));
    const std::string color = value.at("color_storage");
    if (color != "float32" && color != "float16")
        throw FormatFault(fmt::format("stores colour as '{}', which this version does not know", color));
    header.color_storage = color == "float16" ? ColorStorage::kFloat16 : ColorStorage::kFloat32;
    stored.region_side = parse_integer<int>(value.at("region_side"));
    for (const json& column : value.at("columns"))
        stored.columns.push_back({column.at("name"), column.at("type"), column.at("required")});
    return stored;
}

bool holds_nan(const Camera& camera) {
    bool found = std::isnan(camera.near_plane) || std::isnan(camera.far_plane) ||
                 std::isnan(camera.fovy_degrees) || std::isnan(camera.metres_per_unit);
    for (int i = 0; i < 16; ++i)
        found = found || std::isnan(camera.view[i / 4][i % 4]) || std::isnan(camera.projection[i / 4][i % 4]);
    return found;
}

std::string opaque_fault(const TraceHeader& header) {
    const OpaqueLayer& opaque = *header.opaque;
    const std::size_t pixels = static_cast<std::size_t>(header.width) *
                               static_cast<std::size_t>(header.height) *
                               static_cast<std::size_t>(header.samples);
    if (opaque.rgb.size() != 3 * pixels || opaque.depth.size() != pixels)
        return fmt::format("the opaque layer needs {} colour values and {} depths, not {} and {}", 3 * pixels,
                           pixels, opaque.rgb.size(), opaque.depth.size());
    for (const float value : opaque.rgb)
        if (!std::isfinite(value)) return "the opaque layer holds a colour that is not finite";
    for (const float depth : opaque.depth)
        if (!(depth >= 0 && depth <= 1) && !(std::isinf(depth) && depth > 0))
            return fmt::format("the opaque layer holds depth {}; it must be from 0 to 1, or +infinity",
                               depth);
    return {};
}

}  // namespace

std::string header_fault(const TraceHeader& header) {
    if (header.width < 1 || header.width > kMaxImageSide || header.height < 1 ||
        header.height > kMaxImageSide)
        return fmt::format("size {}x{}: each side must be from 1 to {}", header.width, header.height,
                           kMaxImageSide);
    if (header.samples != 1 && header.samples != 2 && header.samples != 4 && header.samples != 8 &&
        header.samples != 16)
        return fmt::format("samples {}: must be 1, 2, 4, 8 or 16", header.samples);
    if (header.draws.size() > kMaxDraws)
        return fmt::format("{} draws: a trace holds up to {}", header.draws.size(), kMaxDraws);
    for (int c = 0; c < 3; ++c)
        if (!std::isfinite(header.background[c])) return "the background colour must be finite";
    if (header.non_finite && header.color_storage != ColorStorage::kFloat32)
        return "values that are not finite need colours stored as float32";
    if (header.view != "camera" && header.view != "light")
        return fmt::format("view '{}': must be camera or light", header.view);
    if (header.camera && holds_nan(*header.camera)) return "the camera holds a value that is no number";
    if (header.light && holds_nan(*header.light)) return "the light holds a value that is no number";
    return header.opaque ? opaque_fault(header) : std::string{};
}

std::string header_text(const TraceHeader& header, int region_side) {
    json value = content_json(header);
    value["color_storage"] = header.color_storage == ColorStorage::kFloat16 ? "float16" : "float32";
    value["region_side"] = region_side;
    value["columns"] = json::array();
    for (const ColumnDescription& column : written_columns(header))
        value["columns"].push_back(
            {{"name", column.name}, {"type", column.type}, {"required", column.required}});
    return text_of(value);
}

std::string header_content_text(const TraceHeader& header) {
    return text_of(content_json(header));
}

StoredHeader parse_header(const std::string& text) {
    StoredHeader stored;
    try {
        stored = from_json(json::parse(text));
    } catch (const json::exception& error) {
        throw FormatFault(fmt::format("cannot be understood ({})", error.what()));
    }
    if (const std::string fault = header_fault(stored.header); !fault.empty()) throw FormatFault(fault);
    if (stored.region_side < kTileSize || stored.region_side > kMaxRegionSide ||
        stored.region_side % kTileSize != 0)
        throw FormatFault(
            fmt::format("region_side {}: must be a multiple of 8 from 8 to 256", stored.region_side));
    return stored;
}

}  // namespace ropsim
