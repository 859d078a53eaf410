// A pixel's nearest fragments as layers sorted by depth, and what is computed from them: insertion, the
// transmittance in front of a depth, front-to-back compositing. A layer keeps its depth and a choice of
// colour, alpha and coverage mask. Of equal depths the earlier arrival is nearer; depths are compared as
// stored. Used by the k-buffer, hybrid transparency and stochastic layered alpha blending.
#pragma once

#include "rop/nodes/sorted_insertion.h"
#include "rop/saturated.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace ropsim {

// Layers in front of a depth: the first ones. In hardware a wire a layer, in software how many.
template <class D>
struct LayersInFront;
template <>
struct LayersInFront<PlainDatapath> {
    int count = 0;
    bool test(int layer) const { return layer < count; }
};
template <>
struct LayersInFront<ChargedDatapath> {
    NodesInFront<ChargedDatapath> wires;
    const Wire<bool>& test(int layer) const { return wires[static_cast<std::size_t>(layer)]; }
};

// What a layer keeps besides its depth.
struct LayerContents {
    int color_channels = 4;  // 4: premultiplied colour with alpha; 3: straight colour; 0: none
    bool alpha = false;      // as a field of its own
    int mask_bits = 0;       // of a coverage mask, up to 64
};

class StoredLayers {
 public:
    // A layer's functional words, rounded to what they are stored as: moved about without conversion.
    template <class D>
    struct Layer {
        std::array<typename D::Uint, 7> words{};
    };

    StoredLayers() = default;
    // Declares surface "layers".
    StoredLayers(Declaration& declaration, const TechniqueFormats& formats, int layers,
                 const LayerContents& contents);

    int layers() const { return layers_; }
    template <class P>
    void fetch(P& pixel) const {
        pixel.fetch_all(depth_, layers_);
    }

    template <class D, class P>
    LayersInFront<D> in_front(P& pixel, const typename D::Real& depth, EqualDepth equal) const {
        const auto z = stored_depth<D>(pixel, depth);
        if constexpr (D::kCharged) {
            return {nodes_in_front<D>(pixel, depth_, layers_, z, equal)};
        } else {
            int count = 0;
            if (equal == EqualDepth::kFragmentBehind)
                while (count < layers_ && pixel.load(depth_, count) <= z) ++count;
            else
                while (count < layers_ && pixel.load(depth_, count) < z) ++count;
            return {count};
        }
    }
    // Whether the fragment stands behind a full list. (A layer that is not used is farther than everything.)
    template <class D>
    typename D::Bool all(const LayersInFront<D>& front) const {
        return front.test(layers_ - 1);
    }
    // All layers: those not used let everything through.
    template <class D>
    LayersInFront<D> everything() const {
        LayersInFront<D> front;
        if constexpr (D::kCharged)
            front.wires.fill(true);
        else
            front.count = layers_;
        return front;
    }
    // Whether the last layer is used.
    template <class D, class P>
    typename D::Bool full(P& pixel) const {
        return pixel.load(depth_, layers_ - 1) < typename D::Real(depths_.empty);
    }

    // The nearest layer alone.
    template <class P>
    void fetch_first(P& pixel) const {
        pixel.fetch_all(depth_, 1);
    }
    template <class P>
    auto depth(P& pixel, int layer) const {
        return pixel.load(depth_, layer);
    }
    template <class P>
    auto alpha(P& pixel, int layer) const {
        return pixel.load(alpha_, layer, alpha_channel_);
    }
    template <class P>
    auto color(P& pixel, int layer) const {
        return pixel.load_rgb(color_, layer);
    }
    template <class P>
    auto mask_word(P& pixel, int layer, int word) const {
        return pixel.load_bits(mask_, layer, word);
    }
    int mask_words() const { return mask_.channels; }

    // The converter stops short of the depth that marks a layer as unused (with UNORM formats, 1).
    template <class D, class P>
    typename D::Real stored_depth(P& pixel, const typename D::Real& depth) const {
        return depths_.kept<D>(pixel, depth_, depth);
    }

    // A layer of these values; `rgb` and `mask` as far as a layer keeps them.
    template <class D, class P>
    Layer<D> converted(P& pixel, const typename D::Real& z, const Rgb<D>& rgb, const typename D::Real& a,
                       const std::array<typename D::Uint, 2>& mask) const {
        Layer<D> layer;
        std::size_t w = 0;
        const auto put = [&](const Field& field, const typename D::Real& value) {
            layer.words[w++] = bits_of(pixel.as_stored(field, saturated(field, value)));
        };
        layer.words[w++] = bits_of(stored_depth<D>(pixel, z));
        if (contents_.color_channels > 0) {
            put(color_, rgb.r);
            put(color_, rgb.g);
            put(color_, rgb.b);
        }
        if (contents_.color_channels == 4 || contents_.alpha) put(alpha_, a);
        for (int i = 0; i < mask_.channels && contents_.mask_bits > 0; ++i)
            layer.words[w++] = mask[static_cast<std::size_t>(i)];
        return layer;
    }

    template <class D>
    typename D::Real depth(const Layer<D>& layer) const {
        return real_of(layer.words[0]);
    }
    // Colour and alpha of a layer that keeps both together.
    template <class D>
    Rgb<D> color(const Layer<D>& layer) const {
        return {real_of(layer.words[1]), real_of(layer.words[2]), real_of(layer.words[3])};
    }
    template <class D>
    typename D::Real alpha(const Layer<D>& layer) const {
        return real_of(layer.words[4]);
    }

