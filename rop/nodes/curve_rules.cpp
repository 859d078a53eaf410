#include "rop/nodes/curve_rules.h"

#include "base/error.h"
#include "rop/nodes/vector_insertion.h"

#include <string>

namespace ropsim {

CurveRules CurveRules::read(Parameters& parameters, int nodes) {
    CurveRules rules;
    rules.nodes = nodes;
    const std::string removal =
        parameters.get_choice("removal", "underestimate", {"underestimate", "overestimate", "node_by_node"});
    if (removal == "overestimate") rules.removal = Removal::kOverestimate;
    if (removal == "node_by_node") rules.removal = Removal::kNodeByNode;
    const std::string candidates =
        parameters.get_choice("candidates", "paper", {"paper", "protect_furthest", "protect_front_half"});
    rules.last_removable = candidates == "paper" ? nodes : nodes - 1;
    if (candidates == "protect_front_half" && nodes >= 8)
        rules.first_underestimated = rules.first_overestimated = nodes / 2;
    rules.four_at_a_time = inserts_four_at_a_time(nodes) && candidates == "paper";
    const std::string coplanar =
        parameters.get_choice("equal_depth", "in_front", {"in_front", "behind", "merge"});
    if (coplanar == "behind") rules.coplanar = CoplanarRule::kBehind;
    if (coplanar == "merge") rules.coplanar = CoplanarRule::kMerge;
    return rules;
}

void CurveRules::read_formats(Parameters& parameters, const TechniqueFormats& formats) {
    depth = formats.of("depth", Format::kFloat32);
    transmittance = formats.of("transmittance", Format::kFloat32);
    empty_depth = stored_value(depth, kEmptyDepth);
    last_depth = empty_depth > 1.0f ? empty_depth : next_stored_below(depth, empty_depth);
    const std::string name =
        parameters.get_choice("transmittance_rounding", "nearest", {"nearest", "down", "dithered"});
    if (name == "nearest") return;
    if (transmittance == Format::kFloat32)
        throw UserError(parameters.where("transmittance_rounding"),
                        fmt::format("{} has nothing to round: float32 keeps transmittance as computed; add "
                                    "transmittance_format=unorm8 or another",
                                    name));
    rounding = name == "down" ? NodeRounding::kDown : NodeRounding::kDithered;
}

}  // namespace ropsim
