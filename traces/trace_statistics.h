// What a trace is like: depth complexity, alpha, and what the opaque layer hides.
#pragma once

#include "traces/trace.h"

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace ropsim {

// Fragments a pixel.
struct DepthComplexity {
    std::uint64_t covered_pixels = 0;  // with at least one fragment
    std::optional<double> mean;        // over covered pixels; none where no pixel is covered
    std::uint64_t max = 0;
    std::vector<std::uint64_t> histogram;  // [k]: pixels with k fragments; size max + 1, sum width * height
};

struct TraceStatistics {
    std::uint64_t fragments = 0;
    DepthComplexity all;      // every fragment of the trace
    DepthComplexity visible;  // those in front of the opaque layer (z < its depth) or not depth-tested
    std::uint64_t hidden_by_opaque = 0;
    std::optional<double> alpha_mean;
    std::array<std::uint64_t, 10> alpha_histogram{};  // tenths of [0, 1]; the last one includes 1
    std::uint64_t zero_alpha = 0;                     // alpha exactly 0
    std::uint64_t full_alpha = 0;                     // alpha exactly 1
    std::vector<std::uint64_t> draw_fragments;        // by draw
};

// One pass over all fragments (rewinds first and afterwards). Memory: 8 bytes a pixel. Throws UserError on a
// damaged file.
TraceStatistics measure_trace(TraceReader& reader);

}  // namespace ropsim
