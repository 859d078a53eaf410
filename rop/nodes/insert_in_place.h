// Insertion into a visibility curve as a processor does it: nodes in front of the fragment and of the removed
// node stay where they are. The same values as inserted and Compressed, bit for bit (the conformance tests
// hold it to that), for rules that say is_plain().
#pragma once

#include "rop/nodes/curve_rules.h"
#include "rop/nodes/vector_insertion.h"
#include "rop/technique.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace ropsim {

// Nodes in a pixel's state. The fields are copies, so that stores to the pixel need not be assumed to change
// them.
struct PixelNodes {
    PlainPixel& pixel;
    Field depth_field;
    Field transmittance_field;

    std::uint32_t* depth_words() const { return pixel.element_words(depth_field, 0); }
    std::uint32_t* transmittance_words() const { return pixel.element_words(transmittance_field, 0); }
    void mark_written(int first, int count) const { pixel.write_from(depth_field, first, count); }
    float depth(int i) const { return pixel.load(depth_field, i); }
    float transmittance(int i) const { return pixel.load(transmittance_field, i); }
    void put(int i, float z, float v) {
        pixel.write(depth_field, i);
        pixel.put(depth_field, i, 0, z);
        pixel.put(transmittance_field, i, 0, v);
    }
};

// Nodes in registers.
struct ArrayNodes {
    float* depths;
    float* transmittances;

    float depth(int i) const { return depths[i]; }
    float transmittance(int i) const { return transmittances[i]; }
    void put(int i, float z, float v) {
        depths[i] = z;
        transmittances[i] = v;
    }
};

// Inserts a fragment at z with transmittance t. True where a node had to be removed.
template <class Nodes>
bool insert_one_by_one(Nodes nodes, const CurveRules& rules, float z_in, float t) {
    const int count = rules.nodes;
    std::array<float, kMaxNodes + 1> z;
    std::array<float, kMaxNodes + 1> v;
    float before = 1.0f;
    int at = 0;
    for (; at < count; ++at) {
        const auto k = static_cast<std::size_t>(at);
        z[k] = nodes.depth(at);
        if (!(z[k] < z_in)) break;
        v[k] = before = nodes.transmittance(at);
    }
    z[static_cast<std::size_t>(at)] = z_in;
    v[static_cast<std::size_t>(at)] = before * t;
    for (int i = at; i < count; ++i) {
        z[static_cast<std::size_t>(i) + 1] = nodes.depth(i);
        v[static_cast<std::size_t>(i) + 1] = nodes.transmittance(i) * t;
    }
    const bool full = z[static_cast<std::size_t>(count)] < rules.empty_depth;
    int removed = count;
    if (full) {
        const auto error = [&](int j) {
            const auto k = static_cast<std::size_t>(j);
            return (v[k - 1] - v[k]) * (z[k] - z[k - 1]);
        };
        removed = rules.first_underestimated;
        const int last = rules.last_removable;
        float least = error(removed);
        for (int j = removed + 1; j <= last; ++j) {
            const float e = error(j);
            removed = e < least ? j : removed;
            least = e < least ? e : least;
        }
        v[static_cast<std::size_t>(removed) - 1] = v[static_cast<std::size_t>(removed)];
    }
    for (int i = full ? std::min(at, removed - 1) : at; i < count; ++i) {
        const std::size_t from = static_cast<std::size_t>(i) + (i >= removed ? 1 : 0);
        nodes.put(i, z[from], v[from]);
    }
    return full;
}

// The same, by whichever way is the quickest.
inline bool insert_in_place(const PixelNodes& nodes, const CurveRules& rules, float z, float t) {
    if (rules.four_at_a_time) {
        const VectorInsertion done = insert_four_at_a_time(
            rules.nodes, nodes.depth_words(), nodes.transmittance_words(), z, t, rules.empty_depth);
        nodes.mark_written(done.first_changed, rules.nodes);
        return done.compressed;
    }
    return insert_one_by_one(nodes, rules, z, t);
}

// Transmittance of the last node strictly in front of z, 1 where there is none.
inline float transmittance_in_front(const PixelNodes& nodes, int count, float z) {
    int nearer = 0;
    if (inserts_four_at_a_time(count))
        nearer = count_in_front(count, nodes.depth_words(), z);
    else
        while (nearer < count && nodes.depth(nearer) < z) ++nearer;
    return nearer == 0 ? 1.0f : nodes.transmittance(nearer - 1);
}

}  // namespace ropsim
