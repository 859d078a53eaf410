// Weighted sums of premultiplied colours in a surface: the additive blend that most techniques composite
// with.
#pragma once

#include "rop/saturated.h"
#include "rop/technique.h"

namespace ropsim {

// sum += weight * rgb, as far as binary16 goes, in the first three channels of element 0 of a fetched field;
// marks it as written. The word behind them, of the same format, is left as it is.
template <class D, class P>
void accumulate_rgb(P& pixel, const Field& field, const typename D::Real& weight, const Rgb<D>& rgb) {
#if defined(__SSE2__)
    if constexpr (!D::kCharged) {
        if (field.format == Format::kFloat16) {
            pixel.write(field);
            std::uint32_t* const words = pixel.element_words(field, 0);
            const __m128 sum = _mm_castsi128_ps(_mm_loadu_si128(reinterpret_cast<const __m128i*>(words)));
            const __m128 added = _mm_mul_ps(_mm_set1_ps(weight), _mm_setr_ps(rgb.r, rgb.g, rgb.b, 0.0f));
            const __m128 largest = _mm_set1_ps(kLargestFloat16);
            const __m128 bounded = _mm_max_ps(_mm_min_ps(_mm_add_ps(sum, added), largest),
                                              _mm_sub_ps(_mm_setzero_ps(), largest));
            const __m128i rounded = _mm_castps_si128(round_to_float16(bounded));
            _mm_storeu_si128(reinterpret_cast<__m128i*>(words), rounded);
            return;
        }
    }
#endif
    const Rgb<D> sum = pixel.load_rgb(field);
    pixel.write(field);
    pixel.put_rgb(
        field, 0,
        saturated(field, Rgb<D>{sum.r + weight * rgb.r, sum.g + weight * rgb.g, sum.b + weight * rgb.b}));
}

}  // namespace ropsim
