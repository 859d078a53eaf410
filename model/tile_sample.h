// `--sample-tiles`: a frame's results from a sample of it, each with its confidence interval.
#pragma once

#include "model/estimate.h"
#include "model/frame.h"
#include "model/tile_sample_plan.h"
#include "traces/image.h"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace ropsim {

// "5%" or "5": greater than 0, at most 100. Throws UserError naming `where`.
double sample_percent(const std::string& text, const std::string& where);

struct TileSample {
    double percent = 0;
    std::uint64_t seed = 0;
    SamplePlan plan;
    double fragment_share = 0;       // of the trace's fragments that lie in the sampled partitions
    double timed_share = 0;          // and of its quads that the timed machine got
    std::uint64_t stretches = 0;     // of which it was measured how long they took
    bool function_complete = false;  // the function ran over all tiles: image, errors and counts are exact
    // By place in run.json ("/traffic/total/read_bytes").
    std::vector<std::pair<std::string, Estimate>> estimates;

    const Estimate* find(const std::string& place) const;
    Estimate cycles() const;
    Estimate pin_bytes() const;
};

enum class SampledFidelity : std::uint8_t { kCount, kCached, kTimed };

// Runs the frame, of which nothing has run yet. Timed at most once a process.
TileSample sample_frame(Frame& frame, const TraceReader& trace, const MachineConfig& config, double percent,
                        std::uint64_t seed, SampledFidelity fidelity);

// Adds the errors of the sampled tiles, expanded to all.
void estimate_error(const Frame& frame, const TraceReader& trace, const MachineConfig& config,
                    const Image& reference, const std::vector<std::uint8_t>& covered, TileSample& sample);

}  // namespace ropsim
