// Masks of stored samples, and dither, as pure functions: bit s of a mask is stored sample s.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>

namespace ropsim {

// The lowest `count` bits, 0 to 64.
constexpr std::uint64_t low_bits(std::uint32_t count) {
    return count >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
}

// `count` (at most `samples`) neighbouring samples from `start` (any; taken modulo `samples`) upwards, going
// on at sample 0 after the last. `samples`: 1 to 64.
constexpr std::uint64_t run_mask(int samples, std::uint32_t start, std::uint32_t count) {
    const auto n = static_cast<std::uint32_t>(samples);
    const std::uint32_t first = start % n;
    const std::uint64_t run = low_bits(count);
    const std::uint64_t wrapped = first == 0 ? 0 : run >> (n - first);
    return ((run << first) | wrapped) & low_bits(n);
}

namespace detail {
// By number of samples: the step nearest to samples / golden ratio that visits every sample.
constexpr std::array<std::uint32_t, 65> coverage_steps() {
    std::array<std::uint32_t, 65> steps{};
    for (int n = 1; n <= 64; ++n) {
        int best = 1;
        for (int step = 1; step < n; ++step) {
            const int distance = std::max(1000 * step - 618 * n, 618 * n - 1000 * step);
            const int best_distance = std::max(1000 * best - 618 * n, 618 * n - 1000 * best);
            if (std::gcd(step, n) == 1 && distance < best_distance) best = step;
        }
        steps[static_cast<std::size_t>(n)] = static_cast<std::uint32_t>(best);
    }
    return steps;
}
inline constexpr std::array<std::uint32_t, 65> kCoverageSteps = coverage_steps();
}  // namespace detail

// Alpha to coverage as fixed hardware does it: round(alpha samples) (half up) samples, the first of one fixed
// order, so that equal alphas always select the same samples and layers hide one another instead of blending.
// The order goes through the samples in steps of about samples / golden ratio, coprime to their number:
// samples switched on one after the other lie far apart, and, stored sample s lying at spatial sample s mod
// M, any M in a row lie at all M of them. `samples`: 1 to 64; alpha in [0, 1].
inline std::uint64_t alpha_to_coverage_mask(int samples, float alpha) {
    const auto n = static_cast<std::uint32_t>(samples);
    const auto count = static_cast<std::uint32_t>(static_cast<double>(alpha) * n + 0.5);
    const std::uint32_t step = detail::kCoverageSteps[n];
    std::uint64_t mask = 0;
    for (std::uint32_t i = 0; i < count; ++i) mask |= std::uint64_t{1} << (i * step % n);
    return mask;
}

// Ordered dither over 8 x 8 pixels (Bayer 1973): each of (i + 1/2) / 64, i from 0 to 63, once in each aligned
// 8 x 8 tile. In place of the random xi of R = floor(alpha S + xi), the sum of R over a tile is
// round(64 alpha S).
constexpr float dither_threshold(int x, int y) {
    const auto u = static_cast<std::uint32_t>(x);
    const auto v = static_cast<std::uint32_t>(y);
    std::uint32_t rank = 0;
    // The lowest bits of the coordinates decide the highest bits of the rank.
    for (std::uint32_t b = 0; b < 3; ++b) rank = 4 * rank + 2 * (((u ^ v) >> b) & 1u) + ((v >> b) & 1u);
    return (static_cast<float>(rank) + 0.5f) / 64.0f;
}

// The 32-bit numbers below this, and no others, are below alpha 2^32: 0 for alpha 0 and 2^32, above all of
// them, for alpha 1. Exact for every float in [0, 1].
inline std::uint64_t alpha_threshold(float alpha) {
    return static_cast<std::uint64_t>(std::ceil(static_cast<double>(alpha) * 0x1p32));
}

}  // namespace ropsim
