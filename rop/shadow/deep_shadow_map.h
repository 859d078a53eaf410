// Exact visibility from a light through all of a trace's fragments: what stochastic shadow maps estimate.
#pragma once

#include "traces/trace.h"

#include <algorithm>
#include <cstdint>
#include <functional>
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
    // The same with another share of light that a fragment takes than alpha, in [0, 1]; it is called once a
    // fragment, with a default Material where the trace has none. `opaque_blocks`: false if the opaque layer
    // is to be left out (what it hides still is).
    using Opacity = std::function<double(const Fragment&, const Material&)>;
    DeepShadowMap(TraceReader& light, const Opacity& opacity, bool opaque_blocks, int threads);

    int width() const { return width_; }
    int height() const { return height_; }
    // vis(z) of texel (x, y), inside the map: the product of 1 - alpha over the fragments with z_i < z
    // (Enderton et al. 2011, equation 3), in [0, 1]; 0 behind the opaque layer.
    double visibility(int x, int y, double z) const;
    // 1 - vis(infinity) of the texel's transparent fragments alone (equation 5).
    double total_alpha(int x, int y) const;
    // Mean and mean square of the nearest depth that one sample of a stochastic map keeps: that of a fragment
    // with what it takes of the light that reaches it, else `empty`.
    struct DepthMean {
        double mean = 0;
        double square = 0;
        double variance() const { return std::max(0.0, square - mean * mean); }
    };
    DepthMean depth_kept(int x, int y, double empty) const;
    // Depth of the opaque layer, +infinity where there is none or it is left out.
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

    // `channels`: of the trace, for `opacity`.
    DeepShadowMap(TraceReader& light, unsigned channels, const Opacity& opacity, bool opaque_blocks,
                  int threads);
    std::size_t texel(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
    }
    void gather(TraceReader& light, unsigned channels, const Opacity& opacity);
    void sort_and_multiply(int threads);

    int width_;
    int height_;
    std::vector<std::uint64_t> start_;  // by texel, into steps_; one more at the end
    std::vector<Step> steps_;
    std::vector<float> opaque_;  // by texel; empty without an opaque layer
};

}  // namespace ropsim