    template <class D, class P>
    Layer<D> read(P& pixel, int i) const {
        Layer<D> layer;
        std::size_t w = 0;
        for_words([&](const Field& f, int c) { layer.words[w++] = pixel.load_bits(f, i, c); });
        return layer;
    }
    template <class D, class P>
    void put(P& pixel, int i, const Layer<D>& layer) const {
        pixel.write(depth_, i);
        store<D>(pixel, i, layer);
    }
    template <class D, class P>
    void put_if(P& pixel, const typename D::Bool& condition, int i, const Layer<D>& layer) const {
        pixel.write_if(condition, depth_, i);
        if (value_of(condition)) store<D>(pixel, i, layer);
    }
    // A mux for each 32 bits of a layer as it is stored.
    Layer<ChargedDatapath> chosen(const Wire<bool>& condition, const Layer<ChargedDatapath>& a,
                                  const Layer<ChargedDatapath>& b) const {
        int ready = condition.ready;
        for (std::size_t w = 0; w < words_; ++w)
            ready = std::max({ready, a.words[w].ready, b.words[w].ready});
        int done = ready;
        for (int i = 0; i < muxes_; ++i) done = Ledger::active().charge(Unit::kMux, ready);
        Layer<ChargedDatapath> out = condition.value ? a : b;
        for (auto& word : out.words) word.ready = done;
        return out;
    }
    static const Layer<PlainDatapath>& chosen(bool condition, const Layer<PlainDatapath>& a,
                                              const Layer<PlainDatapath>& b) {
        return condition ? a : b;
    }
    // Words of 32 bits that a layer's colour and alpha take as stored.
    int color_words() const { return color_words_; }

    // Every layer behind the fragment moves one place back, the furthest out of the list. Not of a fragment
    // behind a full list.
    template <class D, class P>
    void insert(P& pixel, const LayersInFront<D>& front, const Layer<D>& incoming) const {
        if constexpr (D::kCharged) {
            std::array<Layer<D>, kMaxNodes> old;
            for (int i = 0; i < layers_; ++i) old[static_cast<std::size_t>(i)] = read<D>(pixel, i);
            for (int i = 0; i < layers_; ++i) {
                const auto k = static_cast<std::size_t>(i);
                const Layer<D> moved = i == 0 ? incoming : chosen(front.test(i - 1), incoming, old[k - 1]);
                pixel.write_if(inverse(front.test(i)), depth_, i);
                store<D>(pixel, i, chosen(front.test(i), old[k], moved));
            }
        } else {
            for (int i = layers_ - 1; i > front.count; --i) {
                pixel.write(depth_, i);
                store<D>(pixel, i, read<D>(pixel, i - 1));
            }
            pixel.write(depth_, front.count);
            store<D>(pixel, front.count, incoming);
        }
    }
    // Product of 1 - alpha over the layers in front: a tree of multipliers.
    template <class D, class P>
    typename D::Real transmittance(P& pixel, const LayersInFront<D>& front) const {
        using Real = typename D::Real;
        std::array<Real, kMaxNodes> factor;
        int count = layers_;
        if constexpr (!D::kCharged) count = front.count;  // the others are 1
        if (count == 0) return Real(1.0f);
        for (int i = 0; i < count; ++i)
            factor[static_cast<std::size_t>(i)] =
                select(front.test(i), Real(1.0f) - alpha(pixel, i), Real(1.0f));
        for (int stride = 1; stride < count; stride *= 2)
            for (int i = 0; i + stride < count; i += 2 * stride)
                factor[static_cast<std::size_t>(i)] =
                    factor[static_cast<std::size_t>(i)] * factor[static_cast<std::size_t>(i + stride)];
        return factor[0];
    }

    // Premultiplied layers composited, nearest first: a chain, which a resolve pipelines.
    template <class D>
    struct Composite {
        Rgb<D> color{0.0f, 0.0f, 0.0f};
        typename D::Real transmittance = 1.0f;
    };
    template <class D, class P>
    Composite<D> composited(P& pixel) const {
        using Real = typename D::Real;
        Composite<D> out;
        for (int i = 0; i < layers_; ++i) {
            const Rgb<D> c = color(pixel, i);
            const Real t = out.transmittance;
            out.color = {out.color.r + t * c.r, out.color.g + t * c.g, out.color.b + t * c.b};
            out.transmittance = t * (Real(1.0f) - alpha(pixel, i));
        }
        return out;
    }

 private:
    static std::uint32_t bits_of(float value) { return stored_word(value); }
    static Wire<std::uint32_t> bits_of(const Wire<float>& value) {
        return {stored_word(value.value), value.ready};
    }

    static float real_of(std::uint32_t bits) { return word_value(bits); }
    static Wire<float> real_of(const Wire<std::uint32_t>& bits) {
        return {word_value(bits.value), bits.ready};
    }
    // Calls body(field, channel) for each functional word of a layer.
    template <class Body>
    void for_words(Body body) const {
        body(depth_, 0);
        for (int c = 0; c < contents_.color_channels; ++c) body(color_, c);
        if (contents_.alpha) body(alpha_, 0);
        if (contents_.mask_bits > 0)
            for (int c = 0; c < mask_.channels; ++c) body(mask_, c);
    }
    template <class D, class P>
    void store(P& pixel, int i, const Layer<D>& layer) const {
        std::size_t w = 0;
        for_words([&](const Field& f, int c) { pixel.put_bits(f, i, c, layer.words[w++]); });
    }

    LayerContents contents_;
    int layers_ = 0;
    std::size_t words_ = 0;  // functional ones of a layer
    int muxes_ = 0;          // words of 32 bits of a layer as stored
    int color_words_ = 0;
    NodeDepths depths_;
    Field depth_;
    Field color_;
    Field alpha_;
    int alpha_channel_ = 0;
    Field mask_;
};

}  // namespace ropsim
