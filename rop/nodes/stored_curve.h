// A visibility curve in a pixel's state (Salvi et al. 2011, fixed memory): its surface, the insertion of a
// fragment with its control paths, and look-up.
#pragma once

#include "rop/nodes/curve_removal.h"
#include "rop/nodes/insert_in_place.h"

#include <cstddef>
#include <cstdint>

namespace ropsim {

// Control paths of an insertion.
enum class CurveInsertion : std::uint8_t { kInserted, kCompressed, kMerged };

class StoredCurve {
 public:
    StoredCurve() = default;
    // Declares the surface "nodes". `rewrites`: every insertion writes all nodes back, as a pixel shader that
    // holds them in registers does.
    StoredCurve(Declaration& declaration, const CurveRules& rules, Layout layout, bool rewrites)
        : rules_(rules), rewrites_(rewrites), short_cut_(rules.is_plain()) {
        const auto node =
            declaration.surface("nodes", rules.nodes, layout, Initial::kClear,
                                {FieldSpec::real(rules.depth, 1, kEmptyDepth, ValueRange::kUnit),
                                 FieldSpec::real(rules.transmittance, 1, 1.0f, ValueRange::kUnit)});
        depth_ = node[0];
        transmittance_ = node[1];
    }

    const CurveRules& rules() const { return rules_; }
    // Nothing but the paper's operation on float32 nodes.
    bool is_paper() const { return short_cut_ && !rewrites_; }
    PixelNodes nodes(PlainPixel& pixel) const { return {pixel, depth_, transmittance_}; }

    template <class P>
    void fetch(P& pixel) const {
        pixel.fetch_all(depth_, rules_.nodes);
    }
    // The last node alone.
    template <class P>
    void fetch_total(P& pixel) const {
        pixel.fetch_if(typename P::D::Bool(true), depth_, rules_.nodes - 1);
    }
    template <class D, class P>
    Curve<D> loaded(P& pixel) const {
        return Curve<D>::loaded(pixel, depth_, transmittance_, rules_.nodes);
    }
    // The transmittance of everything: the last node holds it even while nodes are empty, because insertion
    // multiplies every node behind the fragment, empty ones too.
    template <class P>
    auto total(P& pixel) const {
        return pixel.load(transmittance_, rules_.nodes - 1);
    }

    // A fragment at z with transmittance t; `draw` for dithered rounding.
    template <class D, class P>
    CurveInsertion insert(D& d, const typename D::Real& z, const typename D::Real& t,
                          const typename D::Real& draw, P& pixel) const {
        using Real = typename D::Real;
        if (rewrites_)
            for (int i = 0; i < rules_.nodes; ++i) pixel.write(depth_, i);
        if constexpr (!D::kCharged) {
            if (short_cut_)
                return insert_in_place(nodes(pixel), rules_, z, t) ? CurveInsertion::kCompressed
                                                                   : CurveInsertion::kInserted;
        }
        const Curve<D> old = loaded<D>(pixel);
        const Insertion<D> in = inserted<D>(old, rules_, rules_.template kept_depth<D>(z), t, draw);
        if (rules_.coplanar == CoplanarRule::kMerge && d.decide(in.coplanar)) {
            for (int i = 0; i < rules_.nodes; ++i) {
                const auto k = static_cast<std::size_t>(i);
                put(pixel, inverse(in.nearer[k]), i, old.depth[k],
                    select(in.nearer[k], old.transmittance[k], in.product[k]));
            }
            return CurveInsertion::kMerged;
        }
        // Full when the last of the N + 1 nodes is a real one.
        const auto last = static_cast<std::size_t>(rules_.nodes);
        if (!d.decide(in.curve.depth[last] < Real(rules_.empty_depth))) {
            for (int i = 0; i < rules_.nodes; ++i) {
                const auto k = static_cast<std::size_t>(i);
                put(pixel, inverse(in.nearer[k]), i, in.curve.depth[k], in.curve.transmittance[k]);
            }
            return CurveInsertion::kInserted;
        }
        Compressed<D> node(in.curve, rules_, least_error<D>(in.curve, rules_));
        for (int i = 0; i < rules_.nodes; ++i) {
            node.next();
            const auto k = static_cast<std::size_t>(i);
            put(pixel, either(inverse(in.nearer[k]), node.moved), i, node.depth, node.transmittance);
        }
        return CurveInsertion::kCompressed;
    }

    // What a fragment at z is seen through that has entered with transmittance t.
    template <class D, class P>
    typename D::Real visibility(const typename D::Real& z, const typename D::Real& t, P& pixel) const {
        if constexpr (!D::kCharged) {
            if (short_cut_) return transmittance_in_front(nodes(pixel), rules_.nodes, z);
        }
        return visibility_of<D>(loaded<D>(pixel), rules_, rules_.template kept_depth<D>(z), t);
    }

 private:
    // Values that are already what their formats keep.
    template <class P, class B, class R>
    void put(P& pixel, const B& changed, int i, const R& z, const R& v) const {
        pixel.write_if(changed, depth_, i);
        pixel.put_bits(depth_, i, 0, stored_word(value_of(z)));
        pixel.put_bits(transmittance_, i, 0, stored_word(value_of(v)));
    }

    CurveRules rules_;
    bool rewrites_ = false;
    bool short_cut_ = false;  // insert_in_place will do
    Field depth_;
    Field transmittance_;
};

}  // namespace ropsim
