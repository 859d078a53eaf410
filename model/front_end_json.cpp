#include "model/front_end_json.h"

#include <nlohmann/json.hpp>

namespace ropsim {

using Json = nlohmann::ordered_json;

namespace {

Json reads_json(const RopCacheStatistics& cache) {
    return {{"hits", cache.sector_hits}, {"misses", cache.sector_misses}, {"merges", cache.sector_merges}};
}

Json share(std::uint64_t part, std::uint64_t whole) {
    return whole == 0 ? Json(nullptr) : Json(static_cast<double>(part) / static_cast<double>(whole));
}

}  // namespace

Json front_end_json(const RunResult& result) {
    if (!result.machine) return nullptr;
    const FrontEndCounts& c = result.machine->front_end;
    Json json;
    json["quads"] = c.quads;
    json["primitive_tiles"] = c.tiles;
    json["hierarchical_depth"] = {{"rejected_quads", c.rejected},
                                  {"accepted_quads", c.accepted},
                                  {"tested_quads", c.tested},
                                  {"untested_quads", c.untested},
                                  {"saved_read_bytes", c.depth_bytes_saved},
                                  {"on_chip_bytes", c.hierarchical_depth_bytes}};
    json["early_depth"] = {{"culled_quads", c.early_culled}, {"cache_sectors", reads_json(c.depth_cache)}};
    json["warps"] = c.warps;
    json["shaded_quads"] = c.shaded_quads;
    json["lanes"] = {{"covered", c.covered_lanes}, {"helper", c.helper_lanes()}, {"empty", c.empty_lanes()}};
    json["quad_occupancy"] = share(c.covered_lanes, 4 * c.shaded_quads);
    json["warp_occupancy"] = share(c.shaded_quads, c.warp_quad_places);
    json["textures"] = {{"quad_fetches", c.quad_fetches}, {"cache_sectors", reads_json(c.texture_cache)}};
    return json;
}

}  // namespace ropsim
