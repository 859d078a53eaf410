#include "model/skip_json.h"

#include "base/error.h"

#include <algorithm>

#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace ropsim {

namespace {

using Json = nlohmann::ordered_json;

bool ends_early(const TechniqueInfo& technique) {
    return technique.keys.find("early_termination") != std::string_view::npos;
}

// Operations that found every stored sample of their pixel in front of the fragment.
Json saturated_operations(const RunResult& r) {
    std::uint64_t sum = 0;
    bool known = false;
    for (const OperationCount& operation : r.operations) {
        if (!operation.cost.name.starts_with("saturated_")) continue;
        sum += operation.count;
        known = true;
    }
    return known ? Json(sum) : Json(nullptr);
}

}  // namespace

nlohmann::ordered_json skipped_json(const RunResult& r) {
    const SkipCounts& s = r.skipped;
    return {{"untouched_tiles", {{"initialised", s.initialise_tiles}, {"resolved", s.resolve_tiles}}},
            {"untouched_bytes", {{"initialised", s.initialise_bytes}, {"resolved", s.resolve_bytes}}},
            {"zero_alpha_fragments", s.zero_alpha_fragments},
            {"occluded_fragments", s.occluded_fragments},
            {"occluded_shader_lane_cycles", r.machine ? Json(s.occluded_lane_cycles) : Json(nullptr)},
            {"outside_region_fragments", s.outside_fragments},
            {"saturated_operations", saturated_operations(r)}};
}

void end_saturated_pixels(TechniqueSpec& technique) {
    std::vector<std::string_view> names;
    for (const TechniqueInfo& info : technique_list()) {
        if (!ends_early(info)) continue;
        if (info.name == technique.name)
            return technique.parameters.set("early_termination", "true", "skip.saturated");
        names.push_back(info.name);
    }
    throw UserError("skip.saturated", fmt::format("'{}' keeps nothing by which a pixel could be known to be "
                                                  "saturated; choose one of {}, or leave the key out",
                                                  technique.name, fmt::join(names, ", ")));
}

}  // namespace ropsim
