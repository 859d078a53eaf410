// Coverage masks of up to 64 bits as they lie in fields of layers: one or two words. Inverters are free,
// words combine in trees.
#pragma once

#include "rop/nodes/stored_layers.h"
#include "rop/sampling/random_masks.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace ropsim {

template <class D>
using MaskWords = std::array<typename D::Uint, 2>;

inline std::uint32_t complement(std::uint32_t word) {
    return ~word;
}
inline Wire<std::uint32_t> complement(const Wire<std::uint32_t>& word) {
    return {~word.value, word.ready};
}

template <class D>
MaskWords<D> words_of(const SampleMask<D>& mask, int bits) {
    return {word_of(mask, bits, 0), bits > 32 ? word_of(mask, bits, 1) : typename D::Uint(0u)};
}
// The bits of `a` that `b` has not.
template <class D>
MaskWords<D> without(const MaskWords<D>& a, const MaskWords<D>& b, int words) {
    MaskWords<D> out{0u, 0u};
    for (int w = 0; w < words; ++w) {
        const auto k = static_cast<std::size_t>(w);
        out[k] = a[k] & complement(b[k]);
    }
    return out;
}
template <class D>
typename D::Uint bit_count(const MaskWords<D>& mask, int words) {
    const auto low = population_count(mask[0]);
    return words == 1 ? low : low + population_count(mask[1]);
}
template <class D>
typename D::Bool empty(const MaskWords<D>& mask, int words) {
    using Uint = typename D::Uint;
    return (words == 1 ? mask[0] : mask[0] | mask[1]) == Uint(0u);
}

// Union of the masks of the layers in front.
template <class D, class P>
MaskWords<D> covered(const StoredLayers& layers, P& pixel, const LayersInFront<D>& front) {
    using Uint = typename D::Uint;
    MaskWords<D> out{0u, 0u};
    int count = layers.layers();
    if constexpr (!D::kCharged) count = front.count;  // the others add nothing
    if (count == 0) return out;
    for (int w = 0; w < layers.mask_words(); ++w) {
        std::array<Uint, kMaxNodes> term{};
        for (int i = 0; i < count; ++i)
            term[static_cast<std::size_t>(i)] =
                select(front.test(i), layers.mask_word(pixel, i, w), Uint(0u));
        for (int stride = 1; stride < count; stride *= 2)
            for (int i = 0; i + stride < count; i += 2 * stride)
                term[static_cast<std::size_t>(i)] =
                    term[static_cast<std::size_t>(i)] | term[static_cast<std::size_t>(i + stride)];
        out[static_cast<std::size_t>(w)] = term[0];
    }
    return out;
}

// Number of bits over all of them, as a fixed-point number becomes a float.
template <class D>
typename D::Real share(const typename D::Uint& count, int bits) {
    const float value = static_cast<float>(value_of(count)) / static_cast<float>(bits);
    if constexpr (D::kCharged)
        return {value, Ledger::active().charge(Unit::kConverter, count.ready)};
    else
        return value;
}

}  // namespace ropsim
