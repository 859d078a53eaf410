// A fragment's depths against those of the stored samples, and what a chooser of samples is given and
// answers.
#pragma once

#include "rop/sampling/compare_depths.h"
#include "rop/sampling/sample_mask.h"
#include "rop/technique_input.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace ropsim {

// A fragment's depths as the depth surface would keep them: one, or repeated to at least four.
template <class D>
struct FragmentDepths {
    std::array<typename D::Real, kMaxSpatialSamples> z;
    int z_mask = 0;  // their number less one, a power of two less one

    const typename D::Real& of(int stored_sample) const {
        return z[static_cast<std::size_t>(stored_sample & z_mask)];
    }
};

// Depths are converted as they would be stored: else a fragment would fail against its own samples.
template <class D, class P>
FragmentDepths<D> stored_depths(const FragmentInput<D>& f, P& pixel, const Field& depth) {
    FragmentDepths<D> depths;
    const int count = f.spatial_samples;
    for (int m = 0; m < count; ++m)
        depths.z[static_cast<std::size_t>(m)] = pixel.as_stored(depth, f.depth_at(m));
    if (count == 1) return depths;
    for (int m = count; m < 4; ++m)
        depths.z[static_cast<std::size_t>(m)] = depths.z[static_cast<std::size_t>(m & (count - 1))];
    depths.z_mask = std::max(count, 4) - 1;
    return depths;
}

// Those samples of `mask` where the fragment's depth compares so with the stored one.
template <DepthCompare kCompare, class D, class P>
SampleMask<D> compared(const SampleMask<D>& mask, const FragmentDepths<D>& depths, P& pixel,
                       const Field& depth, int samples) {
    SampleMask<D> result;
    if constexpr (D::kCharged) {
        for (int s = 0; s < samples; ++s) {
            const auto stored = pixel.load(depth, s);
            const auto passes =
                kCompare == DepthCompare::kLess ? depths.of(s) < stored : depths.of(s) <= stored;
            result.wires[static_cast<std::size_t>(s)] = both(mask.test(s), passes);
        }
    } else {
        result.bits =
            mask.bits & compare_depths<kCompare>(depths.z.data(), depths.z_mask, pixel.words(depth), samples);
    }
    return result;
}

// The share of a pixel's first `samples` stored samples that hold nothing nearer than each depth, compared as
// it would be stored: how much of a fragment there that has one depth in all spatial samples is seen.
inline void visible_shares(const PlainPixel& pixel, const Field& depth, int samples,
                           std::span<const float> depths, std::span<float> values) {
    for (std::size_t i = 0; i < depths.size(); ++i) {
        const float z = PlainPixel::as_stored(depth, depths[i]);
        int visible = 0;
        for (int s = 0; s < samples; ++s) visible += z <= pixel.load(depth, s) ? 1 : 0;
        values[i] = static_cast<float>(visible) / static_cast<float>(samples);
    }
}

// What a chooser says of a fragment: nothing (a control path of its own), or the samples it is written to.
template <class D>
struct SampleChoice {
    bool nothing = false;
    SampleMask<D> write;
};

// What a chooser needs of its surroundings.
template <class D, class P>
struct ChoiceInput {
    const FragmentInput<D>& fragment;
    const FragmentDepths<D>& depths;
    std::uint64_t covered;  // stored samples the fragment covers
    P& pixel;
    const Field& depth;  // surface of stored depths
    bool whole_pixel;    // fetch the depths of all samples, whatever the mask
};

}  // namespace ropsim
