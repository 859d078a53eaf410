// Variance shadow maps (Donnelly and Lauritzen 2006) made from stochastic shadow maps (McGuire and Mara 2017,
// section 4.3.3): mean and mean square of depth, filtered, one fetch a look-up.
#pragma once

#include "rop/shadow/shadow_map.h"
#include "rop/shadow/variance_options.h"

#include <cstddef>
#include <vector>

namespace ropsim {

// First two moments of depth: 2 x float32 as stored, 64 bits a texel a wavelength.
struct DepthMoments {
    static constexpr int kBytes = 8;

    float mean = 1;
    float square = 1;
};

// A picture of moments, row-major from the top left.
struct MomentImage {
    int width = 0;
    int height = 0;
    std::vector<DepthMoments> texels;

    std::size_t texel(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    }
};

// Means of z and z^2 over each texel's samples; a depth beyond the far plane counts as the far plane's.
MomentImage stored_moments(const StoredShadowMap& map);

// Weights of consecutive texels along one axis, and where the first lies for output texel i: at texel
// step * i + first of the input. They sum to 1.
struct AxisKernel {
    std::vector<double> weights;
    int first = 0;
    int step = 1;

    // The centre of output texel i is the input's coordinate step * i + centre().
    double centre() const { return first + 0.5 * static_cast<double>(weights.size()); }
};

// A tent of K texels has weights proportional to (K + 1)/2 - |i|; reduction by the mean convolves it with a
// box of D.
AxisKernel conversion_kernel(const VarianceOptions& options);

// Texels of an axis of `size` texels after reduction: a last part of a group counts.
inline int reduced_size(int size, int downsample) {
    return (size + downsample - 1) / downsample;
}

// One kernel along both axes, across first, where beyond the border lies `outside`.
MomentImage filtered(const MomentImage& moments, const AxisKernel& kernel, int threads, DepthMoments outside);

// Filters and reduces a picture of moments along both axes, across first. Beyond the border lies `outside`,
// of nothing that casts a shadow. Each pass rounds what it stores to float32.
MomentImage converted(const MomentImage& moments, const VarianceOptions& options, int threads,
                      DepthMoments outside = {});

// Bound of Chebyshev and Cantelli on the share of depths that are not nearer than t: 1 where t <= mean, else
// variance / (variance + (t - mean)^2), in [0, 1]. Equality holds where depths are of two kinds, one of which
// is t itself.
double chebyshev_visibility(const DepthMoments& moments, double t, const VarianceOptions& options);

// A variance shadow map of one wavelength and the look-up. Points are in texels of the stochastic map.
class VarianceShadowMap {
 public:
    VarianceShadowMap() = default;
    VarianceShadowMap(MomentImage image, const VarianceOptions& options);

    const MomentImage& image() const { return image_; }
    // In [0, 1]. Texels beyond the border repeat it.
    double visibility(double x, double y, double z) const;
    // Texels that a look-up's fetch reads.
    int texels_a_fetch() const { return options_.bilinear ? 4 : 1; }

 private:
    const DepthMoments& at(int x, int y) const;

    MomentImage image_;
    VarianceOptions options_;
    double centre_ = 0.5;
};

}  // namespace ropsim
