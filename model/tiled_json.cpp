#include "model/tiled_json.h"

#include <nlohmann/json.hpp>

namespace ropsim {

nlohmann::ordered_json tiled_json(const RunResult& result) {
    using Json = nlohmann::ordered_json;
    const TiledReport& report = *result.tiled;
    const TilePlan& plan = report.plan;
    Json on_chip = Json::array();
    Json spilled = Json::object();
    std::uint64_t spilled_bytes = 0;
    for (std::size_t s = 0; s < plan.on_chip.size(); ++s) {
        if (plan.on_chip[s] != 0) on_chip.push_back(result.surfaces[s]);
        if (plan.on_chip[s] != 0 || s >= plan.pixel_bytes.size()) continue;
        spilled[result.surfaces[s]] = plan.pixel_bytes[s];
        spilled_bytes += plan.pixel_bytes[s];
    }
    return {{"tile_pixels", plan.side},
            {"tile_memory_bytes", plan.state_bytes},
            {"tile_memory_wanted_bytes", plan.wanted_bytes},
            {"on_chip", on_chip},
            {"spilled_bytes_per_pixel", spilled},  // of a list pool 0: its nodes are no pixel's
            {"spilled_surfaces", spilled.size()},
            {"spilled_bytes_per_pixel_total", spilled_bytes},
            {"passes_tile_by_tile", plan.tiled_passes},
            {"resolve_tile_by_tile", plan.tiled_resolve},
            {"tiles", report.tiles},
            {"primitives", report.primitives},
            {"bin_entries", report.bin_entries},
            {"bin_bytes", {{"written", report.bin_written}, {"read", report.bin_read}}},
            {"tile_bytes", {{"loaded", report.loaded}, {"stored", report.stored}}}};
}

}  // namespace ropsim
