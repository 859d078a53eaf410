#include "model/tile_sample_plan.h"

#include "base/random.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ropsim {

namespace {
// A partition's quads are run and cached whatever part of them is timed: with this part the two cost alike.
constexpr double kTimedPart = 0.4;
constexpr double kNearlyAll = 0.8;  // more in stretches costs as much as everything
constexpr std::uint64_t kFewFragments = 40000;
}  // namespace

std::uint64_t SamplePlan::first_quad(int partition, std::uint64_t number) const {
    const double part = static_cast<double>(kStretch) / timed;
    const auto key = mix64(seed ^ mix64(static_cast<std::uint64_t>(partition) + 1));
    const double within = random_unit(key ^ mix64(number), 0) * (part - static_cast<double>(kStretch));
    return static_cast<std::uint64_t>(static_cast<double>(number) * part + within);
}

SamplePlan plan_sample(const SurfaceMap& map, const std::vector<std::uint64_t>& tile_fragments,
                       const MachineConfig& config, double percent, std::uint64_t seed) {
    SamplePlan plan;
    plan.seed = mix64(seed ^ mix64(0x53414D504C45ull));  // unrelated to the technique's draws
    const int all = map.partitions();
    const double share = percent / 100 * all;
    const int count = std::clamp(static_cast<int>(std::lround(share / kTimedPart)), 1, all);
    std::vector<int> order(static_cast<std::size_t>(all));
    std::iota(order.begin(), order.end(), 0);
    std::ranges::sort(order, {},
                      [&](int p) { return mix64(plan.seed + static_cast<std::uint64_t>(p) * 0x9E37ull); });
    plan.partitions.assign(order.begin(), order.begin() + count);
    std::ranges::sort(plan.partitions);
    plan.timed = std::min(1.0, share / count);
    const std::uint64_t fragments =
        std::accumulate(tile_fragments.begin(), tile_fragments.end(), std::uint64_t{0});
    if (plan.timed > kNearlyAll || config.l2.present() || config.compression.any() ||
        config.compression.metadata.size_bytes != 0 ||
        fragments / static_cast<std::uint64_t>(all) < kFewFragments)
        plan.timed = 1;
    return plan;
}

MachineConfig share_of(const MachineConfig& config) {
    MachineConfig share = config;
    const std::uint32_t n = config.partitions;
    const auto part = [n](std::uint32_t value) { return std::max(1u, (value + n / 2) / n); };
    share.shader_alu_lanes = part(config.shader_alu_lanes);
    share.shader_quads_in_flight = part(config.shader_quads_in_flight);
    share.raster_quads_per_cycle = part(config.raster_quads_per_cycle);
    share.export_quads_per_cycle = part(config.export_quads_per_cycle);
    share.front.raster_tiles_per_cycle = part(config.front.raster_tiles_per_cycle);
    share.front.shader.cores = part(config.front.shader.cores);
    return share;
}

}  // namespace ropsim
