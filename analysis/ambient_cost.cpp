#include "analysis/ambient_cost.h"

namespace ropsim {

namespace {

ShaderCost cost_of(int taps, std::uint32_t other_operations, std::uint32_t ambient_bytes) {
    const auto count = static_cast<std::uint32_t>(taps);
    return {count * ListingOperations::kTap + other_operations, 2 * count,
            count * (kDepthBytes + ambient_bytes)};
}

}  // namespace

ShaderCost line_cost(const InferenceSettings& settings, std::uint32_t ambient_bytes) {
    return cost_of(settings.line_taps, ListingOperations::kLine, ambient_bytes);
}

ShaderCost box_cost(const InferenceSettings& settings, std::uint32_t ambient_bytes) {
    return cost_of(settings.box_taps(), ListingOperations::kBox, ambient_bytes);
}

ShaderCost divergent_cost(const InferenceSettings& settings, std::uint32_t ambient_bytes) {
    return cost_of(settings.line_taps + settings.box_taps(), ListingOperations::kBoth, ambient_bytes);
}

ShaderCost solid_cost(std::uint32_t ambient_bytes) {
    return {0, 1, ambient_bytes};
}

}  // namespace ropsim
