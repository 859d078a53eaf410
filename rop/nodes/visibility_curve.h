// A pixel's visibility as a falling step function of depth (Salvi et al. 2011, sections 3.1 and 3.3): nodes
// of depth and the transmittance of everything up to and including it, nearest first. Insertion of a fragment
// and look-up; what is removed when there are too many is in rop/nodes/curve_removal.h.
#pragma once

#include "rop/nodes/curve_rules.h"
#include "rop/technique.h"

#include <array>
#include <cstddef>

namespace ropsim {

// Nodes 0..N-1, and N for the moment between insertion and removal.
template <class D>
struct Curve {
    std::array<typename D::Real, kMaxNodes + 1> depth;
    std::array<typename D::Real, kMaxNodes + 1> transmittance;

    static Curve empty(const CurveRules& rules) {
        Curve curve;
        for (std::size_t k = 0; k < static_cast<std::size_t>(rules.nodes); ++k) {
            curve.depth[k] = rules.empty_depth;
            curve.transmittance[k] = 1.0f;
        }
        return curve;
    }
    template <class P>
    static Curve loaded(P& pixel, const Field& depth, const Field& transmittance, int nodes) {
        Curve curve;
        for (int i = 0; i < nodes; ++i) {
            curve.depth[static_cast<std::size_t>(i)] = pixel.load(depth, i);
            curve.transmittance[static_cast<std::size_t>(i)] = pixel.load(transmittance, i);
        }
        return curve;
    }
};

// The curve with a fragment inserted: N + 1 nodes, the last of which is a used one where there are too many.
template <class D>
struct Insertion {
    Curve<D> curve;
    // Node i of the old curve is in front of the fragment: unless removal reaches it, its bytes stay.
    std::array<typename D::Bool, kMaxNodes> nearer;
    // Transmittance of old node i once the fragment attenuates it.
    std::array<typename D::Real, kMaxNodes> product;
    typename D::Bool coplanar = false;  // a node stands at the fragment's depth; for CoplanarRule::kMerge
};

// Each node chooses between its own old value, its predecessor's multiplied by the fragment's transmittance
// `t`, and the fragment. `z` as kept.
template <class D>
Insertion<D> inserted(const Curve<D>& old, const CurveRules& rules, const typename D::Real& z,
                      const typename D::Real& t, const typename D::Real& draw) {
    using Real = typename D::Real;
    using Bool = typename D::Bool;
    Insertion<D> out;
    std::array<Bool, kMaxNodes> at_depth;
    Bool previous_nearer = true;
    Real previous_depth = z;
    Real previous_product = rules.kept_transmittance<D>(t, draw);
    for (int i = 0; i < rules.nodes; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const Bool nearer = rules.coplanar == CoplanarRule::kBehind ? old.depth[k] <= z : old.depth[k] < z;
        if (rules.coplanar == CoplanarRule::kMerge) at_depth[k] = both(inverse(nearer), old.depth[k] <= z);
        out.nearer[k] = nearer;
        out.curve.depth[k] =
            select(nearer, old.depth[k], i == 0 ? z : select(previous_nearer, z, previous_depth));
        out.curve.transmittance[k] = select(nearer, old.transmittance[k], previous_product);
        out.product[k] = rules.kept_transmittance<D>(old.transmittance[k] * t, draw);
        previous_nearer = nearer;
        previous_depth = old.depth[k];
        previous_product = out.product[k];
    }
    const auto last = static_cast<std::size_t>(rules.nodes);
    out.curve.depth[last] = select(previous_nearer, z, previous_depth);
    out.curve.transmittance[last] = previous_product;
    if (rules.coplanar == CoplanarRule::kMerge) {
        for (int count = rules.nodes; count > 1; count = (count + 1) / 2) {
            const auto half = static_cast<std::size_t>(count / 2);
            for (std::size_t i = 0; i < half; ++i) at_depth[i] = either(at_depth[2 * i], at_depth[2 * i + 1]);
            if (count % 2 == 1) at_depth[half] = at_depth[static_cast<std::size_t>(count) - 1];
        }
        out.coplanar = at_depth[0];
    }
    return out;
}

// Transmittance of the last node in front of z, 1 where there is none; `inclusive`: or at z. Nodes are
// sorted, so of two groups the farther one answers if its first node is in front: a tree of muxes.
template <class D>
typename D::Real transmittance_before(const Curve<D>& curve, int nodes, const typename D::Real& z,
                                      bool inclusive) {
    std::array<typename D::Real, kMaxNodes> value;
    std::array<typename D::Bool, kMaxNodes> nearer;
    for (std::size_t k = 0; k < static_cast<std::size_t>(nodes); ++k) {
        nearer[k] = inclusive ? curve.depth[k] <= z : curve.depth[k] < z;
        value[k] = curve.transmittance[k];
    }
    for (int stride = 1; stride < nodes; stride *= 2) {
        for (int i = 0; i + stride < nodes; i += 2 * stride) {
            const auto a = static_cast<std::size_t>(i);
            const auto b = static_cast<std::size_t>(i + stride);
            value[a] = select(nearer[b], value[b], value[a]);
        }
    }
    return select(nearer[0], value[0], typename D::Real(1.0f));
}

// What a fragment at z, kept, that has entered the curve with transmittance t is seen through. Behind others
// of its depth it is seen through all that the curve has up to there but itself; nothing is left of that to
// divide by t where it is opaque: it is then taken as in front.
template <class D>
typename D::Real visibility_of(const Curve<D>& curve, const CurveRules& rules, const typename D::Real& z,
                               const typename D::Real& t) {
    using Real = typename D::Real;
    const Real in_front = transmittance_before<D>(curve, rules.nodes, z, false);
    if (rules.coplanar == CoplanarRule::kInFront) return in_front;
    const Real inclusive = transmittance_before<D>(curve, rules.nodes, z, true);
    const auto transparent = Real(0.0f) < t;
    const Real others = minimum(in_front, inclusive / select(transparent, t, Real(1.0f)));
    const Real behind = select(transparent, others, in_front);
    return rules.coplanar == CoplanarRule::kBehind ? behind : (in_front + behind) * Real(0.5f);
}

}  // namespace ropsim
