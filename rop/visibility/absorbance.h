// Absorbance, -ln of transmittance: what opacity maps add up.
#pragma once

#include "rop/transcendental.h"

namespace ropsim {

// Of a fragment, with a floor under its transmittance, because an opaque fragment has no logarithm. Published
// shaders use a floor of 1e-5 or scale alpha by 0.99; an absorbance of 11.5 hides all but 1e-5.
class Absorbance {
 public:
    explicit Absorbance(float least_transmittance = 1e-5f) : least_(least_transmittance) {}

    // `scale` times the absorbance of alpha.
    template <class D>
    typename D::Real of(const typename D::Real& alpha, float scale = 1.0f) const {
        using Real = typename D::Real;
        const Real transmittance = maximum(Real(1.0f) - alpha, Real(least_));
        const Real logarithm = natural_log(transmittance);
        return scale == 1.0f ? negative(logarithm) : logarithm * Real(-scale);
    }

 private:
    float least_;
};

}  // namespace ropsim
