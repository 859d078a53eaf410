// How a pixel's visibility curve is kept (Salvi et al. 2011, sections 3.1 to 3.3): how many nodes, in which
// formats, which node is removed and how, and what fragments of equal depth do.
#pragma once

#include "rop/datapath.h"
#include "rop/format.h"
#include "rop/nodes/sorted_insertion.h"
#include "rop/technique_formats.h"

#include <algorithm>
#include <cstdint>

namespace ropsim {

// What the removal of a node does to the curve (section 3.2, figure 4).
enum class Removal : std::uint8_t {
    kUnderestimate,  // the node before takes its transmittance: the curve falls earlier
    kOverestimate,   // it goes as it is: the curve falls later, behind the last node never
    kNodeByNode,     // whichever of both changes the smaller area
};

// Which nodes may be removed.
enum class Candidates : std::uint8_t {
    kPaper,             // all: equation 7
    kProtectFurthest,   // all but the last (Intel's DXAOIT below 8 nodes)
    kProtectFrontHalf,  // from 8 nodes on only the rear half but the last (Intel's DXAOIT)
};

// Fragments at a node's own depth, as the node keeps it.
enum class CoplanarRule : std::uint8_t {
    kInFront,  // each is in front of all others: the paper's step function is 1 at its own depth
    kBehind,   // each is behind all others
    kMerge,    // one node for all; each takes the mean of both
};

// How a transmittance becomes one that its format keeps.
enum class NodeRounding : std::uint8_t { kNearest, kDown, kDithered };

struct CurveRules {
    int nodes = 8;  // N
    Removal removal = Removal::kUnderestimate;
    // Of the N + 1 nodes 0..N after an insertion, those that may be removed. Underestimation needs a node
    // before: the implicit one in front of all, of transmittance 1, keeps none.
    int first_underestimated = 1;
    int first_overestimated = 0;
    int last_removable = 8;
    bool four_at_a_time = true;  // all candidates, and a number of nodes that vector code is written for
    CoplanarRule coplanar = CoplanarRule::kInFront;
    Format depth = Format::kFloat32;
    Format transmittance = Format::kFloat32;
    NodeRounding rounding = NodeRounding::kNearest;
    float empty_depth = kEmptyDepth;  // of an unused node, as its format keeps it
    float last_depth = kEmptyDepth;   // the largest depth of a used one

    // Reads removal, candidates and equal_depth.
    static CurveRules read(Parameters& parameters, int nodes);
    // The formats that nodes are stored in; without it they are kept as computed. Reads depth_format,
    // transmittance_format and transmittance_rounding.
    void read_formats(Parameters& parameters, const TechniqueFormats& formats);

    // Nothing but the insertion of the paper over values kept as computed: the plain datapath's short cut.
    bool is_plain() const {
        return removal == Removal::kUnderestimate && coplanar == CoplanarRule::kInFront &&
               depth == Format::kFloat32 && transmittance == Format::kFloat32;
    }

    // A fragment's depth as a node would keep it: it is compared as that, or a fragment could stand behind
    // its own node. A format that ends at 1 gives up its last code to mark unused nodes.
    template <class D>
    typename D::Real kept_depth(const typename D::Real& z) const {
        if (depth == Format::kFloat32) return z;
        const float kept = std::min(stored_value(depth, value_of(z)), last_depth);
        if constexpr (D::kCharged)
            return {kept, Ledger::active().charge(Unit::kConverter, z.ready)};
        else
            return kept;
    }
    // A product of transmittances as a node would keep it; `draw` is the fragment's, the same for all nodes,
    // so that a curve stays one that falls.
    template <class D>
    typename D::Real kept_transmittance(const typename D::Real& v, const typename D::Real& draw) const {
        if (transmittance == Format::kFloat32) return v;
        const float kept = rounded(value_of(v), value_of(draw));
        if constexpr (D::kCharged)
            return {kept, Ledger::active().charge(Unit::kConverter, std::max(v.ready, draw.ready))};
        else
            return kept;
    }

 private:
    float rounded(float v, float draw) const {
        if (rounding == NodeRounding::kDown) return stored_value_down(transmittance, v);
        if (rounding == NodeRounding::kDithered) return stored_value_dithered(transmittance, v, draw);
        return stored_value(transmittance, v);
    }
};

}  // namespace ropsim
