#include "model/hierarchical_depth.h"

#include "rop/declaration.h"

#include <limits>

namespace ropsim {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Steps of a depth in [0, 1] that `bits` tell apart, rounded towards the eye or away from it.
float rounded_down(float z, std::uint32_t bits) {
    if (bits == 32) return z;
    const double steps = std::ldexp(1.0, static_cast<int>(bits)) - 1;
    const auto kept = static_cast<float>(std::floor(std::clamp(double{z}, 0.0, 1.0) * steps) / steps);
    return std::min(kept, z);
}
float rounded_up(float z, std::uint32_t bits) {
    if (bits == 32 || z > 1.0f) return z;  // the last step is the background behind everything
    const double steps = std::ldexp(1.0, static_cast<int>(bits)) - 1;
    const auto kept = static_cast<float>(std::ceil(std::clamp(double{z}, 0.0, 1.0) * steps) / steps);
    return std::max(kept, z);
}

}  // namespace

HierarchicalDepth::HierarchicalDepth(const TraceHeader& header, const HierarchicalDepthConfig& config,
                                     int scale)
    : across_(static_cast<std::size_t>(tiles_across(header.width))),
      sloped_(header.samples > 1 && header.depth_slopes) {
    const auto down = static_cast<std::size_t>(tiles_across(header.height));
    ranges_.assign(across_ * down, {-kInfinity, kInfinity});
    if (!config.enabled) return;
    const int width = low_resolution(header.width, scale);
    const int height = low_resolution(header.height, scale);
    const std::uint64_t tile_bits = std::uint64_t{config.bits} * (config.accepts ? 2 : 1);
    const std::uint64_t room =
        config.kibibytes == 0 ? ranges_.size() : std::uint64_t{config.kibibytes} * 8192 / tile_bits;
    const std::size_t kept = std::min<std::size_t>(room, ranges_.size());
    bytes_ = (kept * tile_bits + 7) / 8;
    for (std::size_t t = 0; t < kept; ++t) ranges_[t] = {kInfinity, -kInfinity};
    const auto samples = static_cast<std::size_t>(header.samples);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const std::size_t tile =
                static_cast<std::size_t>(y / kTileSize) * across_ + static_cast<std::size_t>(x / kTileSize);
            if (tile >= kept) continue;
            const std::size_t pixel =
                static_cast<std::size_t>(full_resolution(y, scale)) * static_cast<std::size_t>(header.width) +
                static_cast<std::size_t>(full_resolution(x, scale));
            Range& range = ranges_[tile];
            for (std::size_t m = 0; m < samples; ++m) {
                const float z = header.opaque->depth[pixel * samples + m];
                range.nearest = std::min(range.nearest, z);
                range.farthest = std::max(range.farthest, z);
            }
        }
    }
    for (std::size_t t = 0; t < kept; ++t) {
        Range& range = ranges_[t];
        range.nearest = config.accepts ? rounded_down(range.nearest, config.bits) : -kInfinity;
        range.farthest = rounded_up(range.farthest, config.bits);
    }
}

}  // namespace ropsim
