// Sums and means of what a pixel keeps a sample at a time, as trees of adders.
#pragma once

#include "rop/pixel.h"
#include "rop/sampling/sample_surfaces.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace ropsim {

// Sums terms[0..count) as a tree of adders; 0 for none.
template <class Real>
Real tree_sum(std::array<Real, kMaxElements>& terms, int count) {
    if (count == 0) return Real(0.0f);
    for (int stride = 1; stride < count; stride *= 2)
        for (int s = 0; s + stride < count; s += 2 * stride)
            terms[static_cast<std::size_t>(s)] =
                terms[static_cast<std::size_t>(s)] + terms[static_cast<std::size_t>(s + stride)];
    return terms[0];
}

template <class D>
Rgb<D> scaled(const Rgb<D>& color, const typename D::Real& factor) {
    return {color.r * factor, color.g * factor, color.b * factor};
}
template <class D>
Rgb<D> added(const Rgb<D>& a, const Rgb<D>& b) {
    return {a.r + b.r, a.g + b.g, a.b + b.b};
}

// Means over the stored samples of one pixel, and what they say about it.
class SampleMeans {
 public:
    SampleMeans() = default;
    // What it refers to must not move.
    SampleMeans(const SamplingOptions& options, const SampleSurfaces& surfaces, float empty_depth)
        : options_(&options), surfaces_(&surfaces), empty_depth_(empty_depth) {}

    // The share of a pixel's samples that no fragment took, from their depths.
    template <class D, class P>
    typename D::Real empty_share(P& pixel) const {
        using Real = typename D::Real;
        return mean_value<D>([&](int s) { return select(is_empty<D>(pixel, s), Real(1.0f), Real(0.0f)); },
                             nullptr);
    }
    // The mean over the hardware samples of value(s), a number or a colour.
    template <class D, class Value>
    typename D::Real mean_value(Value value, const float* weights) const {
        using Real = typename D::Real;
        std::array<Real, kMaxElements> terms;
        int count = 0;
        for (int s = 0; s < options_->hardware_samples; ++s) {
            if (weights == nullptr) {
                terms[static_cast<std::size_t>(count++)] = value(s);
                continue;
            }
            const float weight = weights[s % options_->spatial_samples];
            if (weight != 0.0f) terms[static_cast<std::size_t>(count++)] = value(s) * Real(weight);
        }
        const Real sum = tree_sum(terms, count);
        return weights == nullptr ? sum * Real(1.0f / static_cast<float>(options_->hardware_samples)) : sum;
    }
    template <class D, class Value>
    Rgb<D> mean(Value value, const float* weights) const {
        std::array<Rgb<D>, kMaxElements> colors;
        for (int s = 0; s < options_->hardware_samples; ++s) colors[static_cast<std::size_t>(s)] = value(s);
        const auto channel = [&](auto member) {
            return mean_value<D>([&](int s) { return colors[static_cast<std::size_t>(s)].*member; }, weights);
        };
        return {channel(&Rgb<D>::r), channel(&Rgb<D>::g), channel(&Rgb<D>::b)};
    }
    // 1 / rounds that this pixel took part in.
    template <class D, class P>
    typename D::Real rounds_share(P& pixel) const {
        using Uint = typename D::Uint;
        if (!options_->adaptive()) return typename D::Real(1.0f / static_cast<float>(options_->rounds()));
        const Uint rounds = pixel.load_bits(surfaces_->rounds) & Uint(kSettled - 1);
        return reciprocal<D>(rounds);
    }
    template <class D>
    static typename D::Real reciprocal(const typename D::Uint& n) {
        const std::uint32_t count = value_of(n);
        typename D::Real result = count == 0 ? 0.0f : 1.0f / static_cast<float>(count);
        if constexpr (D::kCharged) result.ready = Ledger::active().charge(Unit::kTable, n.ready);
        return result;
    }
    // A pixel's total transmittance.
    template <class D, class P>
    typename D::Real clear_share(P& pixel) const {
        if (!options_->total_per_sample) return pixel.load(surfaces_->total);
        return mean_value<D>([&](int s) { return pixel.load(surfaces_->total, s); }, nullptr);
    }

 protected:
    template <class D, class P>
    auto is_empty(P& pixel, int s) const {
        return typename D::Real(std::numeric_limits<float>::infinity()) <=
               far_or(pixel.load(surfaces_->depth, s));
    }
    // Formats without infinity keep an empty sample at 1.
    template <class Real>
    Real far_or(const Real& depth) const {
        if (empty_depth_ != 1.0f) return depth;
        return select(Real(1.0f) <= depth, Real(std::numeric_limits<float>::infinity()), depth);
    }

    const SamplingOptions* options_ = nullptr;
    const SampleSurfaces* surfaces_ = nullptr;

 private:
    float empty_depth_ = std::numeric_limits<float>::infinity();  // as a sample without a fragment reads
};

}  // namespace ropsim
