// The timed side of a sample: each sampled partition with its memory channel and its share of the shader
// cores.
#pragma once

#include "memory/dram_statistics.h"
#include "model/stage_account.h"
#include "model/tile_sample_stream.h"

#include <array>
#include <memory>
#include <vector>

namespace ropsim {

// What a partition did during a stretch's measured quads.
struct TimedStretch {
    std::uint64_t cycles = 0;  // from the end of the last quad before them to their own end
    std::array<std::array<std::uint64_t, kStageLabels>, 2> labels{};  // tags, operations
    std::array<std::uint64_t, 3> rows{};                              // hits, misses, conflicts
};

struct SampledTiming {
    std::vector<std::vector<TimedStretch>>
        stretches;        // by stream; of a whole partition one, to its last cycle
    DramStatistics dram;  // of everything, what fills the pipelines included
};

// A partition alone with 1 / rop.partitions of the window, the lanes and the rates in front of it sees what
// it sees in the whole machine as long as the window is not filled by another partition's quads. Simulates
// every stream to its end; once a process.
SampledTiming run_sample_machine(const Frame& frame, const MachineConfig& config, const SamplePlan& plan,
                                 SampleFeeder& feeder,
                                 const std::vector<std::unique_ptr<SampleStream>>& streams);

}  // namespace ropsim
