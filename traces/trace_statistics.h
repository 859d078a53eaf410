// What a trace is like: depth complexity, alpha, channels, and what the opaque layer hides.
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

// Fragments whose values are not what techniques expect, as stored; a fragment may count in each.
struct UnusualFragments {
    std::uint64_t with_nan = 0;
    std::uint64_t with_infinity = 0;
    std::uint64_t out_of_range = 0;  // a finite depth, alpha, transmission or collimation outside [0, 1]
};

struct SlopeStatistics {
    std::uint64_t sloped = 0;  // fragments with a slope that is not 0
    float steepest = 0;        // largest |dx| or |dy|, depth a pixel
};

struct MaterialStatistics {
    std::uint64_t transmissive = 0;  // a transmission above 0
    std::uint64_t scattering = 0;    // a collimation below 1
    std::uint64_t refractive = 0;    // eta other than 1
};

struct TraceStatistics {
    std::uint64_t fragments = 0;
    DepthComplexity all;      // every fragment of the trace
    DepthComplexity visible;  // those with a covered sample in front of the opaque layer, or not depth-tested
    std::uint64_t hidden_by_opaque = 0;  // no covered sample is nearer than the opaque layer there
    std::optional<double> alpha_mean;
    std::array<std::uint64_t, 10> alpha_histogram{};  // tenths of [0, 1]; the last one includes 1
    std::uint64_t zero_alpha = 0;                     // alpha exactly 0
    std::uint64_t full_alpha = 0;                     // alpha exactly 1
    std::uint64_t facing_back = 0;                    // of triangles that turn their back to the eye
    std::vector<std::uint64_t> draw_fragments;        // by draw
    std::optional<UnusualFragments> unusual;          // where the header says non_finite
    std::optional<SlopeStatistics> slopes;            // where the trace has them
    std::optional<MaterialStatistics> materials;      // where the trace has them
};

// Fragments of each pixel, row-major.
struct PixelLayers {
    std::vector<std::uint32_t> all, visible;
};

// One pass over all fragments (rewinds first and afterwards), of values brought into range. Fills `layers`
// too where it is given. Memory: 8 bytes a pixel. Throws UserError on a damaged file.
TraceStatistics measure_trace(TraceReader& reader, PixelLayers* layers = nullptr);

}  // namespace ropsim
