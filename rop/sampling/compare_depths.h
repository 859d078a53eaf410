// A fragment's depth against a pixel's stored depths, as a mask of samples: the inner loop of techniques of
// stored samples in software.
#pragma once

#include "rop/stored_word.h"

#include <cstdint>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace ropsim {

enum class DepthCompare : std::uint8_t { kLess, kLessEqual };

// Bit s, below `samples` (1 to 64): whether z[s & z_mask] is less than (or equal to) the depth whose bits are
// depths[s]. `z` has z_mask + 1 values, one or at least four (repeated where a fragment has two): a power of
// two.
template <DepthCompare kCompare>
inline std::uint64_t compare_depths(const float* z, int z_mask, const std::uint32_t* depths, int samples) {
    std::uint64_t bits = 0;
    int s = 0;
#if defined(__SSE2__)
    for (; s + 4 <= samples; s += 4) {
        // A lone depth goes to all lanes by register: a store of one and a load of four would wait.
        const __m128 mine = z_mask == 0 ? _mm_set1_ps(z[0]) : _mm_loadu_ps(z + (s & z_mask));
        const __m128 stored = _mm_castsi128_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(depths + s)));
        const __m128 passes =
            kCompare == DepthCompare::kLess ? _mm_cmplt_ps(mine, stored) : _mm_cmple_ps(mine, stored);
        bits |= static_cast<std::uint64_t>(static_cast<unsigned>(_mm_movemask_ps(passes))) << s;
    }
#endif
    for (; s < samples; ++s) {
        const auto stored = word_value(depths[s]);
        const float mine = z[s & z_mask];
        const bool passes = kCompare == DepthCompare::kLess ? mine < stored : mine <= stored;
        bits |= static_cast<std::uint64_t>(passes) << s;
    }
    return bits;
}

}  // namespace ropsim
