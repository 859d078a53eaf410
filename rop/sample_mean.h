// The mean of a pixel's stored samples, as resolve of a multisampled target takes it.
#pragma once

#include "rop/pixel.h"

#include <array>

namespace ropsim {

// A tree of adders and one multiplication by 1 / samples: short, and exact where all samples are equal and
// their number is a power of two. `samples` in [1, kMaxElements]; they must have been fetched.
template <class D, class P>
Rgb<D> mean_of_samples(P& pixel, const Field& color, int samples) {
    std::array<Rgb<D>, kMaxElements> sum;
    for (int s = 0; s < samples; ++s) sum[static_cast<std::size_t>(s)] = pixel.load_rgb(color, s);
    for (int stride = 1; stride < samples; stride *= 2) {
        for (int s = 0; s + stride < samples; s += 2 * stride) {
            Rgb<D>& a = sum[static_cast<std::size_t>(s)];
            const Rgb<D>& b = sum[static_cast<std::size_t>(s + stride)];
            a = {a.r + b.r, a.g + b.g, a.b + b.b};
        }
    }
    const typename D::Real scale(1.0f / static_cast<float>(samples));
    return {sum[0].r * scale, sum[0].g * scale, sum[0].b * scale};
}

}  // namespace ropsim
