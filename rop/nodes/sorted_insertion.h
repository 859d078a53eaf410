// Insertion of a fragment into a pixel's sorted list of nodes: a comparator a node, then each node chooses
// between its own value, its predecessor's and the fragment's. Used by all techniques with sorted nodes.
#pragma once

#include "rop/technique.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace ropsim {

inline constexpr int kMaxNodes = 64;
inline constexpr float kEmptyDepth = 1e30f;  // of an unused node, before its format rounds it

// Depths of a list's nodes, whose clear value marks an unused one: a format that ends at 1 gives up its last
// code for that, and a fragment at the far plane takes the code before.
struct NodeDepths {
    float empty = kEmptyDepth;  // of an unused node
    float last = kEmptyDepth;   // the largest of a used one

    NodeDepths() = default;
    explicit NodeDepths(Format format)
        : empty(stored_value(format, kEmptyDepth)),
          last(empty > 1.0f ? empty : next_stored_below(format, empty)) {}

    // A fragment's depth as its node keeps it: the converter stops short of the last code.
    template <class D, class P>
    typename D::Real kept(P& pixel, const Field& depth, const typename D::Real& z) const {
        auto stored = pixel.as_stored(depth, z);
        if constexpr (D::kCharged)
            stored.value = std::min(stored.value, last);
        else
            stored = std::min(stored, last);
        return stored;
    }
};

// Where a fragment goes that has a node's own depth. Nodes and fragments are compared as stored.
enum class EqualDepth : std::uint8_t {
    kFragmentInFront,  // the later arrival is nearer (Salvi et al. 2011; MLAB's published code)
    kFragmentBehind,   // the earlier arrival is nearer
};

// Node i of the old list is in front of the fragment: it stays at its place. The list is sorted, so these are
// the first nodes and no others.
template <class D>
using NodesInFront = std::array<typename D::Bool, kMaxNodes>;

template <class D, class P>
NodesInFront<D> nodes_in_front(P& pixel, const Field& depth, int nodes, const typename D::Real& z,
                               EqualDepth equal) {
    NodesInFront<D> front;
    for (int i = 0; i < nodes; ++i) {
        const auto stored = pixel.load(depth, i);
        front[static_cast<std::size_t>(i)] = equal == EqualDepth::kFragmentInFront ? stored < z : stored <= z;
    }
    return front;
}

// What stands at place i after the insertion: `own` and `before` are the old values at i and i - 1 (anything
// for i = 0), `incoming` the fragment's. Place `nodes` is the one that falls out of a full list: its `own` is
// not looked at.
template <class D, class T>
T after_insertion(const NodesInFront<D>& front, int nodes, int i, const T& own, const T& before,
                  const T& incoming) {
    const auto k = static_cast<std::size_t>(i);
    const T moved = i == 0 ? incoming : select(front[k - 1], incoming, before);
    return i == nodes ? moved : select(front[k], own, moved);
}

}  // namespace ropsim
