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

// The share of `bits` bits that a mask leaves.
template <class D>
typename D::Real uncovered(const MaskWords<D>& mask, int words, int bits) {
    using Uint = typename D::Uint;
    return share<D>(Uint(static_cast<std::uint32_t>(bits)) - bit_count<D>(mask, words), bits);
}

// Each layer by its bits that no layer in front has: the mean over stored samples of stochastic transparency.
// Layers keep straight colours.
template <class D, class P>
StoredLayers::Composite<D> composited_masks(const StoredLayers& layers, P& pixel, int bits) {
    const int words = layers.mask_words();
    MaskWords<D> front{0u, 0u};
    StoredLayers::Composite<D> out;
    for (int i = 0; i < layers.layers(); ++i) {
        MaskWords<D> own{0u, 0u};
        for (int w = 0; w < words; ++w) own[static_cast<std::size_t>(w)] = layers.mask_word(pixel, i, w);
        const auto seen = share<D>(bit_count<D>(without<D>(own, front, words), words), bits);
        const Rgb<D> c = layers.color(pixel, i);
        out.color = {out.color.r + seen * c.r, out.color.g + seen * c.g, out.color.b + seen * c.b};
        for (std::size_t w = 0; w < static_cast<std::size_t>(words); ++w) front[w] = front[w] | own[w];
    }
    out.transmittance = uncovered<D>(front, words, bits);
    return out;
}

}  // namespace ropsim
