// Looks the receivers of a captured trace up in a coloured shadow map, wavelength by wavelength, and holds
// the visibilities against exact ones.
#pragma once

#include "analysis/shadow_filter_choice.h"
#include "analysis/shadow_map_run.h"
#include "analysis/shadowed_trace.h"
#include "rop/shadow/deep_shadow_map.h"
#include "rop/shadow/variance_shadow_map.h"
#include "traces/trace.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace ropsim {

// What the look-ups need besides the stored map, by wavelength.
struct ColoredReference {
    // The product of 1 - rho over nearer fragments: what a map of infinitely many samples says.
    std::vector<DeepShadowMap> shadow;
    // The product of 1 - alpha + alpha t: what light without caustics does. Empty where caustics are off, and
    // the two are one.
    std::vector<DeepShadowMap> transmittance;
    // Depths of the opaque layer of the light's view, kept apart; empty without one.
    std::vector<float> opaque;

    // `opaque_blocks`: the opaque layer stops light in `shadow` and `transmittance` too, as in a map that
    // holds it and is looked up texel by texel.
    ColoredReference(TraceReader& light, const ColoredShadowOptions& options, bool opaque_blocks,
                     int threads);
    float opaque_depth(std::size_t texel) const;
};

// Moments of the map of infinitely many samples, and the variance of one sample's depth.
struct ExpectedMoments {
    MomentImage moments;
    std::vector<double> variance;  // by texel
};
ExpectedMoments expected_moments(const ColoredReference& reference, std::size_t wavelength,
                                 bool empty_is_opaque, int threads);

struct WavelengthErrors {
    // Against the exact map through the same kernel. Of a variance map that is the tent over the transparent
    // fragments before the receiver's plane: the opaque layer has its own test, and is in the map only so
    // that Chebyshev's bound knows the receiver.
    VisibilityError filter;
    VisibilityError noise;          // variance: against the variance map of infinitely many samples
    VisibilityError blur;           // against the exact map at the point's own texel
    VisibilityError transmittance;  // against light without caustics through the same kernel
    double exact_sum = 0;           // of the exact visibilities through the kernel
    // Of percentage-closer look-ups of whole kernels: sum of w^2 v (1 - v) / S, the variance of S coins a
    // texel.
    double expected_variance_sum = 0;
};

// One kind of receiver. The errors are of the points that the opaque layer's shadow leaves.
struct ColoredLookups {
    std::uint64_t count = 0;      // look-ups, those outside included
    std::uint64_t outside = 0;    // of points that the light's view does not show: lit
    std::uint64_t in_shadow = 0;  // behind the opaque layer: black, one depth read
    std::uint64_t texels = 0;     // read by the others, a wavelength, without a cache
    std::array<WavelengthErrors, 3> wavelengths;

    std::uint64_t looked_up() const { return count - outside - in_shadow; }
};

struct ColoredShadowedTrace {
    ColoredLookups fragments;
    ColoredLookups opaque;
};

struct ColoredShadow {
    const ShadowMapRun& run;
    const ColoredReference& reference;
    const FilterChoice& filter;               // its closer.bias and slope_bias hold for every kind
    std::vector<VarianceShadowMap> variance;  // by wavelength; empty for percentage-closer look-ups
    std::vector<VarianceShadowMap> expected;  // the same of infinitely many samples
};

// Like cast_shadows(), colour by colour; one wavelength dims all three alike. Visibility is 0 where the
// opaque depth of the point's texel is nearer by more than the bias, else what the transparent map says.
ColoredShadowedTrace cast_colored_shadows(TraceReader& camera, const TraceHeader& light,
                                          const ColoredShadow& shadow, const ShadowReceiving& receiving,
                                          const std::string& shadowed, const std::string& exact);

}  // namespace ropsim
