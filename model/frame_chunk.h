// A piece of the trace as a pass over the fragments takes it; private to Frame.
#pragma once

#include "model/frame.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace ropsim {

struct Frame::Chunk {
    FragmentChunk fragments;    // coverage cut down to what the opaque layer leaves to be seen
    std::uint64_t outside = 0;  // fragments dropped outside the region of interest
    // In a frame without quads: what is operated on, by index, partition after partition, and what was seen
    // on the way. Holds for every pass that takes the trace as it is.
    bool sorted = false;
    std::vector<std::uint32_t> operated;
    std::vector<std::uint32_t> first;  // of each partition, and the end
    FragmentCounts seen;
    DepthTests tests;

    FragmentSpan part(std::size_t at, std::size_t count) const {
        FragmentSpan span{{&fragments.fragments[at], count}};
        if (!fragments.slopes.empty()) span.slopes = {&fragments.slopes[at], count};
        if (!fragments.materials.empty()) span.materials = {&fragments.materials[at], count};
        return span;
    }
};

inline DepthSlope slope_of(const FragmentSpan& span, std::size_t i) {
    return span.slopes.empty() ? DepthSlope{} : span.slopes[i];
}

// Nothing would change if it were not drawn.
inline bool is_zero(const Fragment& f) {
    return f.a == 0.0f && f.r == 0.0f && f.g == 0.0f && f.b == 0.0f;
}

// Whether a fragment of a joined draw is exported with the one after it, because that is seen.
inline bool joins_seen(std::span<const Fragment> fragments, std::size_t i) {
    return i + 1 < fragments.size() && joins(fragments[i], fragments[i + 1]) &&
           fragments[i + 1].coverage != 0;
}

}  // namespace ropsim
