// What a sample of the frame consists of: some ROP partitions with all their tiles, and of each partition's
// quads stretches of time that run through the timed machine.
#pragma once

#include "model/machine_config.h"
#include "model/surface_map.h"

#include <cstdint>
#include <vector>

namespace ropsim {

// Tiles share cache sets, a memory channel and its rows with the other tiles of their partition, and with no
// others: a partition is in the sample or out of it. Its quads are few enough to be run and to go through the
// caches without a clock all of them; what costs is the clock.
struct SamplePlan {
    std::vector<int> partitions;  // ascending
    double timed = 1;             // share of a sampled partition's quads that the timed machine gets
    std::uint64_t seed = 0;       // of where its stretches begin

    // Quads of a stretch, in order: those that fill the pipeline and the queues, those whose time counts, and
    // those that keep both filled meanwhile. With `timed` 1 there is one stretch, and all its time counts.
    static constexpr std::uint64_t kWarm = 384;
    static constexpr std::uint64_t kMeasured = 2048;
    static constexpr std::uint64_t kTail = 64;
    static constexpr std::uint64_t kStretch = kWarm + kMeasured + kTail;
    bool whole() const { return timed >= 1; }
    // First quad of a partition's stretch `number`: at random in the number-th equal part of its quads.
    std::uint64_t first_quad(int partition, std::uint64_t number) const;
};

// `percent` of the frame's fragments go through the timed machine, at least those of whole partitions where
// states live longer than a stretch can warm (an L2, compression) or there are few quads.
SamplePlan plan_sample(const SurfaceMap& map, const std::vector<std::uint64_t>& tile_fragments,
                       const MachineConfig& config, double percent, std::uint64_t seed);

// The front end of one partition out of many.
MachineConfig share_of(const MachineConfig& config);

}  // namespace ropsim
