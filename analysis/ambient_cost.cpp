#include "analysis/ambient_cost.h"

namespace ropsim {

namespace {

ShaderCost cost_of(std::uint32_t taps, std::uint32_t tap_operations, std::uint32_t other_operations,
                   std::uint32_t ambient_bytes) {
    return {taps * tap_operations + other_operations, 2 * taps, taps * (kDepthBytes + ambient_bytes)};
}

}  // namespace

ShaderCost line_cost(const InferenceSettings& settings, std::uint32_t ambient_bytes) {
    using Operations = ListingOperations;
    return cost_of(static_cast<std::uint32_t>(settings.line_taps), Operations::kLineTap,
                   Operations::kDecision + Operations::kDirection + Operations::kQuotient, ambient_bytes);
}

ShaderCost box_cost(const InferenceSettings& settings, std::uint32_t ambient_bytes) {
    using Operations = ListingOperations;
    return cost_of(static_cast<std::uint32_t>(settings.box_taps()), Operations::kBoxTap,
                   Operations::kDecision + Operations::kQuotient, ambient_bytes);
}

ShaderCost solid_cost(std::uint32_t ambient_bytes) {
    return {0, 1, ambient_bytes};
}

}  // namespace ropsim
