// Spatiotemporal blue noise (Wolfe et al. 2022): thresholds whose errors have little power at low frequencies
// both over the pixels of one slice and over the slices at one pixel.
#pragma once

#include "base/random.h"
#include "rop/sampling/mask_patterns.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace ropsim {

// A torus of 64 x 64 pixels and 64 slices, ranked by void and cluster (Ulichney 1993) with the energy of
// Wolfe et al.: two points of the same slice repel by a Gaussian of their distance in pixels, two of the same
// pixel by one of their distance in slices, all others not. Decided here: the slices take turns, one point
// each, so that each slice by itself has a threshold in each of 4,096 equal intervals. Energies are integers:
// the same values on every machine.
class BlueNoise {
 public:
    static constexpr int kSide = 64;
    static constexpr int kSlices = 64;

    // Made at the first call (about 0.15 s), thread-safe.
    static const BlueNoise& instance();

    // Uniform over [0, 2^32): (rank + 1/2) / 2^18, scaled; each rank occurs once. Coordinates and slice wrap.
    std::uint32_t threshold(std::uint32_t x, std::uint32_t y, std::uint32_t slice) const {
        return column(x, y)[slice % kSlices];
    }
    // The thresholds of all slices at one pixel.
    const std::uint32_t* column(std::uint32_t x, std::uint32_t y) const {
        return &thresholds_[((y % kSide) * kSide + x % kSide) * std::size_t{kSlices}];
    }

 private:
    BlueNoise();

    std::vector<std::uint32_t> thresholds_;  // y, x, slice
};

// The samples that a fragment of `alpha` in [0, 1] passes: sample s does if alpha 2^32 is above the threshold
// at the pixel and slice s, both moved over the torus by offsets drawn from `key`. `key` must be the same for
// all pixels of a surface (a primitive or draw, the frame's seed) and differ from surface to surface: within
// one key neighbouring pixels are blue, between keys they are independent. Samples are slices in a row; 64
// stored samples use each slice once. Alpha 1 passes all samples, alpha 0 none. `samples`: 1 to 64.
inline std::uint64_t blue_noise_mask(int samples, float alpha, int x, int y, std::uint64_t key) {
    const std::uint32_t offset = random_bits(key, 0);
    const std::uint32_t* column = BlueNoise::instance().column(
        static_cast<std::uint32_t>(x) + (offset >> 26), static_cast<std::uint32_t>(y) + (offset >> 20));
    const std::uint32_t first = offset >> 14;
    const std::uint64_t threshold = alpha_threshold(alpha);
    std::uint64_t mask = 0;
    for (std::uint32_t s = 0; s < static_cast<std::uint32_t>(samples); ++s)
        mask |= static_cast<std::uint64_t>(column[(first + s) % BlueNoise::kSlices] < threshold) << s;
    return mask;
}

}  // namespace ropsim
