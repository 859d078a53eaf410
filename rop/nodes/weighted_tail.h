// The tail of hybrid transparency (Maule et al. 2013): fragments beyond a pixel's nearest ones summed without
// order, and composited as so many layers of their mean colour and alpha.
#pragma once

#include "rop/saturated.h"
#include "rop/technique.h"
#include "rop/technique_formats.h"
#include "rop/transcendental.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace ropsim {

// 1 - (1 - mean)^count, by the logarithm and the exponential; where these would lose the digits of a small
// mean, by their series. `mean` in [0, 1] or above by rounding, `count` whole, 0 included.
template <class D>
typename D::Real combined_alpha(const typename D::Real& mean, const typename D::Real& count) {
    using Real = typename D::Real;
    const Real series =
        mean * (Real(1.0f) + mean * (Real(1.0f / 2) + mean * (Real(1.0f / 3) + mean * Real(1.0f / 4))));
    const Real density =  // -ln(1 - mean)
        select(mean < Real(1.0f / 64), series, negative(natural_log(Real(1.0f) - mean)));
    const Real depth = count * density;
    const Real thin =
        depth * (Real(1.0f) - depth * (Real(1.0f / 2) - depth * (Real(1.0f / 6) - depth * Real(1.0f / 24))));
    const Real many = select(depth < Real(1.0f / 16), thin, Real(1.0f) - exponential(negative(depth)));
    return select(count <= Real(1.0f), mean * count, many);  // one layer is itself
}

class WeightedTail {
 public:
    template <class D>
    struct Values {
        Rgb<D> sum;  // of alpha times colour
        typename D::Real alpha;
        typename D::Real count;
    };

    WeightedTail() = default;
    // Declares surface "tail": key tail_format = packed | packed_wrapping | float16 | float32.
    WeightedTail(Declaration& declaration, Parameters& parameters, const TechniqueFormats& formats);

    template <class P>
    void fetch(P& pixel) const {
        pixel.fetch_all(first_, 1);
    }
    template <class D, class P>
    Values<D> load(P& pixel) const {
        using Uint = typename D::Uint;
        if (!packed_)
            return {pixel.load_rgb(first_), pixel.load(first_, 0, 3), real<D>(pixel.load_bits(second_), 1)};
        const Uint rgb = pixel.load_bits(first_);
        const Uint rest = pixel.load_bits(second_);
        const auto channel = [&](int shift) {
            return real<D>(shifted_right(rgb, shift) & Uint(kColorMost), kSteps);
        };
        return {{channel(0), channel(10), channel(20)},
                real<D>(rest & Uint(kAlphaMost), kSteps),
                real<D>(shifted_right(rest, 16), 1)};
    }
    // Adds one fragment. All of it is written.
    template <class D, class P>
    void add(P& pixel, const Rgb<D>& premultiplied, const typename D::Real& a) const {
        const Values<D> old = load<D>(pixel);
        const Rgb<D> sum = {old.sum.r + premultiplied.r, old.sum.g + premultiplied.g,
                            old.sum.b + premultiplied.b};
        const auto alpha = old.alpha + a;
        pixel.write(first_);
        if (!packed_) {
            const std::array<typename D::Real, 4> sums = {sum.r, sum.g, sum.b, alpha};
            for (int c = 0; c < 4; ++c)
                pixel.put(first_, 0, c, saturated(first_, sums[static_cast<std::size_t>(c)]));
            pixel.put_bits(second_, 0, 0, pixel.load_bits(second_) + typename D::Uint(1u));
            return;
        }
        // Bit fields side by side: wiring.
        const auto r = fixed<D>(sum.r, kColorMost);
        const auto g = fixed<D>(sum.g, kColorMost);
        const auto b = fixed<D>(sum.b, kColorMost);
        const auto total = fixed<D>(alpha, kAlphaMost);
        const auto count = counted<D>(shifted_right(pixel.load_bits(second_), 16));
        pixel.put_bits(first_, 0, 0, joined<D>({r, g, b}, {0, 10, 20}));
        pixel.put_bits(second_, 0, 0, joined<D>({total, count, 0u}, {0, 16, 0}));
    }

    // What the fragments of the tail are scaled by in front of the background, and what they let through.
    template <class D>
    struct Weights {
        typename D::Real scale;
        typename D::Real transmittance;
    };
    // `factor`: the published formula; else without its last factor (see techniques/hybrid.cpp).
    template <class D>
    Weights<D> weights(const Values<D>& tail, bool factor) const {
        using Real = typename D::Real;
        const auto none = tail.count <= Real(0.0f);
        const Real mean = tail.alpha / select(none, Real(1.0f), tail.count);
        const Real total = combined_alpha<D>(mean, tail.count);
        // Fragments of no alpha only add light.
        const auto clear = tail.alpha <= Real(0.0f);
        const Real divisor = select(clear, Real(1.0f), tail.alpha);
        const Real over = factor ? select(clear, Real(1.0f), total) : Real(1.0f);
        return {over / divisor, Real(1.0f) - total};
    }

 private:
    static constexpr std::uint32_t kColorMost = (1u << 10) - 1;
    static constexpr std::uint32_t kAlphaMost = (1u << 16) - 1;
    static constexpr int kSteps = 255;  // of 1

    template <class D>
    static typename D::Real real(const typename D::Uint& value, int steps) {
        const float v = static_cast<float>(value_of(value)) / static_cast<float>(steps);
        if constexpr (D::kCharged)
            return {v, Ledger::active().charge(Unit::kConverter, value.ready)};
        else
            return v;
    }
    template <class D>
    typename D::Uint fixed(const typename D::Real& value, std::uint32_t most) const {
        const float scaled =
            std::clamp<float>(value_of(value), 0.0f, 4e6f) * static_cast<float>(kSteps) + 0.5f;
        const auto whole = static_cast<std::uint32_t>(scaled);
        const std::uint32_t kept = wraps_ ? whole & most : std::min(whole, most);
        if constexpr (D::kCharged)
            return {kept, Ledger::active().charge(Unit::kConverter, value.ready)};
        else
            return kept;
    }
    template <class D>
    typename D::Uint counted(const typename D::Uint& count) const {
        using Uint = typename D::Uint;
        const Uint more = count + Uint(1u);
        if (wraps_) return more & Uint(kAlphaMost);
        return select(count == Uint(kAlphaMost), count, more);
    }
    template <class D>
    static typename D::Uint joined(const std::array<typename D::Uint, 3>& fields,
                                   const std::array<int, 3>& shifts) {
        typename D::Uint word = 0u;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t bits = value_of(fields[i]) << shifts[i];
            if constexpr (D::kCharged)
                word = {word.value | bits, std::max(word.ready, fields[i].ready)};
            else
                word |= bits;
        }
        return word;
    }

    bool packed_ = true;
    bool wraps_ = false;
    Field first_;   // packed: three sums of 10 bits; else four floats
    Field second_;  // packed: sum of alpha and count, 16 bits each; else the count
};

}  // namespace ropsim
