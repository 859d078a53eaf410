// Removal of a node from a visibility curve that has one too many (Salvi et al. 2011, section 3.2). The error
// of a removal is the area by which it changes the curve. Underestimation of node j lowers the curve between
// j - 1 and j: (T[j-1] - T[j]) (z[j] - z[j-1]), equation 7. Overestimation raises it between j and j + 1 by
// the same height, and behind the last node up to the far plane, z = 1; the paper prints equation 7 for both.
// Of equal errors the nearest node's is taken, and of one node underestimation.
#pragma once

#include "rop/nodes/visibility_curve.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace ropsim {

// Code 2 j: node j is removed and node j - 1 takes its transmittance; 2 j + 1: node j goes as it is.
template <class D>
struct RemovalChoice {
    typename D::Uint code;

    // Whether place i takes its successor's depth or transmittance: lines of the code's decoder, a gate each.
    typename D::Bool takes_depth(int i) const {
        return decoded(static_cast<std::uint32_t>(i) >= value_of(code) / 2);
    }
    typename D::Bool takes_transmittance(int i) const {
        return decoded(static_cast<std::uint32_t>(i) + 1 >= (value_of(code) + 1) / 2);
    }

 private:
    typename D::Bool decoded(bool line) const {
        if constexpr (D::kCharged)
            return {line, Ledger::active().charge(Unit::kLogic, code.ready)};
        else
            return line;
    }
};

// The removals that the rules allow, in the order in which ties go.
template <class D>
struct RemovalErrors {
    std::array<typename D::Real, std::size_t{2} * (kMaxNodes + 1)> error;
    std::array<typename D::Uint, std::size_t{2} * (kMaxNodes + 1)> code;
    int count = 0;

    void add(const typename D::Real& e, std::size_t c) {
        error[static_cast<std::size_t>(count)] = e;
        code[static_cast<std::size_t>(count)] = static_cast<std::uint32_t>(c);
        ++count;
    }
    // A tree of comparators that keeps the first of equal errors. The code travels with the error as a binary
    // number; its muxes are charged with the error's.
    typename D::Uint least() {
        for (; count > 1; count = (count + 1) / 2) {
            const auto half = static_cast<std::size_t>(count / 2);
            for (std::size_t i = 0; i < half; ++i) {
                const auto smaller = error[2 * i + 1] < error[2 * i];
                error[i] = select(smaller, error[2 * i + 1], error[2 * i]);
                code[i] = select(smaller, code[2 * i + 1], code[2 * i]);
            }
            if (count % 2 == 1) {
                error[half] = error[2 * half];
                code[half] = code[2 * half];
            }
        }
        return code[0];
    }
};

// Which of nodes 0..N to remove.
template <class D>
RemovalChoice<D> least_error(const Curve<D>& curve, const CurveRules& rules) {
    using Real = typename D::Real;
    const bool under = rules.removal != Removal::kOverestimate;
    const bool over = rules.removal != Removal::kUnderestimate;
    RemovalErrors<D> errors;
    for (int j = over ? rules.first_overestimated : rules.first_underestimated; j <= rules.last_removable;
         ++j) {
        const auto k = static_cast<std::size_t>(j);
        const Real before = j == 0 ? Real(1.0f) : curve.transmittance[k - 1];
        const Real drop = before - curve.transmittance[k];
        if (under && j >= rules.first_underestimated)
            errors.add(drop * (curve.depth[k] - curve.depth[k - 1]), 2 * k);
        if (over)
            errors.add(drop * ((j == rules.nodes ? Real(1.0f) : curve.depth[k + 1]) - curve.depth[k]),
                       2 * k + 1);
    }
    return {errors.least()};
}

// Node i, i < N, of the curve with that node removed. To be asked for i = 0, 1, ... in this order.
template <class D>
class Compressed {
 public:
    Compressed(const Curve<D>& curve, const CurveRules& rules, const RemovalChoice<D>& choice)
        : curve_(curve), removal_(rules.removal), choice_(choice) {}

    void next() {
        const auto k = static_cast<std::size_t>(i_);
        const typename D::Bool before = moved;
        moved = choice_.takes_transmittance(i_);
        transmittance = select(moved, curve_.transmittance[k + 1], curve_.transmittance[k]);
        // Underestimation: the depths that move are those behind the first transmittance that does, and node
        // 0 stays. Overestimation: both are the same.
        if (removal_ == Removal::kUnderestimate && i_ == 0) {
            depth = curve_.depth[0];
        } else {
            const typename D::Bool takes = removal_ == Removal::kUnderestimate  ? before
                                           : removal_ == Removal::kOverestimate ? moved
                                                                                : choice_.takes_depth(i_);
            depth = select(takes, curve_.depth[k + 1], curve_.depth[k]);
        }
        ++i_;
    }

    typename D::Real depth = 0.0f;
    typename D::Real transmittance = 0.0f;
    typename D::Bool moved = false;  // the node is not what it was

 private:
    const Curve<D>& curve_;
    Removal removal_;
    RemovalChoice<D> choice_;
    int i_ = 0;
};

// Insertion and, where there are too many nodes, removal, as one sequence without a branch: a step of a list.
// `t` of the fragment, kept as computed.
template <class D>
void insert_into(Curve<D>& curve, const CurveRules& rules, const typename D::Real& z,
                 const typename D::Real& t) {
    using Real = typename D::Real;
    using Uint = typename D::Uint;
    const Insertion<D> in = inserted<D>(curve, rules, z, t, Real(0.0f));
    // Where the last node is not a used one, it goes: the one before it has the same transmittance.
    const auto n = static_cast<std::size_t>(rules.nodes);
    const auto full = in.curve.depth[n] < Real(rules.empty_depth);
    const auto last = static_cast<std::uint32_t>(2 * n);
    const RemovalChoice<D> choice = {select(full, least_error<D>(in.curve, rules).code,
                                            Uint(rules.removal == Removal::kOverestimate ? last + 1 : last))};
    Compressed<D> node(in.curve, rules, choice);
    for (std::size_t k = 0; k < n; ++k) {
        node.next();
        if (rules.coplanar == CoplanarRule::kMerge) {
            const Real merged = select(in.nearer[k], curve.transmittance[k], in.product[k]);
            curve.depth[k] = select(in.coplanar, curve.depth[k], node.depth);
            curve.transmittance[k] = select(in.coplanar, merged, node.transmittance);
        } else {
            curve.depth[k] = node.depth;
            curve.transmittance[k] = node.transmittance;
        }
    }
}

}  // namespace ropsim
