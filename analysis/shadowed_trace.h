// Puts a light's shadow onto a captured trace: every fragment and opaque pixel is looked up in a shadow map,
// and its colour dimmed.
#pragma once

#include "rop/shadow/deep_shadow_map.h"
#include "rop/shadow/shadow_filter.h"
#include "rop/shadow/shadow_map.h"
#include "traces/trace.h"

#include <cstdint>
#include <string>

namespace ropsim {

struct ShadowReceiving {
    ShadowFilter filter;
    double ambient = 0.3;  // share of the light that no shadow takes away, 0 to 1
    std::uint64_t seed = 0;
    int threads = 1;
};

// Estimated minus exact visibility.
struct VisibilityError {
    std::uint64_t count = 0;
    double sum = 0, sum_of_squares = 0, max = 0;  // max: the largest size

    void add(double estimate, double exact);
    double mean() const { return count == 0 ? 0 : sum / static_cast<double>(count); }
    double rmse() const;
};

// One kind of receiver: transparent fragments, or samples of the opaque layer.
struct ShadowLookups {
    std::uint64_t count = 0;    // look-ups, those outside included
    std::uint64_t outside = 0;  // of points that the light's view does not show: lit
    std::uint64_t texels = 0, samples = 0, total_alphas = 0, opaque_depths = 0;  // read, without a cache
    VisibilityError noise;  // against the exact map through the same filter: what the map's randomness adds
    VisibilityError all;    // against the exact map at the point's own texel: the filter's blur too
    double exact_sum = 0;   // of the exact visibilities through the filter
};

struct ShadowedTrace {
    ShadowLookups fragments;
    ShadowLookups opaque;
};

// Writes `camera`'s trace with every colour multiplied by ambient + (1 - ambient) * visibility to `shadowed`,
// with the visibility that `map` gives, and to `exact`, with that of `deep` through the same filter. Opaque
// surfaces are looked up sample by sample; where the map is corrected they use its total alpha, and
// texels that show another surface like a fragment. Fragments
// that the opaque layer hides keep their colour and cost nothing. Both maps are of the view `light`. Values
// that are not finite are brought into range. Throws UserError on a damaged trace or a file that cannot be
// written.
ShadowedTrace cast_shadows(TraceReader& camera, const TraceHeader& light, const StoredShadowMap& map,
                           const DeepShadowMap& deep, const ShadowReceiving& receiving,
                           const std::string& shadowed, const std::string& exact);

}  // namespace ropsim
