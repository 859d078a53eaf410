// What an operation is given: the fragment and what is behind its pixel, as values on the datapath's wires.
#pragma once

#include "rop/operation.h"
#include "rop/shader_stage.h"
#include "traces/depth_test.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace ropsim {

// Where a fragment stands in the order in which things are drawn.
struct DrawOrder {
    std::uint32_t draw = 0;
    std::uint32_t primitive = 0;  // within the draw, below 2^31
};

// A fragment's attributes on the datapath's wires, all ready at the start.
template <class D>
struct FragmentInput {
    typename D::Real z;
    typename D::Real a;
    Rgb<D> premultiplied;
    typename D::Uint coverage;  // bit m: spatial sample m
    typename D::Uint
        pixel_constant;  // the technique's own word of this pixel (see Technique::pixel_constant)
    std::uint64_t key;   // of random draws: seed, pixel, draw and primitive, or as the technique keys them
    // What the technique's shader exports besides (see Technique::shade).
    std::array<typename D::Real, kMaxExports> exported;
    DrawOrder order;
    int x, y;   // the pixel
    int round;  // of a repeated pass, from 0
    int spatial_samples;
    // Depth of the fragment's plane at each spatial sample, as the rasteriser hands it down for the depth
    // test; set where the trace has more than one.
    std::array<typename D::Real, kMaxSpatialSamples> sample_z;
    DepthSlope slope;  // of that plane, a pixel; set likewise

    // The colour a shader exports to techniques that store it unmultiplied. The trace keeps only the product,
    // so it is divided out here, outside the operation: the division is the trace's, not the hardware's.
    Rgb<D> straight() const {
        const float inverse_alpha = value_of(a) > 0.0f ? 1.0f / value_of(a) : 0.0f;
        return {value_of(premultiplied.r) * inverse_alpha, value_of(premultiplied.g) * inverse_alpha,
                value_of(premultiplied.b) * inverse_alpha};
    }
    const typename D::Real& depth_at(int spatial_sample) const {
        return spatial_samples == 1 ? z : sample_z[static_cast<std::size_t>(spatial_sample)];
    }
};

// What is behind a pixel, on the datapath's wires.
template <class D>
struct Background {
    Rgb<D> mean;
    int samples = 1;
    std::array<Rgb<D>, kMaxSpatialSamples> sample;  // the first `samples`

    explicit Background(const PixelBackground& b) : mean{b.mean.r, b.mean.g, b.mean.b}, samples(b.samples) {
        for (std::size_t m = 0; m < static_cast<std::size_t>(samples); ++m)
            sample[m] = {b.sample[m].r, b.sample[m].g, b.sample[m].b};
    }
};

}  // namespace ropsim
