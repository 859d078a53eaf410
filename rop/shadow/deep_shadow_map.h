// Exact visibility from a light through all of a trace's fragments: what stochastic shadow maps estimate.
#pragma once

#include "traces/trace.h"

#include <cstdint>
#include <limits>
#include <vector>

namespace ropsim {

// For every texel of a light's view (a pixel of its trace) the fragments that the opaque layer does not hide,
// by depth, with the transmittance behind each: a deep shadow map (Lokovic and Veach 2000) without
// compression. The opaque layer lets no light past its depth. Memory: 16 bytes a fragment, 8 bytes a texel.
class DeepShadowMap {
 public:
    // `light` must have one spatial sample a pixel (CHECK); it is left rewound. Throws UserError on a damaged
    // file.
    DeepShadowMap(TraceReader& light, int threads);

    int width() const { return width_; }
    int height() const { return height_; }
    // vis(z) of texel (x, y), inside the map: the product of 1 - alpha over the fragments with z_i < z
    // (Enderton et al. 2011, equation 3), in [0, 1]; 0 behind the opaque layer.
    double visibility(int x, int y, double z) const;
    // 1 - vis(infinity) of the texel's transparent fragments alone (equation 5).
    double total_alpha(int x, int y) const;
    // Depth of the opaque layer, +infinity where there is none.
    float opaque_depth(int x, int y) const {
        if (opaque_.empty()) return kNothing;
        return opaque_[texel(x, y)];
    }

 private:
    static constexpr float kNothing = std::numeric_limits<float>::infinity();
    struct Step {
        float z;
        double behind;  // transmittance of this fragment and all nearer ones
    };

    std::size_t texel(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
    }
    void gather(TraceReader& light);
    void sort_and_multiply(int threads);

    int width_;
    int height_;
    std::vector<std::uint64_t> start_;  // by texel, into steps_; one more at the end
    std::vector<Step> steps_;
    std::vector<float> opaque_;  // by texel; empty without an opaque layer
};

}  // namespace ropsim
